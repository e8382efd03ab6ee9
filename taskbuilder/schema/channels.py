"""The observation channels that a task file may name, and how they are written.

``self.tcp`` is the agent's own, ``right.gripper`` another robot's, ``stick.pose`` an object's,
``stick.pose in self.tcp`` the same seen from a frame, ``front.rgb`` a camera's, and ``time_left``
belongs to the episode.
"""

from __future__ import annotations

from dataclasses import dataclass

from taskbuilder.schema.names import SceneNames
from taskbuilder.wording import suggestion

ROBOT_QUANTITIES = (
    "joints",
    "joint_velocities",
    "tcp",
    "tcp_velocity",
    "gripper",
    "holding",
    "force",
    "previous_action",
)
GRIPPER_QUANTITIES = ("gripper", "holding")
"""Quantities that robots without a gripper do not have."""

POSE_QUANTITIES = ("pose", "position", "orientation")
OBJECT_QUANTITIES = (*POSE_QUANTITIES, "velocity")
CAMERA_QUANTITIES = ("rgb", "depth", "mask", "points")
EPISODE_QUANTITIES = ("time_left",)


@dataclass(frozen=True)
class Channel:
    """What an agent observes: a quantity of a subject, seen from a frame.

    Of a group, it is that of all members, one after the other.

    Attributes:
        subject: Robot, object, group, part, site or camera; "" for a quantity of the episode.
        quantity: Such as "pose", or the name of a joint of an articulated object.
        frame: Frame that poses are expressed in: "world" or a dotted frame name.
    """

    subject: str
    quantity: str
    frame: str = "world"


def parse_channel(text: str, agent: str | None, names: SceneNames) -> Channel | str:
    """The channel that a text names, or a sentence that says what is wrong with it.

    Args:
        text: As written in the task file.
        agent: Whose observation it is; "self" stands for it. None in the centralised state.
        names: The names of the scene.
    """
    what, _, frame = (part.strip() for part in text.partition(" in "))
    if what in EPISODE_QUANTITIES:
        return Channel("", what)
    subject, _, quantity = what.rpartition(".")
    if not subject:
        return f'"{what}" is no channel; write subject.quantity, such as self.tcp or stick.pose'
    if "self" in (subject, frame.partition(".")[0]) and agent is None:
        return '"self" means nothing in the state; name the robot'
    subject = _own(subject, agent)
    frame = _own(frame, agent) or "world"
    if frame != "world" and (problem := names.problem("frame", frame)):
        return problem
    allowed = _quantities(subject, names)
    if allowed is None and names.members(subject) != ():
        return _unknown(subject, names)
    if quantity not in (allowed or ()) and not _maybe_joint(subject, names):
        help_ = suggestion(quantity, allowed or (), what="it has")
        return f'"{subject}" has no "{quantity}" to observe; {help_}'
    return Channel(subject, quantity, frame)


def _own(name: str, agent: str | None) -> str:
    head, dot, rest = name.partition(".")
    return f"{agent}{dot}{rest}" if head == "self" and agent else name


def _quantities(subject: str, names: SceneNames) -> tuple[str, ...] | None:
    if members := names.members(subject):
        return _quantities(members[0], names)
    if subject in names.handless:
        return tuple(each for each in ROBOT_QUANTITIES if each not in GRIPPER_QUANTITIES)
    if subject in names.robots:
        return ROBOT_QUANTITIES
    if subject in names.objects:
        return (*OBJECT_QUANTITIES, *names.objects[subject].joints)
    if names.problem("body", subject) is None:
        return OBJECT_QUANTITIES
    if subject in names.sites or names.problem("frame", subject) is None:
        return POSE_QUANTITIES
    return CAMERA_QUANTITIES if subject in names.cameras else None


def _maybe_joint(subject: str, names: SceneNames) -> bool:
    inside = names.objects.get(subject)
    return names.members(subject) == () or (inside is not None and inside.unread)


def _unknown(subject: str, names: SceneNames) -> str:
    known = (*names.robots, *names.known("frame"), *names.cameras)
    return f'the scene has no "{subject}"; {suggestion(subject, known, what="it has")}'


def default_channels(names: SceneNames, agent: str) -> tuple[str, ...]:
    """What an agent observes where the task file says nothing: itself, and all that is there."""
    of_gripper = () if agent in names.handless else GRIPPER_QUANTITIES
    own = tuple(f"self.{quantity}" for quantity in ("joints", "tcp", *of_gripper))
    objects = tuple(f"{name}.pose" for name in names.entries)
    joints = names.known("joint")
    sites = tuple(f"{name}.position" for name in names.sites)
    return (*own, *objects, *joints, *sites, "time_left")
