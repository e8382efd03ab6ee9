"""What keys mean where their models do not say it themselves, and where each model is explained.

A model's own word comes first. The build fails where a key has no meaning.
"""

from __future__ import annotations

from collections.abc import Mapping

SECTIONS: Mapping[str, str] = {
    "TaskSpec": "top level",
    "Timing": "timing",
    "SceneSpec": "scene",
    "RobotEntry": "robot",
    "Base": "base",
    "Home": "home",
    "NamedPosture": "posture",
    "TcpPose": "tcp pose",
    "ActionSpec": "action",
    "ObjectSpec": "object",
    "Arrangement": "arrangement",
    "Grid": "grid",
    "Shape": "shape",
    "Cylinder": "cylinder",
    "PartSpec": "part",
    "Grasp": "grasp point",
    "JointSpec": "joint",
    "Spring": "spring",
    "Lock": "lock",
    "Place": "place",
    "SiteSpec": "site",
    "Marker": "marker",
    "CameraSpec": "camera",
    "Noise": "noise",
    "Distribution": "distribution",
    "Order": "order",
    "Together": "together",
    "Wait": "wait",
    "Repeat": "repeat",
    "RobotSpec": "robot file",
    "Tcp": "tcp",
    "GripperSpec": "gripper",
    "SuctionSpec": "suction",
    "GripperJoint": "gripper joint",
}
"""Model -> heading of the section that explains it."""

_CYLINDER = "Radius and length, along z."
_CAPSULE = "A cylinder with round ends; the length is that of the straight part."
_RPY = "Orientation."

MEANINGS: Mapping[str, Mapping[str, str]] = {
    "Arrangement": {},
    "Grid": {},
    "TaskSpec": {
        "timing": "Control and physics rates, and the length of an episode.",
        "scene": "Robots, objects, sites and cameras.",
        "observation_noise": "Noise on the channels of each robot.",
        "expert": "Script that does the task, as a list of stages.",
    },
    "SceneSpec": {
        "robots": "The agents, in this order; at least one.",
        "objects": "All bodies that are not robots.",
        "sites": "Named frames without a body: goals, meeting points.",
        "cameras": "Cameras for pictures and for observations.",
    },
    "RobotEntry": {
        "base": "Pose of its base.",
        "action": "Meaning of the agent's actions.",
    },
    "Base": {"position": "Position of the base frame, in the world.", "rpy_deg": _RPY},
    "Home": {"tcp": "Pose of the tool centre point; inverse kinematics finds the joints."},
    "NamedPosture": {},
    "TcpPose": {
        "position": "Position in the world.",
        "rpy_deg": "Orientation; z is the direction of approach, so [180, 0, 0] points down.",
    },
    "ActionSpec": {
        "arm": "Action mode: what the arm's numbers mean.",
        "frame": "Frame of the translation of `tcp_delta`.",
        "turn": "How the tool may turn.",
        "max_turn_deg": "Largest turn in a control step.",
        "gripper": "Open or close, or an opening width.",
    },
    "ObjectSpec": {
        "position": "Position; either this or `place`.",
        "rpy_deg": "Orientation at `position`.",
        "place": "Region in which it is placed at random in each episode.",
        "shape": "One shape; either this or `parts`.",
        "parts": "Named primitives that make one rigid body.",
        "friction": "Lateral friction; the engine multiplies the values of two touching bodies.",
        "rolling_friction": "Rolling friction, in m: torque per newton of contact force.",
        "restitution": "Coefficient of restitution: 0 no bounce, 1 a bounce without loss of speed.",
        "color": "Colour, also for parts that do not set their own.",
        "grasps": "Points where a gripper can grasp it.",
    },
    "Shape": {"cylinder": _CYLINDER, "capsule": _CAPSULE},
    "Cylinder": {"radius": "Radius.", "length": "Length along z."},
    "PartSpec": {
        "cylinder": _CYLINDER,
        "capsule": _CAPSULE,
        "at": "Position of its centre in the body's frame.",
        "rpy_deg": "Orientation in the body's frame.",
    },
    "Grasp": {},
    "JointSpec": {},
    "Spring": {},
    "Lock": {},
    "Place": {
        "center": "Middle of the region: [x, y] on a surface, [x, y, z] without.",
        "size": "Full edge lengths of the region; 0 fixes an axis.",
    },
    "SiteSpec": {
        "position": "Position; either this or `place`.",
        "rpy_deg": "Orientation at `position`.",
        "place": "Region in which it is placed at random in each episode.",
        "marker": "Shape of the site; without one it is invisible and has no volume.",
        "color": "Colour of the marker.",
    },
    "Marker": {"cylinder": _CYLINDER},
    "CameraSpec": {
        "position": "Position in the world, or in the frame of its mount.",
        "look_at": "Point to look at, in the same frame.",
        "fov_deg": "Vertical field of view.",
    },
    "Timing": {},
    "Noise": {},
    "Distribution": {"choice": "Values to choose from, with equal probability."},
    "Order": {},
    "Together": {},
    "Wait": {},
    "Repeat": {},
    "RobotSpec": {
        "robot": "The name of the folder that the file is in.",
        "summary": "One line: manufacturer, model, joints, gripper.",
        "tcp": "The tool centre point.",
        "gripper": "Joints, fingers, stroke and force of the gripper.",
    },
    "Tcp": {
        "link": "The link that it is fixed to.",
        "position": "Position in the link's frame.",
        "rpy_deg": "Orientation in the link's frame.",
    },
    "GripperSpec": {"joints": "Every joint of the gripper that moves."},
    "SuctionSpec": {},
    "GripperJoint": {
        "open": "Position when the gripper is open, in m or rad.",
        "closed": "Position when it is closed, in m or rad.",
    },
}
"""Model -> key -> meaning."""

VALUES: Mapping[tuple[str, str], str] = {
    ("TaskSpec", "observe"): "robot → list of [channels](#observation-channels)",
    ("TaskSpec", "observation_noise"): "robot → channel → [noise](#noise)",
    ("TaskSpec", "state"): "list of [channels](#observation-channels), or the word `all`",
    ("TaskSpec", "expert"): "list of [stages](#expert)",
    ("TaskSpec", "variations"): "list of [changes](#variations-and-randomisation)",
    ("TaskSpec", "randomize"): "`thing.key` → [distribution](#distribution)",
    ("RobotEntry", "model"): "name or path",
    ("Shape", "mesh"): "path",
    ("Shape", "urdf"): "path",
    ("RobotSpec", "urdf"): "path",
    ("Order", "grasp"): "grasp point",
    ("Order", "reach"): "frame, or [x, y, z], m",
    ("Order", "turn"): "joint",
    ("Order", "slide"): "joint",
    ("Order", "posture"): "name of a posture",
    ("Order", "push"): "object",
    ("Order", "press"): "frame",
    ("Order", "bring"): "object",
    ("Order", "close"): "object, or the word `nothing`",
    ("Order", "to"): "frame, or [x, y, z], m; of a joint: m",
    ("Order", "to_deg"): "degrees",
    ("Order", "touching"): "list of objects",
    ("Together", "together"): "list of robots",
    ("Together", "bring"): "object",
    ("Together", "to"): "frame, or [x, y, z], m",
    ("Together", "touching"): "list of objects",
    ("Repeat", "stages"): "list of [stages](#expert)",
    ("Noise", "std"): "number, 0 to 100",
    ("ObjectSpec", "joints"): "joint → [joint](#joint), or a number: its start",
    ("Grasp", "link"): "name in the URDF",
}
"""Values that a type says less well than words."""

DRAWN: Mapping[str, tuple[str, str]] = {
    "gains": (
        "distribution of factors, above 0 to 2",
        "Factor of the position gain of the arm's motors, drawn in each episode.",
    ),
    "delay": (
        "choice of whole numbers, 0 to 50",
        "Control steps by which every action of the robot is carried out late, drawn in each "
        "episode.",
    ),
}
"""What `randomize` can draw for a robot: value and meaning."""
