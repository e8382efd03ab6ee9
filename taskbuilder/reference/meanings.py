"""What keys mean where their models do not say it themselves, and where each model is explained.

A word here comes before a model's own, which findings on missing keys show too. The build fails
where a key has no meaning.
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
    "ObjectFileSpec": "object file",
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
    "GraspSpec": "grasp",
}
"""Model -> heading of the section that explains it."""

_CYLINDER = "Radius of the cylinder, and length along z."
_CAPSULE = "A cylinder with round ends; `length` does not include the ends."
_JOINTS = (
    "Positions of the arm joints, from base to wrist, in degrees, or in metres for a "
    "prismatic joint."
)
_RPY = "Orientation of the base frame, in the world."

_BODY = {
    "shape": "Shape of the object, given instead of `parts`.",
    "parts": "Named primitives that together form one rigid body, given instead of `shape`.",
    "friction": "Coefficient of lateral friction. For two bodies in contact, the engine "
    "multiplies their coefficients.",
    "rolling_friction": "Rolling friction, in m: torque per newton of contact force.",
    "restitution": "Coefficient of restitution: 0 for no bounce, 1 for no loss of speed.",
    "color": "Colour of the object, and of its parts that have no `color`.",
    "grasps": "Points at which a gripper can grasp the object, by name.",
}

MEANINGS: Mapping[str, Mapping[str, str]] = {
    "Arrangement": {},
    "Grid": {"spacing": "Distances between the centres of neighbouring objects along x and y."},
    "TaskSpec": {
        "task": "Name of the task; it must be the file name without .yaml.",
        "summary": "One sentence that states which robot does what.",
        "timing": "Control rate, physics rate and length of an episode.",
        "scene": "Robots, objects, sites and cameras.",
        "observation_noise": "Noise on the channels that each robot observes.",
        "expert": "Script that carries out the task, as a list of stages.",
    },
    "SceneSpec": {
        "robots": "The robots by name; each robot is an agent.",
        "objects": "All bodies that are not robots, by name.",
        "sites": "Frames without a body, by name, such as goals.",
        "cameras": "Cameras by name, for pictures and for observations; by default one camera "
        "named front.",
    },
    "RobotEntry": {
        "model": "Name of a robot in the catalogue, or path of a robot.yaml.",
        "base": "Pose of the robot's base, such as {position: [0, 0, 0.4]}.",
        "action": "Action mode and its settings.",
    },
    "Base": {"position": "Position of the base frame, in the world.", "rpy_deg": _RPY},
    "Home": {
        "joints_deg": _JOINTS,
        "tcp": "Pose of the tool centre point; inverse kinematics computes the joint positions.",
    },
    "NamedPosture": {"joints_deg": _JOINTS},
    "TcpPose": {
        "position": "Position in the world.",
        "rpy_deg": "Orientation in the world. The tool points along its z axis; [180, 0, 0] is "
        "down.",
    },
    "ActionSpec": {
        "arm": "Action mode: what the components of an arm's action mean.",
        "frame": "For the modes that command the tool: frame in which the action's position or "
        "translation is given. In the mode `tcp_delta`, this is also the frame of rotation "
        "vectors.",
        "turn": "Rotations of the tool that actions can command. `none`: no rotation. `yaw`: about "
        "the tool's z axis only. `full`: about all axes.",
        "max_turn_deg": "Maximum rotation in a control step.",
        "gripper": "`binary`: open or close. `continuous`: an opening width.",
    },
    "ObjectSpec": {
        "position": "Position of the object, given instead of `place`.",
        "rpy_deg": "Orientation of the object at `position`.",
        "place": "Region in which the object is placed at random in each episode.",
        **_BODY,
    },
    "ObjectFileSpec": _BODY,
    "Shape": {"cylinder": _CYLINDER, "capsule": _CAPSULE},
    "Cylinder": {"radius": "Radius of the cylinder.", "length": "Length of the cylinder along z."},
    "PartSpec": {
        "cylinder": _CYLINDER,
        "capsule": _CAPSULE,
        "at": "Position of the centre of the part, in the frame of the object.",
        "rpy_deg": "Orientation of the part, in the frame of the object.",
    },
    "Grasp": {},
    "JointSpec": {},
    "Spring": {"stiffness": "Stiffness in N/m, or N m/rad for a revolute joint."},
    "Lock": {
        "unless": "Condition of the description; the joint is free while this condition is true."
    },
    "Place": {
        "center": "Centre of the region: [x, y] with `surface`, [x, y, z] without.",
        "size": "Full edge lengths of the region; 0 fixes the position along an axis.",
    },
    "SiteSpec": {
        "position": "Position of the site, given instead of `place`.",
        "rpy_deg": "Orientation of the site at `position`.",
        "place": "Region in which the site is placed at random in each episode.",
        "marker": "Shape of the site; a site without a marker is invisible and has no volume.",
        "color": "Colour of the marker.",
    },
    "Marker": {"cylinder": _CYLINDER},
    "CameraSpec": {
        "position": "Position of the camera, in the world or in the frame of `mount`.",
        "look_at": "Point that the camera looks at, in the same frame as `position`.",
        "fov_deg": "Vertical field of view.",
    },
    "Timing": {},
    "Noise": {},
    "Distribution": {"choice": "Values to choose from, with equal probability."},
    "Order": {},
    "Together": {
        "bring": "The load, or an object that lies on the load.",
        "to": "Frame, or point in the world, to which the object is brought.",
        "touching": "Objects that the robots and the load may touch during the motion.",
        "tolerance": "Tolerance of the end position; by default 0.02.",
    },
    "Wait": {
        "until": "Name of a condition: `success`, `failure`, a stage or another condition of the "
        "description.",
    },
    "Repeat": {"repeat": "Maximum number of times that the stages are carried out."},
    "RobotSpec": {
        "robot": "Name of the robot; it must be the name of the folder that contains this file.",
        "summary": "One line that states manufacturer, model, joints and gripper.",
        "urdf": "Path of the URDF, relative to this file, or package://pybullet_data/….",
        "arm": "The joints of the arm, from base to wrist.",
        "tcp": "The tool centre point, such as {link: tool}.",
        "home_deg": f"Start configuration. {_JOINTS}",
        "gripper": "Joints, fingers, stroke and force of the gripper.",
    },
    "Tcp": {
        "link": "The link to which the tool centre point is fixed.",
        "position": "Position of the tool centre point, in the frame of `link`.",
        "rpy_deg": "Orientation of the tool centre point, in the frame of `link`.",
    },
    "GripperSpec": {
        "joints": "All movable joints of the gripper, by name.",
        "fingers": "The links that touch held objects: one list of links per finger.",
        "stroke": "Distance between the finger pads when the gripper is open, in metres.",
    },
    "GraspSpec": {},
    "SuctionSpec": {
        "cup": "The link that touches the held object.",
        "force": "Pulling force in newtons above which the suction cup lets go of an object.",
    },
    "GripperJoint": {
        "open": "Position of the joint when the gripper is open, in m or rad.",
        "closed": "Position of the joint when the gripper is closed, in m or rad.",
    },
}
"""Model -> key -> meaning."""

VALUES: Mapping[tuple[str, str], str] = {
    ("TaskSpec", "observe"): "mapping: robot → list of [channels](#observation-channels)",
    ("TaskSpec", "observation_noise"): "mapping: robot → channel → [noise](#noise)",
    ("TaskSpec", "state"): "list of [channels](#observation-channels), or the word `all`",
    ("TaskSpec", "expert"): "list of [stages](#expert)",
    ("TaskSpec", "variations"): "list of [changes](#variations-and-randomisation)",
    ("TaskSpec", "randomize"): "mapping: `NAME.KEY` → [distribution](#distribution)",
    ("RobotEntry", "model"): "name or path of a robot",
    ("RobotEntry", "grasp"): "[grasp](#grasp), or its rule",
    ("GripperSpec", "grasp"): "[grasp](task-file.md#grasp), or its rule",
    ("Shape", "mesh"): "path",
    ("Shape", "urdf"): "path",
    ("RobotSpec", "urdf"): "path",
    ("Order", "grasp"): "name of a grasp point",
    ("Order", "reach"): "name of a frame, or [x, y, z] in m",
    ("Order", "turn"): "name of a joint",
    ("Order", "slide"): "name of a joint",
    ("Order", "posture"): "name of a posture",
    ("Order", "push"): "name of an object",
    ("Order", "press"): "name of a frame",
    ("Order", "bring"): "name of an object",
    ("Order", "close"): "name of an object, or the word `nothing`",
    ("Order", "to"): "name of a frame, or [x, y, z] in m; for a joint: position in m",
    ("Order", "to_deg"): "degrees",
    ("Order", "touching"): "list of names of objects",
    ("Together", "together"): "list of names of robots",
    ("Together", "bring"): "name of an object",
    ("Together", "to"): "name of a frame, or [x, y, z] in m",
    ("Together", "touching"): "list of names of objects",
    ("Repeat", "stages"): "list of [stages](#expert)",
    ("Noise", "std"): "number, 0 to 100",
    ("Shape", "collision"): "path",
    ("ObjectSpec", "object"): "name or path of an object",
    ("ObjectFileSpec", "object"): "name",
    ("ObjectFileSpec", "joints"): "mapping: joint → [joint](task-file.md#joint), or → initial "
    "position",
    ("ObjectSpec", "joints"): "mapping: joint → [joint](#joint), or → initial position",
    ("Grasp", "link"): "name of a link in the URDF",
}
"""Values that a type says less well than words."""

DRAWN: Mapping[str, tuple[str, str]] = {
    "gains": (
        "distribution of factors above 0 and at most 2",
        "Factor by which the position gain of the arm's motors is multiplied, drawn in each "
        "episode.",
    ),
    "delay": (
        "choice of whole numbers, 0 to 50",
        "Delay of the robot's actions in control steps, drawn in each episode.",
    ),
}
"""What `randomize` can draw for a robot: value and meaning."""
