"""Names of the numbers in observations, states and actions, such as ``left.joint_3``."""

from __future__ import annotations

from collections.abc import Sequence

from taskbuilder.schema.channels import Channel
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

POSITION = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
MATRIX = ("r11", "r21", "r31", "r12", "r22", "r32")
"""The first two columns of a rotation matrix, in the order of an observation."""

_VELOCITY = ("vx", "vy", "vz", "wx", "wy", "wz")
_FRAMES: dict[str, tuple[str, ...]] = {
    "pose": (*POSITION, *QUATERNION),
    "tcp": (*POSITION, *QUATERNION),
    "position": POSITION,
    "orientation": QUATERNION,
    "velocity": _VELOCITY,
    "tcp_velocity": _VELOCITY,
}


def joint_names(count: int, suffix: str = "") -> tuple[str, ...]:
    """Names of the joints of an arm, from the base to the wrist: ``joint_1``, ``joint_2``, ..."""
    return tuple(f"joint_{number}{suffix}" for number in range(1, count + 1))


def channel_names(channel: Channel, world: World, action: Sequence[str] = ()) -> tuple[str, ...]:
    """The name of each number of a channel, before a quaternion becomes a matrix.

    Args:
        channel: A channel of numbers, of one subject.
        world: The world, for the joints and fingers of robots.
        action: The names of the numbers of the subject's action.
    """
    subject, quantity = channel.subject, channel.quantity
    frame = "" if channel.frame == "world" else f" in {channel.frame}"
    if not subject:
        return (quantity,)
    if subject in world.robots and quantity not in _FRAMES:
        robot = world.robots[subject]
        parts = {
            "joints": joint_names(robot.dof),
            "joint_velocities": joint_names(robot.dof, "_velocity"),
            "force": _force_names(robot),
            "previous_action": tuple(f"previous_{name}" for name in action),
        }.get(quantity, (quantity,))
        return tuple(f"{subject}.{part}" for part in parts)
    if quantity not in _FRAMES:  # a joint of an object
        return (f"{subject}.{quantity}",)
    owner = f"{subject}.tcp" if quantity.startswith("tcp") else subject
    return tuple(f"{owner}.{part}{frame}" for part in _FRAMES[quantity])


def _force_names(robot: Robot) -> tuple[str, ...]:
    """The name of each force on a gripper's fingers, or of the one on a cup or a tool."""
    if not robot.model.stroke:
        return ("tool_force",)
    return tuple(f"finger_{n}_force" for n in range(1, len(robot.gripper.tips) + 1))


def with_matrix(names: Sequence[str], turns: int) -> tuple[str, ...]:
    """The names of a channel whose quaternion is replaced by two columns of the matrix.

    Args:
        names: The names with the quaternion.
        turns: Index of the first number of the quaternion.
    """
    first = names[turns]
    head, _, rest = first.rpartition(QUATERNION[0])
    return (*names[:turns], *(f"{head}{part}{rest}" for part in MATRIX))
