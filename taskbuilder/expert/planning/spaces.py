"""The search space of a motion: the coordinates of all its parts."""

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
"""Maximum deviation of a tool from its line on the way (m, rad)."""

NEAR_M, NEAR_TURN = 0.004, math.radians(3.0)
"""Maximum deviation of a tool at its goal (m, rad)."""


@dataclass(frozen=True)
class Off:
    """The deviation of a tool from its target pose.

    Attributes:
        robot: The robot; "" if no tool has a target.
        distance: In metres.
        turn: In rad.
    """

    robot: str = ""
    distance: float = 0.0
    turn: float = 0.0

    @property
    def badness(self) -> float:
        """The size of the deviation, to compare with others."""
        return self.distance / OFF_M + self.turn / OFF_TURN

    @property
    def astray(self) -> bool:
        """Whether it is too large on the way."""
        return self.distance > OFF_M or self.turn > OFF_TURN

    @property
    def late(self) -> bool:
        """Whether it is too large at the goal."""
        return self.distance > NEAR_M or self.turn > NEAR_TURN

    def __str__(self) -> str:
        return f"{self.distance * 100.0:.1f} cm and {math.degrees(self.turn):.0f}°"


@dataclass(frozen=True)
class Waypoint:
    """A point of the composite space, reached along a path.

    Attributes:
        at: Coordinates of all parts.
        posture: The configuration of the arms.
        off: The largest deviation of a tool.
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
        """Coordinates at the start."""
        return tuple(value for part in self.parts for value in part.begin)

    @cached_property
    def end(self) -> Coordinates:
        """Coordinates at the goal."""
        return tuple(value for part in self.parts for value in part.end)

    @cached_property
    def bounds(self) -> tuple[Coordinates, Coordinates]:
        """Lower and upper bounds of the coordinates on any path."""
        low, high = zip(*(part.bounds for part in self.parts), strict=True)
        return tuple(x for own in low for x in own), tuple(x for own in high for x in own)

    @cached_property
    def weights(self) -> NDArray[np.float64]:
        """(n,) length in metres of a unit of each coordinate."""
        return np.array([weight for part in self.parts for weight in part.weights])

    @property
    def rigid(self) -> bool:
        """Whether only the straight path is allowed for all parts."""
        return all(isinstance(part, Carried) and part.straight for part in self.parts)

    @cached_property
    def groups(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of the parts that are straightened together: all, then one by one."""
        count = len(self.parts)
        singles = [(number,) for number in range(count)] if count > 1 else []
        return (tuple(range(count)), *singles)

    def length(self, line: Sequence[Coordinates]) -> float:
        """Length of a path in metres: on each segment, that of the part that moves farthest."""
        differences = np.diff(np.array(line), axis=0) * self.weights
        squares = np.add.reduceat(differences * differences, self._firsts, axis=1)
        return float(np.sqrt(squares.max(axis=1)).sum())

    def straightened(self, line: Sequence[Coordinates], parts: Sequence[int]) -> list[Coordinates]:
        """Points of a path on which some parts move straight from its start to its end."""
        own = np.array(line)
        ends = [*self._firsts[1:], len(own[0])]
        shares = np.linspace(0.0, 1.0, len(own))[:, None]
        for number in parts:
            piece = slice(self._firsts[number], ends[number])
            own[1:-1, piece] = (own[0] + shares * (own[-1] - own[0]))[1:-1, piece]
        return [tuple(point) for point in own.tolist()]

    def start(self, joints: Mapping[str, ArmJoints]) -> Waypoint:
        """The point at the start, with given joint positions of the arms."""
        return Waypoint(self.begin, self.posture({name: joints[name] for name in self.reaches}))

    def posture(self, joints: Mapping[str, ArmJoints]) -> Posture:
        """The posture at joint positions."""
        return Posture(joints, {name: self.reaches[name].tool(q) for name, q in joints.items()})

    def line(self, start: Waypoint, end: Coordinates, coarse: float = 1.0) -> Iterator[Waypoint]:
        """Points at small steps along a straight line, without its start.

        Args:
            start: The start point.
            end: Coordinates of the end.
            coarse: Factor on the length of a fine step.
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
        """Index of the first coordinate of each part."""
        sizes = [len(part.begin) for part in self.parts]
        return [0, *accumulate(sizes[:-1])]

    def _split(self, at: Coordinates) -> Iterator[Coordinates]:
        for first, part in zip(self._firsts, self.parts, strict=True):
            yield at[first : first + len(part.begin)]


def _off(name: str, tool: Pose, aim: Pose) -> Off:
    off = norm(subtract(aim.position, tool.position))
    return Off(name, off, turn_between(tool.quaternion, aim.quaternion))
