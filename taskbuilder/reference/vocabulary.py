"""Tables of conditions, measures, reward terms and observation channels, for the pages."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, get_args, get_origin, get_type_hints

from taskbuilder import description
from taskbuilder.description import Condition, Measure, Term, WorldView
from taskbuilder.reference.markdown import code, first_sentences, table
from taskbuilder.schema import channels as spec_channels
from taskbuilder.schema.names import Refers

BASES = {"Condition": Condition, "Measure": Measure, "Term": Term}

_KINDS: Mapping[str, str] = {
    "robot": "a robot",
    "object": "an object",
    "body": "an object, a part or a link of an object: `tray`, `tray.left_handle`, "
    "`cabinet.drawer`",
    "solid": "a robot, an object, or a part or a link of an object",
    "frame": "anything with a pose: `tray`, `goal`, `left.tcp`, `left.base`, a part, a link, a "
    "grasp point",
    "site": "a site",
    "joint": "a joint of an object that is loaded from a URDF: `cabinet.drawer_joint`",
    "container": "an object, a part or a link of an object, or a site with a marker",
}
_CHANNELS: Mapping[str, str] = {
    "joints": "positions of the arm's joints, rad or m",
    "joint_velocities": "velocities of the arm's joints, rad/s or m/s",
    "tcp": "pose of the tool centre point",
    "tcp_velocity": "linear and angular velocity of the tool centre point, m/s and rad/s",
    "gripper": "opening of the gripper, from 0 (closed) to 1 (open)",
    "holding": "1 while the robot holds an object or a movable link of a fixed object, otherwise 0",
    "force": "contact force of each finger, N",
    "previous_action": "action of the previous control step",
    "pose": "position and orientation",
    "position": "position, m",
    "orientation": "orientation",
    "velocity": "linear and angular velocity, m/s and rad/s",
    "rgb": "colour image",
    "depth": "depth image",
    "mask": "segmentation mask: a number at each pixel; `env.mask_names` has its name",
    "points": "point cloud",
    "time_left": "fraction of the episode that remains, from 1 to 0",
}


def nodes(base: str) -> str:
    """A table of the public subclasses of Condition, Measure or Term: signature and meaning.

    Raises:
        ValueError: There are none.
    """
    rows = [
        [code(_call(name, thing)), first_sentences(thing.__doc__)]
        for name, thing in _public()
        if is_a(thing, base)
    ]
    if not rows:
        raise ValueError(f"no {base} is public")
    return table([base.lower(), "what it is"], sorted(rows))


def kinds(_: str) -> str:
    """A table of the annotations for names, and what each stands for."""
    rows = [[code(name), meaning] for name, meaning in named().items()]
    return table(["annotation", "a name of"], rows)


@cache
def named() -> Mapping[str, str]:
    """What each annotation for names stands for: ``ObjectName`` for an object."""
    return {
        name: _KINDS[extra.kind]
        for name, thing in _public()
        if get_origin(thing) is Annotated
        for extra in get_args(thing)
        if isinstance(extra, Refers)
    }


def view(_: str) -> str:
    """A table of what a custom condition can read from the world."""
    rows = []
    for name, member in vars(WorldView).items():
        if name.startswith("_"):
            continue
        asked = member.fget if isinstance(member, property) else member
        call = f"world.{name}" + ("" if isinstance(member, property) else _parameters(asked))
        rows.append([code(call), first_sentences(asked.__doc__)])
    return table(["attribute or method", "value"], rows)


def channels(_: str) -> str:
    """A table of the observation channels.

    Raises:
        LookupError: One has no explanation.
    """
    rows = []
    last = ""
    for subject, quantity, meaning in quantities():
        rows.append([subject if subject != last else "", code(quantity), meaning])
        last = subject
    return table(["subject", "quantity", "what it is"], rows)


def quantities() -> Iterator[tuple[str, str, str]]:
    """Subject, quantity and meaning of every channel."""
    groups = (
        ("a robot: `self`, `left`", spec_channels.ROBOT_QUANTITIES),
        ("an object or a part", spec_channels.OBJECT_QUANTITIES),
        ("a site, or another frame", spec_channels.POSE_QUANTITIES),
        ("a camera", spec_channels.CAMERA_QUANTITIES),
        ("none", spec_channels.EPISODE_QUANTITIES),
    )
    for subject, named in groups:
        yield from ((subject, quantity, _CHANNELS[quantity]) for quantity in named)


def _public() -> Iterator[tuple[str, object]]:
    return ((name, getattr(description, name)) for name in description.__all__)


def is_a(thing: object, base: str) -> bool:
    """Whether a public thing is a kind of Condition, Measure or Term."""
    wanted = BASES[base]
    if inspect.isfunction(thing):  # makes one, and reads like a class
        return get_type_hints(thing).get("return") is wanted
    return isinstance(thing, type) and issubclass(thing, wanted) and thing is not wanted


def _call(name: str, thing: object) -> str:
    if not callable(thing):
        raise TypeError(f"{name} cannot be called")
    return name + _parameters(thing)


def _parameters(thing: object) -> str:
    """The parameters without their annotations."""
    if not callable(thing):
        return ""
    signature = inspect.signature(thing)
    bare = [
        parameter.replace(annotation=inspect.Parameter.empty)
        for parameter in signature.parameters.values()
        if parameter.name != "self"
    ]
    return str(signature.replace(parameters=bare, return_annotation=inspect.Signature.empty))
