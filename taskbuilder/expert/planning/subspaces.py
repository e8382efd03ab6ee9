"""What motions are made of: parts, each with coordinates of its own.

A part is a tool or load that moves along lines in the world, or an arm that moves along lines of
its joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

from taskbuilder.expert.planning.reach import Reach, between
from taskbuilder.geometry import Pose, norm, subtract, turn_between

FINE_M, FINE_TURN = 0.015, math.radians(5.0)
"""A motion is followed, and looked at, in steps of the tool no longer than these."""

FINE_JOINT = 0.035
"""The same for motions of joints, rad or m."""

METRES_PER_RADIAN = 0.15
"""How much a turn of a tool counts beside its way."""

METRES_PER_JOINT_RADIAN = 0.4
"""How much a turn of a joint counts beside the way of a tool."""

ROOM_M, ROOM_JOINT = 0.3, 1.6
"""How far beyond its ends a way may lead: metres of a frame; rad or m of a joint."""

Coordinates = tuple[float, ...]
ArmJoints = tuple[float, ...]


class Subspace(Protocol):
    """Something that moves, by coordinates of its own."""

    @property
    def arms(self) -> Mapping[str, Reach]:
        """The arms that move it."""

    @property
    def begin(self) -> Coordinates:
        """Where it is at the beginning."""

    @property
    def end(self) -> Coordinates:
        """Where it is to go."""

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Least and greatest coordinates on any way."""

    @property
    def weights(self) -> Coordinates:
        """How many metres a unit of each coordinate is worth."""

    def steps(self, begin: Coordinates, end: Coordinates) -> float:
        """How many small steps a straight motion takes."""

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """Joints of its arms at coordinates a small step away from where they were."""

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """Where its tools should be; empty where joints are commanded as they are."""


@dataclass(frozen=True)
class Carried:
    """A frame that is carried along lines in the world, by one arm or several.

    Its coordinates are its position (m) and how much of its turn is done; or, where it may only
    go straight, how much of its way.

    Attributes:
        arms: The arms that carry it.
        grasps: Where each tool is in the frame, at the beginning and at the end: how arms hold a
            load is not known better than they follow their commands.
        start: Where the frame is at the beginning.
        goal: Where it is to go.
        straight: Whether it may only go straight.
    """

    arms: Mapping[str, Reach]
    grasps: Mapping[str, tuple[Pose, Pose]]
    start: Pose
    goal: Pose
    straight: bool

    @property
    def begin(self) -> Coordinates:
        """See `Subspace.begin`."""
        return (0.0,) if self.straight else (*self.start.position, 0.0)

    @property
    def end(self) -> Coordinates:
        """See `Subspace.end`."""
        return (1.0,) if self.straight else (*self.goal.position, 1.0)

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """See `Subspace.bounds`."""
        if self.straight:
            return (0.0,), (1.0,)
        pairs = list(zip(self.start.position, self.goal.position, strict=True))
        low = (min(pair) - ROOM_M for pair in pairs)
        high = (max(pair) + ROOM_M for pair in pairs)
        return (*low, 0.0), (*high, 1.0)

    @property
    def weights(self) -> Coordinates:
        """See `Subspace.weights`."""
        turn = METRES_PER_RADIAN * turn_between(self.start.quaternion, self.goal.quaternion)
        way = norm(subtract(self.goal.position, self.start.position))
        return (way + turn,) if self.straight else (1.0, 1.0, 1.0, turn)

    def frame(self, at: Coordinates) -> Pose:
        """Where the frame is at coordinates."""
        if self.straight:
            return between(self.start, self.goal, at[0])
        x, y, z, share = at
        turned = between(self.start, self.goal, share)
        return Pose((x, y, z), turned.quaternion)

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """See `Subspace.aims`."""
        return self._known_aims(at)

    @cached_property
    def _known_aims(self) -> Callable[[Coordinates], Mapping[str, Pose]]:
        """`aims`, kept for a while: every point is asked about more than once."""
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
        """See `Subspace.steps`."""
        one, other = self.aims(begin), self.aims(end)
        return max(
            max(
                norm(subtract(other[name].position, one[name].position)) / FINE_M,
                turn_between(one[name].quaternion, other[name].quaternion) / FINE_TURN,
            )
            for name in self.arms
        )

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """See `Subspace.joints`."""
        aims = self.aims(at)
        return {name: reach.follow(before[name], aims[name]) for name, reach in self.arms.items()}


@dataclass(frozen=True)
class Jointed:
    """An arm that moves along lines of its joints, which are its coordinates.

    Attributes:
        reach: The arm.
        begin: Its joints at the beginning, rad or m.
        end: Its joints at the end.
    """

    reach: Reach
    begin: ArmJoints
    end: ArmJoints

    @property
    def arms(self) -> Mapping[str, Reach]:
        """See `Subspace.arms`."""
        return {self.reach.name: self.reach}

    @property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """See `Subspace.bounds`."""
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
        """See `Subspace.weights`."""
        turns = self.reach.arm.ik.turns
        return tuple(METRES_PER_JOINT_RADIAN if turn else 1.0 for turn in turns)

    def aims(self, at: Coordinates) -> Mapping[str, Pose]:
        """See `Subspace.aims`."""
        del at
        return {}

    def steps(self, begin: Coordinates, end: Coordinates) -> float:
        """See `Subspace.steps`."""
        return max(abs(b - a) for a, b in zip(begin, end, strict=True)) / FINE_JOINT

    def joints(self, at: Coordinates, before: Mapping[str, ArmJoints]) -> Mapping[str, ArmJoints]:
        """See `Subspace.joints`."""
        del before
        return {self.reach.name: at}
