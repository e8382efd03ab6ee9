"""Conditions on positions, orientations and motions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import Literal

from taskbuilder.description.axes import SignedAxis, axis_problems, direction, tilt_deg
from taskbuilder.description.figures import beside, meters
from taskbuilder.description.node import (
    BodyName,
    Condition,
    ContainerName,
    FrameName,
    Memory,
    Parts,
    Step,
)
from taskbuilder.description.view import WorldView
from taskbuilder.geometry import dot, norm, subtract, turn_between
from taskbuilder.schema.names import SceneNames

AXES = ("xyz", "xy", "xz", "yz", "x", "y", "z")


@dataclass(frozen=True)
class Near(Condition):
    """The distance between two frames, along the given world axes, is at most ``within`` metres."""

    first: FrameName
    second: FrameName
    _: KW_ONLY
    within: float
    axes: Literal["xyz", "xy", "xz", "yz", "x", "y", "z"] = "xyz"

    def holds(self, world: WorldView) -> bool:
        return self._gap(world) <= self.within

    def _gap(self, world: WorldView) -> float:
        apart = subtract(world.position(self.first), world.position(self.second))
        return math.hypot(*(apart["xyz".index(axis)] for axis in self.axes))

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        now, bound = meters(self._gap(world), self.within)
        along = "" if self.axes == "xyz" else f" along {' and '.join(self.axes)}"
        return f"{now}{along}, {'within' if wanted else 'more than'} {bound} is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _positive("within", self.within, "metres")
        if self.axes not in AXES:
            yield f"axes is {self.axes!r}; one of {', '.join(AXES)}"


@dataclass(frozen=True)
class Inside(Condition):
    """A body is inside a container.

    If the container is a site, the centre of the body's bounding box must be at least ``margin``
    metres inside the bounding box of the site's marker.

    If the container is an object, a part or a link, the bounding boxes of the body and of the
    container are compared along the axes of the container. Along x and y, the box of the body must
    be at least ``margin`` metres inside the box of the container. Along z, the lowest point of the
    body's box must be between the bottom and the top of the container's box.
    """

    body: BodyName
    container: ContainerName
    _: KW_ONLY
    margin: float = 0.0

    def holds(self, world: WorldView) -> bool:
        room, box = world.box(self.container), world.box(self.body)
        room_from_body = world.pose(self.container).inverse() @ world.pose(self.body)
        center = room_from_body.apply(box.center)
        if not world.is_solid(self.container):
            return room.contains(center, self.margin)
        if any(abs(center[i] - room.center[i]) > room.half[i] for i in (0, 1)):
            return False  # as nearly always, and found out without the outline
        outline = box.seen_from(room_from_body)
        within = all(
            outline.low[i] >= room.low[i] + self.margin
            and outline.high[i] <= room.high[i] - self.margin
            for i in (0, 1)
        )
        return within and room.low[2] <= outline.low[2] < room.high[2]

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        if not wanted:
            return "it is inside"
        room, box = world.box(self.container), world.box(self.body)
        room_from_body = world.pose(self.container).inverse() @ world.pose(self.body)
        if not world.is_solid(self.container):
            center = room_from_body.apply(box.center)
            beyond = max(
                abs(center[i] - room.center[i]) - room.half[i] + self.margin for i in range(3)
            )
            return f"its centre is {100 * beyond:.1f} cm too far out"
        outline = box.seen_from(room_from_body)
        aside = max(
            max(room.low[i] + self.margin - outline.low[i] for i in (0, 1)),
            max(outline.high[i] - room.high[i] + self.margin for i in (0, 1)),
        )
        said = [f"its outline is {100 * aside:.1f} cm too far out"] if aside > 0 else []
        if outline.low[2] >= room.high[2]:
            over = 100 * (outline.low[2] - room.high[2])
            said.append(f"its lowest point is {over:.1f} cm above the rim")
        elif outline.low[2] < room.low[2]:
            under = 100 * (room.low[2] - outline.low[2])
            said.append(f"its lowest point is {under:.1f} cm below the floor")
        return ", ".join(said) or "it is not inside"

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.margin >= 0:
            yield f"margin is {self.margin}; metres, 0 or more"
        if self.body == self.container:
            yield "nothing is inside itself; name a container and what is put into it"


@dataclass(frozen=True)
class Above(Condition):
    """A frame is at least ``height`` metres above `reference` (by default, the world's origin)."""

    frame: FrameName
    reference: FrameName | None = None
    _: KW_ONLY
    height: float

    def holds(self, world: WorldView) -> bool:
        return _height(world, self.frame, self.reference) >= self.height

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        now, bound = meters(_height(world, self.frame, self.reference), self.height)
        return f"{now} high, {'at least' if wanted else 'less than'} {bound} is needed"


@dataclass(frozen=True)
class Below(Condition):
    """A frame is less than ``height`` metres above `reference` (by default, the world's origin)."""

    frame: FrameName
    reference: FrameName | None = None
    _: KW_ONLY
    height: float

    def holds(self, world: WorldView) -> bool:
        return _height(world, self.frame, self.reference) < self.height

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        now, bound = meters(_height(world, self.frame, self.reference), self.height)
        return f"{now} high, {'less than' if wanted else 'at least'} {bound} is needed"


def _height(world: WorldView, frame: str, reference: str | None) -> float:
    return world.position(frame)[2] - (world.position(reference)[2] if reference else 0.0)


@dataclass(frozen=True)
class Beyond(Condition):
    """A frame is at least ``by`` metres beyond a reference frame, along an axis of the reference.

    For example, ``Beyond("block", "gate", axis="x")`` is true if the block's origin is on the side
    of the gate's origin to which the gate's x axis points. With ``axis="-x"``, the block must be on
    the opposite side.
    """

    frame: FrameName
    reference: FrameName
    _: KW_ONLY
    axis: SignedAxis = "x"
    by: float = 0.0

    def holds(self, world: WorldView) -> bool:
        return self._ahead(world) >= self.by

    def _ahead(self, world: WorldView) -> float:
        apart = subtract(world.position(self.frame), world.position(self.reference))
        return dot(direction(world.pose(self.reference), self.axis), apart)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        now, bound = meters(self._ahead(world), self.by)
        return f"{now} beyond it, {'at least' if wanted else 'less than'} {bound} is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from axis_problems(self.axis)
        if self.frame == self.reference:
            yield "nothing is beyond itself; name two frames"


@dataclass(frozen=True)
class Upright(Condition):
    """An axis of a frame points up, to within ``within_deg`` degrees.

    For example, ``Upright("cup", within_deg=10, axis="-z")`` is true if the cup is upside down.
    """

    frame: FrameName
    _: KW_ONLY
    within_deg: float
    axis: SignedAxis = "z"

    def holds(self, world: WorldView) -> bool:
        up = direction(world.pose(self.frame), self.axis)[2]
        return up >= math.cos(math.radians(self.within_deg))

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        tilt = tilt_deg(world.pose(self.frame), self.axis)
        now, bound = beside(tilt, self.within_deg, "°")
        return f"tilted by {now}, {'within' if wanted else 'more than'} {bound} is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _positive("within_deg", self.within_deg, "degrees")
        yield from axis_problems(self.axis)


def Level(frame: FrameName, *, within_deg: float) -> Condition:  # noqa: N802  # reads as one
    """A frame's z axis points up, to within ``within_deg`` degrees."""
    return Upright(frame, within_deg=within_deg)


@dataclass(frozen=True)
class Moved(Condition):
    """A frame is at least ``by`` metres away from its position after the reset."""

    frame: FrameName
    _: KW_ONLY
    by: float

    def start(self, world: WorldView) -> Memory:
        """The initial position."""
        return world.position(self.frame)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return math.dist(world.position(self.frame), memory) >= self.by, memory

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        now, bound = meters(math.dist(world.position(self.frame), memory), self.by)
        return f"moved by {now}, {'at least' if wanted else 'less than'} {bound} is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _positive("by", self.by, "metres")


@dataclass(frozen=True)
class Turned(Condition):
    """A frame is rotated by at least ``by_deg`` degrees from its orientation after the reset."""

    frame: FrameName
    _: KW_ONLY
    by_deg: float

    def start(self, world: WorldView) -> Memory:
        """The initial orientation."""
        return world.pose(self.frame).quaternion

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        turn = turn_between(memory, world.pose(self.frame).quaternion)
        return math.degrees(turn) >= self.by_deg, memory

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        turn = math.degrees(turn_between(memory, world.pose(self.frame).quaternion))
        now, bound = beside(turn, self.by_deg, "°")
        return f"turned by {now}, {'at least' if wanted else 'less than'} {bound} is needed"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _positive("by_deg", self.by_deg, "degrees")


@dataclass(frozen=True)
class Stationary(Condition):
    """A body or tool moves slower than ``speed`` m/s and turns slower than ``turn_deg`` °/s."""

    frame: FrameName
    _: KW_ONLY
    speed: float = 0.01
    turn_deg: float = 10.0

    def holds(self, world: WorldView) -> bool:
        linear, angular = world.velocity(self.frame)
        return norm(linear) < self.speed and math.degrees(norm(angular)) < self.turn_deg

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        linear, angular = world.velocity(self.frame)
        if not wanted:
            return "it stands still"
        said = []
        if norm(linear) >= self.speed:
            now, bound = beside(100.0 * norm(linear), 100.0 * self.speed, "cm/s")
            said.append(f"moves at {now}, less than {bound} is needed")
        if math.degrees(norm(angular)) >= self.turn_deg:
            now, bound = beside(math.degrees(norm(angular)), self.turn_deg, "°/s")
            said.append(f"turns at {now}, less than {bound} is needed")
        return ", ".join(said)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _positive("speed", self.speed, "m/s")
        yield from _positive("turn_deg", self.turn_deg, "degrees a second")


def _positive(name: str, value: float, unit: str) -> Iterator[str]:
    if not value > 0:
        yield f"{name} is {value}; {unit}, more than 0"
