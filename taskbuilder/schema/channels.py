"""The observation channels that a task file may name, and how they are written.

``self.tcp`` is the agent's own, ``right.gripper`` another robot's, ``stick.pose`` an object's,
``stick.pose in self.tcp`` the same seen from a frame, ``front.rgb`` a camera's, and ``time_left``
belongs to the episode.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from taskbuilder.extensions import CHANNELS
from taskbuilder.schema.names import NameProblem, SceneNames
from taskbuilder.wording import closest, suggestion

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

OWN = (
    *(f"robot.{quantity}" for quantity in ROBOT_QUANTITIES),
    *(f"object.{quantity}" for quantity in OBJECT_QUANTITIES),
    *(f"frame.{quantity}" for quantity in POSE_QUANTITIES),
    *(f"camera.{quantity}" for quantity in CAMERA_QUANTITIES),
    *(f"episode.{quantity}" for quantity in EPISODE_QUANTITIES),
)
"""The library's own channels, by the kind of the subject and the quantity.

Other packages add channels under such names: ``robot.manipulability`` is a quantity of robots. A
``frame`` is a site, or a frame of a robot or an object.
"""

EXTENSIBLE = ("robot", "object", "frame", "episode")
"""Kinds of subjects for which packages can add channels."""


@dataclass(frozen=True)
class Channel:
    """What an agent observes: a quantity of a subject, seen from a frame.

    Of a group, it is that of all members, one after the other.

    Attributes:
        subject: Robot, object, group, part, site or camera; "" for a quantity of the episode.
        quantity: Such as "pose", or the name of a joint of an articulated object.
        frame: Frame that poses are expressed in: "world" or a dotted frame name.
        added: Of a channel that another package adds: its kind of subject, and the quantity, such
            as "robot.manipulability"; otherwise "".
    """

    subject: str
    quantity: str
    frame: str = "world"
    added: str = ""


def parse_channel(text: str, agent: str | None, names: SceneNames) -> Channel | NameProblem:
    """The channel that a text names, or what is wrong with it.

    Args:
        text: As written in the task file.
        agent: Whose observation it is; "self" stands for it. None in the centralised state.
        names: The names of the scene.
    """
    what, _, frame = (part.strip() for part in text.partition(" in "))
    if what in EPISODE_QUANTITIES:
        return Channel("", what)
    subject, _, quantity = what.rpartition(".")
    if not subject and quantity in _added("episode"):
        return _addition(Channel("", quantity, frame or "world"), "episode")
    if not subject:
        message = f'"{what}" is no channel; write subject.quantity, such as self.tcp or stick.pose'
        return NameProblem(message)
    if "self" in (subject, frame.partition(".")[0]) and agent is None:
        return NameProblem('"self" means nothing in the state; name the robot')
    written, subject = subject, _own(subject, agent)
    frame = _own(frame, agent) or "world"
    if frame != "world" and (problem := names.problem("frame", frame)):
        return NameProblem(problem.message)
    allowed = _quantities(subject, names)
    if allowed is None and names.members(subject) != ():
        known = (*names.robots, *names.known("frame"), *names.cameras)
        message = f'the scene has no "{subject}"; {suggestion(subject, known, what="it has")}'
        near = closest(subject, known)
        return NameProblem(message, near and text.replace(written, near, 1))
    if quantity not in (allowed or ()) and not _maybe_joint(subject, names):
        help_ = suggestion(quantity, allowed or (), what="it has")
        message = f'"{subject}" has no "{quantity}" to observe; {help_}{_misnamed(quantity)}'
        near = closest(quantity, allowed or ())
        return NameProblem(message, near and text.replace(what, f"{written}.{near}", 1))
    channel, kind = Channel(subject, quantity, frame), _kind(subject, names)
    if kind and quantity not in _own_quantities(kind, subject, names) and quantity in _added(kind):
        return _addition(channel, kind)
    return channel


def _addition(channel: Channel, kind: str) -> Channel | NameProblem:
    """A channel that a package adds, or a sentence that says that two packages do."""
    name = f"{kind}.{channel.quantity}"
    twice = CHANNELS.problem(name, OWN)
    return NameProblem(twice) if twice else replace(channel, added=name)


def _added(kind: str) -> tuple[str, ...]:
    """The quantities that packages add for a kind of subject."""
    names = (name.partition(".") for name in CHANNELS.declared() if name not in OWN)
    return tuple(quantity for of, _, quantity in names if of == kind and of in EXTENSIBLE)


def _misnamed(quantity: str) -> str:
    """A hint at a package that declares a quantity under a name that leads nowhere, or ""."""
    for name, (part, *_) in CHANNELS.declared().items():
        kind, _, last = name.rpartition(".")
        if last == quantity and kind not in EXTENSIBLE:
            wanted = ", ".join(f"{each}.{quantity}" for each in EXTENSIBLE)
            return f"; {part} must be declared as one of {wanted}"
    return ""


def _own(name: str, agent: str | None) -> str:
    head, dot, rest = name.partition(".")
    return f"{agent}{dot}{rest}" if head == "self" and agent else name


def _quantities(subject: str, names: SceneNames) -> tuple[str, ...] | None:
    """What can be observed of a subject; None if the scene has no such subject."""
    if members := names.members(subject):
        return _quantities(members[0], names)
    kind = _kind(subject, names)
    return (*_own_quantities(kind, subject, names), *_added(kind)) if kind else None


def _kind(subject: str, names: SceneNames) -> str | None:
    if members := names.members(subject):
        return _kind(members[0], names)
    if subject in names.robots:
        return "robot"
    if subject in names.objects or names.problem("body", subject) is None:
        return "object"
    if subject in names.sites or names.problem("frame", subject) is None:
        return "frame"
    return "camera" if subject in names.cameras else None


def _own_quantities(kind: str, subject: str, names: SceneNames) -> tuple[str, ...]:
    """The library's own quantities of a subject, and the joints of an object."""
    if subject in names.handless:
        return tuple(each for each in ROBOT_QUANTITIES if each not in GRIPPER_QUANTITIES)
    if kind == "object":
        joints = names.objects[subject].joints if subject in names.objects else ()
        return (*OBJECT_QUANTITIES, *joints)
    return {"robot": ROBOT_QUANTITIES, "frame": POSE_QUANTITIES, "camera": CAMERA_QUANTITIES}[kind]


def _maybe_joint(subject: str, names: SceneNames) -> bool:
    inside = names.objects.get(subject)
    return names.members(subject) == () or (inside is not None and inside.unread)


def default_channels(names: SceneNames, agent: str) -> tuple[str, ...]:
    """What an agent observes where the task file says nothing: itself, and all that is there."""
    of_gripper = () if agent in names.handless else GRIPPER_QUANTITIES
    own = tuple(f"self.{quantity}" for quantity in ("joints", "tcp", *of_gripper))
    objects = tuple(f"{name}.pose" for name in names.entries)
    joints = names.known("joint")
    sites = tuple(f"{name}.position" for name in names.sites)
    return (*own, *objects, *joints, *sites, "time_left")
