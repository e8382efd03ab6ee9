"""From the loaded body of a robot to a robot with motors and an end effector."""

from __future__ import annotations

from collections.abc import Sequence

from taskbuilder.kinematics.chain import Chain
from taskbuilder.schema.grasping import Grasping
from taskbuilder.schema.robots import RobotModel
from taskbuilder.sim.body import Body
from taskbuilder.sim.motors import Motors
from taskbuilder.world.attaching import AttachingFingers
from taskbuilder.world.end_effector import EndEffector, Tool
from taskbuilder.world.fingers import Fingers
from taskbuilder.world.robot import Robot
from taskbuilder.world.suction import Suction

ARM_EFFORT = 100.0  # N m or N, for URDFs that state none
RIGID_EFFORT = 1e4  # of arms that only carry what is tried
ARM_SPEED = 3.14  # rad/s or m/s, likewise
ARM_GAIN = 0.5  # with targets interpolated over a control step: 5 mm of lag, no overshoot


def arm_chain(model: RobotModel) -> Chain:
    """The kinematics of a robot's arm, base link to tcp."""
    spec = model.spec
    return Chain.of(model.urdf, spec.arm, spec.tcp.link, spec.tcp.pose, posture=model.home)


def build_robot(
    body: Body,
    name: str,
    model: RobotModel,
    *,
    chain: Chain,
    home: Sequence[float],
    grasping: Grasping | None,
    rigid: bool = False,
) -> Robot:
    """A robot at home.

    Args:
        body: Its body.
        name: Its name in the scene.
        model: What it is.
        chain: Its arm's kinematics.
        home: Joint positions that it starts from, in rad or m.
        grasping: How its fingers hold objects; None without fingers.
        rigid: Whether the motors of its arm are as strong as it takes, whatever the URDF says.
    """
    joints = [body.joints[joint] for joint in model.spec.arm]
    arm = Motors(
        body,
        [joint.index for joint in joints],
        forces=[RIGID_EFFORT if rigid else joint.effort or ARM_EFFORT for joint in joints],
        velocities=[joint.velocity or ARM_SPEED for joint in joints],
        position_gain=ARM_GAIN,
    )
    end = _build_end(body, model, grasping)
    robot = Robot(name, model, body, chain, arm, end, tuple(home))
    robot.go_home()
    return robot


def _build_end(body: Body, model: RobotModel, how: Grasping | None) -> EndEffector:
    if model.spec.gripper is not None and how is not None:
        fingers = Fingers(body, model, model.spec.gripper)
        attaches = how.rule == "attach"
        return AttachingFingers(body, fingers, how, model.spec.tcp) if attaches else fingers
    if model.spec.suction is not None:
        return Suction(body, model.spec.suction, model.spec.tcp)
    return Tool(body.links[model.spec.tcp.link])
