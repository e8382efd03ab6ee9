"""The search for a path: a straight one, a simple detour, or one of RRT-Connect."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import islice

import numpy as np

from taskbuilder.expert.planning import rrt
from taskbuilder.expert.planning.candidates import candidate_paths
from taskbuilder.expert.planning.clearance import Clearance, ClearanceViolation
from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.expert.planning.spaces import Off, Space, Waypoint
from taskbuilder.expert.planning.subspaces import Coordinates

SHORTCUTS, MANY_SHORTCUTS = 24, 60
"""Attempts to shorten a simple path, and a path from the trees."""

CANDIDATES = 20
"""Paths of the trees that are followed in fine steps. The library's experts need one. Where the
trees meet again and again and no path holds, the tool does not get to the goal on any."""

Waypoints = list[Waypoint]


class Search:
    """Searches for a path in a space, and counts the obstacles that it meets.

    Args:
        space: The search space.
        clearance: The allowed distances.
        start: The start point.
        goal: The goal point.
        rng: Generator of the trees and the shortcuts.
    """

    def __init__(
        self,
        space: Space,
        clearance: Clearance,
        start: Waypoint,
        goal: Waypoint,
        rng: np.random.Generator,
    ) -> None:
        self.space = space
        self._start = start
        self._goal = goal
        self._clearance = clearance
        self._rng = rng
        self._obstacles: Counter[tuple[str, str]] = Counter()
        self._worst: dict[tuple[str, str], ClearanceViolation] = {}
        self._astray = Off()

    @property
    def length(self) -> float:
        """Length of the straight path, free or not, m."""
        return self.space.length([self._start.at, self.space.end])

    def no_path(self) -> PlanningError:
        """Why no path was found: the most frequent obstacle, or a line that no tool can follow."""
        names = list(self.space.reaches)
        words = " and ".join(names)
        if self.space.rigid:
            words += " cannot take the direct path: on this path, "
        else:
            words += f" find{'s' if len(names) == 1 else ''} no path: on the paths tried, "
        if self._obstacles:
            near = self._worst[self._obstacles.most_common(1)[0][0]]
            return PlanningError(near.robot, "no path", f"{words}{near}")
        off = self._astray
        return PlanningError(
            off.robot, "no path", f"{words}{off.robot}'s tool would be off by {off}"
        )

    def straight(self) -> Waypoints | None:
        """The straight path, if it is free."""
        return self._along(self._start, [self.space.end])

    def simple(self) -> Waypoints | None:
        """The shortest free detour: up, over and down, or one part at a time."""
        lines = candidate_paths(self.space)
        for line in sorted(lines, key=lambda line: self.space.length([self._start.at, *line])):
            path = self._along(self._start, line)
            if path is not None:
                return self._shorten(path, SHORTCUTS)
        return None

    def connect(self) -> Waypoints | None:
        """A path of trees that grow from both ends."""
        if len(self.space.begin) == 1:
            return None  # a single line leads round nothing
        ends = (self._start, self._goal)
        lines = rrt.connect(self.space, ends, self._free, self._rng)
        for line in islice(lines, CANDIDATES):
            path = self._along(self._start, line)
            if path is not None:
                return self._shorten(path, MANY_SHORTCUTS)
        return None

    def _along(self, start: Waypoint, line: Sequence[Coordinates]) -> Waypoints | None:
        """The path along waypoints in fine steps, if it is free and reaches the goal."""
        path = [start]
        for corner in line:
            for point in self.space.line(path[-1], corner):
                if not self._free(point):
                    return None
                path.append(point)
        if path[-1].off.late:
            self._astray = max(self._astray, path[-1].off, key=lambda off: off.badness)
            return None
        return path

    def _shorten(self, path: Waypoints, tries: int) -> Waypoints:
        """The path with free shortcuts, for all parts or for one."""
        shorter = path
        for _ in range(tries):
            first, last = sorted(self._rng.integers(0, len(shorter), 2).tolist())
            if last - first < 2:
                continue
            for parts in self.space.groups:
                cut = self._cut(shorter[first : last + 1], parts)
                if cut is not None:
                    shorter = [*shorter[:first], *cut, *shorter[last + 1 :]]
                    break
        # What follows a shortcut was not followed anew, and shortcuts were looked at coarsely.
        checked = self._along(path[0], [point.at for point in shorter[1:]])
        return checked or path

    def _cut(self, piece: Waypoints, parts: Sequence[int]) -> Waypoints | None:
        """A segment of a path on which some parts move straight, if it is free."""
        old = [point.at for point in piece]
        new = self.space.straightened(old, parts)
        if self.space.length(new) > 0.99 * self.space.length(old):
            return None
        shortcut = [piece[0]]
        for at in new[1:]:
            point = self.space.step(shortcut[-1], at)
            if not self._free(point):
                return None
            shortcut.append(point)
        return shortcut

    def _free(self, point: Waypoint) -> bool:
        if point.off.astray:
            self._astray = max(self._astray, point.off, key=lambda off: off.badness)
            return False
        near = self._clearance.trouble(point.posture)
        if near is not None:
            pair = (near.a, near.b)
            self._obstacles[pair] += 1
            self._worst[pair] = min(self._worst.get(pair, near), near, key=lambda n: n.distance)
        return near is None
