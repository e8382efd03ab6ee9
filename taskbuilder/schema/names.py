"""What the names in a task can stand for, and what to say when one stands for nothing.

Robots, objects, sites and cameras share one space of names. A dotted name goes one level in:
``left.tcp``, ``tray.left_handle`` (a part or a link), ``stick.left_end`` (a grasp point),
``cabinet.drawer_joint`` (a joint).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from taskbuilder.wording import closest, suggestion

Kind = Literal[
    "robot",
    "object",
    "body",
    "solid",
    "surface",
    "site",
    "frame",
    "container",
    "grasp",
    "joint",
    "camera",
]
"""Kinds of reference.

``body``: an object or one of its parts. ``solid``: that, or a robot. ``surface``: as ``body``.
``frame``: anything with a pose.
``container``: what something can be inside of, a body or a site with a marker.
"""

ROBOT_FRAMES = ("tcp", "base")


@dataclass(frozen=True)
class Refers:
    """Marks a field, key or parameter whose text is a name in the scene.

    Attributes:
        kind: What the name stands for.
        besides: A word that may stand there without being a name.
        several: Whether a group may stand there, for all of its members.
    """

    kind: Kind
    besides: str | None = None
    several: bool = False


class NameProblem(NamedTuple):
    """What is wrong with a reference.

    Attributes:
        message: What is wrong, and what to do about it.
        meant: The reference that was probably meant, if any is like it.
    """

    message: str
    meant: str | None = None


@dataclass(frozen=True)
class ObjectNames:
    """The names inside one object.

    Attributes:
        parts: Named parts of a compound, or the links of a URDF.
        grasps: Named grasp points.
        joints: Joints of a URDF that move, and their type.
        fixed: Joints of a URDF that do not move.
        unread: Its URDF could not be read, so any part or joint may be in it.
    """

    parts: tuple[str, ...] = ()
    grasps: tuple[str, ...] = ()
    joints: Mapping[str, str] = field(default_factory=dict)
    fixed: tuple[str, ...] = ()
    unread: bool = False


@dataclass(frozen=True)
class SceneNames:
    """All names of a scene.

    Attributes:
        robots: The robots.
        objects: The objects, members of groups among them, and the names inside each.
        sites: The sites, and whether each has a marker, hence a volume.
        cameras: The cameras.
        groups: The members of each group; none where its count cannot be read.
        handless: The robots that have no gripper.
    """

    robots: tuple[str, ...]
    objects: Mapping[str, ObjectNames]
    sites: Mapping[str, bool]
    cameras: tuple[str, ...] = ()
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    handless: tuple[str, ...] = ()

    @property
    def entries(self) -> tuple[str, ...]:
        """The objects, with groups in place of their members."""
        home = {one: group for group, members in self.groups.items() for one in members}
        return tuple(dict.fromkeys(home.get(name, name) for name in self.objects))

    def known(self, kind: Kind) -> tuple[str, ...]:
        """Every reference of a kind that resolves, short names first."""
        return tuple(dict.fromkeys(_KNOWN[kind](self)))

    def members(self, name: str) -> tuple[str, ...] | None:
        """What a group's name stands for, also a dotted one; None if it is no group's."""
        owner, dot, inner = name.partition(".")
        if owner not in self.groups:
            return None
        return tuple(f"{member}{dot}{inner}" for member in self.groups[owner])

    def problem(self, kind: Kind, name: str, *, several: bool = False) -> NameProblem | None:
        """What is wrong with a reference, or None if it resolves.

        Args:
            kind: What the name has to stand for.
            name: The name.
            several: Whether a group may stand there, for all of its members.
        """
        members = self.members(name)
        if members is not None:
            return self._problem_of_group(kind, name, members, several=several)
        known = self.known(kind)
        if name in known or self._may_be(kind, name):
            return None
        if name in self.known("robot") and kind == "frame":
            return NameProblem(
                f'"{name}" is a robot; name a frame of it: {name}.tcp or {name}.base'
            )
        plural = "bodies" if kind == "body" else f"{kind}s"
        if any(name in self.known(other) for other in _KNOWN):
            return NameProblem(f'"{name}" is no {kind}; {suggestion(name, known, what=plural)}')
        owner, _, inner = name.partition(".")
        if kind == "joint" and owner in self.objects and inner in self.objects[owner].fixed:
            moving = ", ".join(each for each in known if each.startswith(f"{owner}."))
            return NameProblem(f'"{name}" is fixed; joints that move: {moving or "none"}')
        if inner and owner in (*self.objects, *self.robots):
            own = [other.partition(".")[2] for other in known if other.startswith(f"{owner}.")]
            has = suggestion(inner, own, what="it has") if own else f"it has no {plural}"
            near = closest(inner, own)
            meant = f"{owner}.{near}" if near else None
            return NameProblem(f'"{owner}" has no {kind} "{inner}"; {has}', meant)
        group, _, number = owner.rpartition("_")
        if number.isdigit() and (ours := self.groups.get(group)):
            span = f"{ours[0]} to {ours[-1]}"
            return NameProblem(f'"{group}" has no member "{owner}"; it has {span}')
        message = f'the scene has no "{name}"; {suggestion(name, known, what="it has")}'
        return NameProblem(message, closest(name, known))

    def _problem_of_group(
        self, kind: Kind, name: str, members: tuple[str, ...], *, several: bool
    ) -> NameProblem | None:
        if not members:
            return None  # what is wrong with it has been reported
        first = members[0]
        problem = self.problem(kind, first)
        inside = [known for known in self.known(kind) if known.startswith(f"{first}.")]
        if problem is not None and (several or not inside):
            group, one = name.partition(".")[0], first.partition(".")[0]
            meant = problem.meant and problem.meant.replace(one, group, 1)
            return NameProblem(problem.message.replace(f'"{one}', f'"{group}'), meant)
        if several:
            return None
        one = first if problem is None else inside[0]
        count = len(members)
        return NameProblem(
            f'"{name}" is a group of {count} objects; name one of them, such as {one}'
        )

    def joint_type(self, name: str) -> str | None:
        """The type of a joint (such as "prismatic"), or None where it is not known."""
        owner, _, joint = (self.members(name) or (name,))[0].partition(".")
        inside = self.objects.get(owner)
        return inside.joints.get(joint) if inside else None

    def _may_be(self, kind: Kind, name: str) -> bool:
        owner, _, inner = name.partition(".")
        inside = self.objects.get(owner)
        group, _, number = owner.rpartition("_")
        if number.isdigit() and self.groups.get(group) == ():
            return True
        lives_inside = kind in ("body", "solid", "surface", "frame", "container", "joint")
        return bool(inner and inside and inside.unread and lives_inside)


def _parts(names: SceneNames) -> Iterable[str]:
    return (f"{name}.{part}" for name, inside in names.objects.items() for part in inside.parts)


def _grasps(names: SceneNames) -> Iterable[str]:
    return (f"{name}.{grasp}" for name, inside in names.objects.items() for grasp in inside.grasps)


def _joints(names: SceneNames) -> Iterable[str]:
    return (f"{name}.{joint}" for name, inside in names.objects.items() for joint in inside.joints)


def _bodies(names: SceneNames) -> Iterable[str]:
    return (*names.objects, *_parts(names))


def _solids(names: SceneNames) -> Iterable[str]:
    return (*names.robots, *_bodies(names))


def _frames(names: SceneNames) -> Iterable[str]:
    robots = (f"{robot}.{frame}" for robot in names.robots for frame in ROBOT_FRAMES)
    return (*names.objects, *names.sites, *robots, *_parts(names), *_grasps(names))


def _containers(names: SceneNames) -> Iterable[str]:
    return (*_bodies(names), *(site for site, marked in names.sites.items() if marked))


_KNOWN: Mapping[Kind, Callable[[SceneNames], Iterable[str]]] = {
    "robot": lambda names: names.robots,
    "object": lambda names: names.objects,
    "body": _bodies,
    "solid": _solids,
    "surface": _bodies,
    "site": lambda names: names.sites,
    "frame": _frames,
    "container": _containers,
    "grasp": _grasps,
    "joint": _joints,
    "camera": lambda names: names.cameras,
}
