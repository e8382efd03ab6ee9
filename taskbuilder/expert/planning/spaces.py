"""The space that is searched for a way: the parts of a motion, side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from taskbuilder.expert.planning.clearance import Posture
from taskbuilder.expert.planning.reach import Reach
from taskbuilder.expert.planning.subspaces import ArmJoints, Carried, Coordinates, Subspace
from taskbuilder.geometry import Pose, norm, subtract, turn_between

OFF_M, OFF_TURN = 0.01, math.radians(6.0)
"""How far off its line a tool may be on the way."""

NEAR_M, NEAR_TURN = 0.004, math.radians(3.0)
"""How near to its goal a tool must come."""


@dataclass(frozen=True)
class Off:
    """How far a tool is from where it should be.

    Attributes:
        robot: Whose tool; "" where none should be anywhere.
        distance: In metres.
        turn: In rad.
    """

    robot: str = ""
    distance: float = 0.0
    turn: float = 0.0

    @property
    def badness(self) -> float:
        """What tells the furthest."""
        return self.distance / OFF_M + self.turn / OFF_TURN

    @property
    def astray(self) -> bool:
        """Whether it is too far off on the way."""
        return self.distance > OFF_M or self.turn > OFF_TURN

    @property
    def late(self) -> bool:
        """Whether it is too far off at the goal."""
        return self.distance > NEAR_M or self.turn > NEAR_TURN

    def __str__(self) -> str:
        return f"{self.distance * 100.0:.1f} cm and {math.degrees(self.turn):.0f}°"


@dataclass(frozen=True)
class Waypoint:
    """A point of the composite space, reached along some way.

    Attributes:
        at: Coordinates of all parts.
        posture: What the arms do there.
        off: The tool that is furthest from where it should be.
    """

    at: Coordinates
    posture: Posture
    off: Off = Off()


@dataclass(frozen=True)
class Space:
    """Several parts that move at the same time."""

    parts: Sequence[Subspace]

    @cached_property
    def reaches(self) -> Mapping[str, Reach]:
        """The arms that move."""
        return {name: reach for part in self.parts for name, reach in part.arms.items()}

    @cached_property
    def begin(self) -> Coordinates:
        """Where everything is at the beginning."""
        return tuple(value for part in self.parts for value in part.begin)

    @cached_property
    def end(self) -> Coordinates:
        """Where everything is to go."""
        return tuple(value for part in self.parts for value in part.end)

    @cached_property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Least and greatest coordinates on any way."""
        low, high = zip(*(part.bounds for part in self.parts), strict=True)
        return tuple(x for own in low for x in own), tuple(x for own in high for x in own)

    @cached_property
    def weights(self) -> NDArray[np.float64]:
        """(n,) how many metres a unit of each coordinate is worth."""
        return np.array([weight for part in self.parts for weight in part.weights])

    @property
    def rigid(self) -> bool:
        """Whether all its parts may only go straight."""
        return all(isinstance(part, Carried) and part.straight for part in self.parts)

    @cached_property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the parts that are straightened together: all, then one by one."""
        count = len(self.parts)
        singles = [(number,) for number in range(count)] if count > 1 else []
        return (tuple(range(count)), *singles)

    def length(self, line: Sequence[Coordinates]) -> float:
        """Length of a line with corners, m: that of the part with the furthest way, each time."""
        ways = np.diff(np.array(line), axis=0) * self.weights
        squares = np.add.reduceat(ways * ways, self._firsts, axis=1)
        return float(np.sqrt(squares.max(axis=1)).sum())

    def straightened(self, line: Sequence[Coordinates], parts: Sequence[int]) -> list[Coordinates]:
        """Points of a line, with some parts going straight from its beginning to its end."""
        own = np.array(line)
        ends = [*self._firsts[1:], len(own[0])]
        shares = np.linspace(0.0, 1.0, len(own))[:, None]
        for number in parts:
            piece = slice(self._firsts[number], ends[number])
            own[1:-1, piece] = (own[0] + shares * (own[-1] - own[0]))[1:-1, piece]
        return [tuple(point) for point in own.tolist()]

    def start(self, joints: Mapping[str, ArmJoints]) -> Waypoint:
        """The point where the arms have some joints."""
        return Waypoint(self.begin, self.posture({name: joints[name] for name in self.reaches}))

    def posture(self, joints: Mapping[str, ArmJoints]) -> Posture:
        """What the arms do at joints."""
        return Posture(joints, {name: self.reaches[name].tool(q) for name, q in joints.items()})

    def line(self, start: Waypoint, end: Coordinates, coarse: float = 1.0) -> Iterator[Waypoint]:
        """Small steps along a straight line, from a point (not given) to coordinates.

        Args:
            start: Where to begin.
            end: Where to go.
            coarse: How much longer than fine the steps are.
        """
        pieces = zip(self.parts, self._split(start.at), self._split(end), strict=True)
        fine = max(part.steps(one, other) for part, one, other in pieces)
        count = max(1, math.ceil(fine / coarse - 1e-6))
        point = start
        for step in range(1, count):
            share = step / count
            at = tuple(a + share * (b - a) for a, b in zip(start.at, end, strict=True))
            point = self.step(point, at)
            yield point
        yield self.step(point, end)

    def step(self, before: Waypoint, at: Coordinates) -> Waypoint:
        """The point at coordinates a small step away."""
        joints: dict[str, ArmJoints] = {}
        tools: dict[str, Pose] = {}
        worst = Off()
        for part, own in zip(self.parts, self._split(at), strict=True):
            joints |= part.joints(own, before.posture.joints)
            tools |= {name: reach.tool(joints[name]) for name, reach in part.arms.items()}
            for name, aim in part.aims(own).items():
                worst = max(worst, _off(name, tools[name], aim), key=lambda off: off.badness)
        return Waypoint(at, Posture(joints, tools), worst)

    @cached_property
    def _firsts(self) -> list[int]:
        """Where the coordinates of each part begin."""
        sizes = [len(part.begin) for part in self.parts]
        return [0, *accumulate(sizes[:-1])]

    def _split(self, at: Coordinates) -> Iterator[Coordinates]:
        for first, part in zip(self._firsts, self.parts, strict=True):
            yield at[first : first + len(part.begin)]


def _off(name: str, tool: Pose, aim: Pose) -> Off:
    off = norm(subtract(aim.position, tool.position))
    return Off(name, off, turn_between(tool.quaternion, aim.quaternion))
