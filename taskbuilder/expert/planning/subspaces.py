"""Parts of motions, each with coordinates of its own.

A part is a tool or load that moves along lines in the world, or an arm that moves along lines in
joint space.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

from taskbuilder.expert.planning.reach import Reach, between
from taskbuilder.geometry import (
    Pose,
    Vec3,
    add,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
)

FINE_M, FINE_TURN = 0.015, math.radians(5.0)
"""Maximum step of the tool (m, rad) when a motion is followed and checked."""

FINE_JOINT = 0.035
"""Maximum step of a joint when a motion is followed and checked, rad or m."""

METRES_PER_RADIAN = 0.15
"""Weight of a tool's rotation against its translation."""

METRES_PER_JOINT_RADIAN = 0.4
"""Weight of a joint's rotation against a tool's translation."""

ROOM_M, ROOM_JOINT = 0.3, 1.6
"""Margin of the search space beyond the ends: metres for a frame; rad or m for a joint."""

Coordinates = tuple[float, ...]
"""Coordinates of a part, or of all parts of a motion."""

Polyline = list[Coordinates]
"""Corners of a path, connected by straight segments."""

ArmJoints = tuple[float, ...]


class Subspace(Protocol):
    """The interface of a moving part with coordinates of its own."""

    @property
    def arms(self) -> Mapping[str, Reach]:
        """The arms that move it."""

    @property
    def begin(self) -> Coordinates:
        """Coordinates at the start."""

    @property
    def end(self) -> Coordinates:
        """Coordinates at the goal."""

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Lower and upper bounds of the coordinates on any path."""

    @property
    def weights(self) -> Coordinates:
        """The length in metres of a unit of each coordinate."""

    def steps(self, begin: Coordinates, end: Coordinates) -> float:
        """The number of small steps of a straight motion."""

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """Joint positions of its arms after a small step to given coordinates."""

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """Target poses of the tools in the world; empty if the joints are commanded directly."""


@dataclass(frozen=True)
class Arc:
    """A turn about an axis of the world.

    Attributes:
        center: A point of the axis.
        axis: Its direction, a unit vector.
        angle: In rad.
        turns: Whether what moves along the arc turns too.
    """

    center: Vec3
    axis: Vec3
    angle: float
    turns: bool = True

    def pose(self, start: Pose, share: float) -> Pose:
        """Where a frame is after a share of the turn, from where it starts."""
        half = 0.5 * share * self.angle
        turn = (*scale(self.axis, math.sin(half)), math.cos(half))
        position = add(self.center, rotate(turn, subtract(start.position, self.center)))
        return Pose(position, multiply(turn, start.quaternion) if self.turns else start.quaternion)


@dataclass(frozen=True)
class Carried:
    """A frame that is carried along lines in the world, by one arm or several.

    Its coordinates are its position (m) and the completed fraction of its rotation. If only the
    straight path is allowed, its coordinate is the completed fraction of that.

    Attributes:
        arms: The arms that carry it.
        grasps: Pose of each tool in the frame, at the start and at the end. They differ because
            arms follow their commands with an error.
        start: Pose of the frame at the start.
        goal: Goal of the frame.
        straight: Whether only the straight path is allowed.
        arc: The arc that takes the place of the straight path, or None.
    """

    arms: Mapping[str, Reach]
    grasps: Mapping[str, tuple[Pose, Pose]]
    start: Pose
    goal: Pose
    straight: bool
    arc: Arc | None = None

    @property
    def begin(self) -> Coordinates:
        """Coordinates at the start."""
        return (0.0,) if self.straight else (*self.start.position, 0.0)

    @property
    def end(self) -> Coordinates:
        """Coordinates at the goal."""
        return (1.0,) if self.straight else (*self.goal.position, 1.0)

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Lower and upper bounds of the coordinates on any path."""
        if self.straight:
            return (0.0,), (1.0,)
        pairs = list(zip(self.start.position, self.goal.position, strict=True))
        low = (min(pair) - ROOM_M for pair in pairs)
        high = (max(pair) + ROOM_M for pair in pairs)
        return (*low, 0.0), (*high, 1.0)

    @property
    def weights(self) -> Coordinates:
        """The length in metres of a unit of each coordinate."""
        turn = METRES_PER_RADIAN * turn_between(self.start.quaternion, self.goal.quaternion)
        distance = norm(subtract(self.goal.position, self.start.position))
        if self.arc is not None:
            distance = max(distance, abs(self.arc.angle) * METRES_PER_RADIAN)
        return (distance + turn,) if self.straight else (1.0, 1.0, 1.0, turn)

    def frame(self, at: Coordinates) -> Pose:
        """The pose of the frame at coordinates."""
        if self.arc is not None:
            return self.arc.pose(self.start, at[0])
        if self.straight:
            return between(self.start, self.goal, at[0])
        x, y, z, share = at
        turned = between(self.start, self.goal, share)
        return Pose((x, y, z), turned.quaternion)

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """Target poses of the tools in the world; empty if the joints are commanded directly."""
        return self._known_aims(at)

    @cached_property
    def _known_aims(self) -> Callable[[Coordinates], Mapping[str, Pose]]:
        """`aims` with a cache, since every point is evaluated more than once."""
        return lru_cache(maxsize=256)(self._aims)

    def _aims(self, at: Coordinates) -> Mapping[str, Pose]:
        frame = self.frame(at)
        aims = {}
        for name, reach in self.arms.items():
            begin, end = self.grasps[name]
            grasp = end if begin is end else between(begin, end, at[-1])
            aims[name] = reach.commandable(frame @ grasp)
        return aims

    def steps(self, begin: Coordinates, end: Coordinates) -> float:
        """The number of small steps of a straight motion."""
        one, other = self.aims(begin), self.aims(end)
        arc = abs(self.arc.angle * (end[0] - begin[0])) / FINE_TURN if self.arc else 0.0
        return max(
            max(
                arc,
                norm(subtract(other[name].position, one[name].position)) / FINE_M,
                turn_between(one[name].quaternion, other[name].quaternion) / FINE_TURN,
            )
            for name in self.arms
        )

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """Joint positions of its arms after a small step to given coordinates."""
        aims = self.aims(at)
        return {name: reach.follow(before[name], aims[name]) for name, reach in self.arms.items()}


@dataclass(frozen=True)
class Jointed:
    """An arm that moves along lines in joint space; its joints are its coordinates.

    Attributes:
        reach: The arm.
        begin: Joint positions at the start, rad or m.
        end: Joint positions at the end.
    """

    reach: Reach
    begin: ArmJoints
    end: ArmJoints

    @property
    def arms(self) -> Mapping[str, Reach]:
        """The arms that move the part."""
        return {self.reach.name: self.reach}

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Lower and upper bounds of the coordinates on any path."""
        ik = self.reach.arm.ik
        ends = list(zip(self.begin, self.end, strict=True))
        low = (min(pair) - ROOM_JOINT for pair in ends)
        high = (max(pair) + ROOM_JOINT for pair in ends)
        return (
            tuple(max(pair) for pair in zip(low, ik.lower, strict=True)),
            tuple(min(pair) for pair in zip(high, ik.upper, strict=True)),
        )

    @property
    def weights(self) -> Coordinates:
        """The length in metres of a unit of each coordinate."""
        turns = self.reach.arm.ik.turns
        return tuple(METRES_PER_JOINT_RADIAN if turn else 1.0 for turn in turns)

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """Target poses of the tools in the world; empty if the joints are commanded directly."""
        del at
        return {}

    def steps(self, begin: Coordinates, end: Coordinates) -> float:
        """The number of small steps of a straight motion."""
        return max(abs(b - a) for a, b in zip(begin, end, strict=True)) / FINE_JOINT

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """Joint positions of its arms after a small step to given coordinates."""
        del before
        return {self.reach.name: at}
