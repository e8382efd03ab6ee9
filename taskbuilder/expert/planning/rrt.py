"""RRT-Connect: two trees that grow through a space towards each other.

Kuffner and LaValle, "RRT-Connect: an efficient approach to single-query path planning", ICRA 2000.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from taskbuilder.expert.planning.spaces import Space, Waypoint
from taskbuilder.expert.planning.subspaces import Coordinates, Polyline

ITERATIONS = 400
"""Maximum number of growth steps of the trees."""

STRIDE_M = 0.25
"""Maximum length of a growth step, in metres."""

COARSE = 1.4
"""Factor on the length of a fine step when new branches are checked."""


def connect(
    space: Space,
    ends: tuple[Waypoint, Waypoint],
    free: Callable[[Waypoint], bool],
    rng: np.random.Generator,
) -> Iterator[Polyline]:
    """Yield candidate paths from one point to another, which must be checked in fine steps.

    Trees check coarsely, and follow the half of a path from the goal backwards. They continue to
    grow as long as more paths are requested.

    Args:
        space: The search space.
        ends: The start and the goal.
        free: Whether a point is allowed.
        rng: Generator of the samples.
    """
    trees = (_Tree(space, ends[0]), _Tree(space, ends[1]))
    low, high = space.bounds
    for count in range(ITERATIONS):
        tree, other = trees if count % 2 == 0 else trees[::-1]
        target = tuple(rng.uniform(low, high).tolist())
        grown = tree.grow(target, STRIDE_M, free)
        if grown is None:
            continue
        reached = other.grow(tree.points[grown].at, math.inf, free)
        if reached is not None and other.points[reached].at == tree.points[grown].at:
            near, far = (grown, reached) if count % 2 == 0 else (reached, grown)
            yield [*trees[0].path(near), *trees[1].path(far)[::-1]]


class _Tree:
    """Points that are connected to a root."""

    def __init__(self, space: Space, root: Waypoint) -> None:
        self.points = [root]
        self._space = space
        self._parents = [-1]
        self._weighed = np.empty((2 * ITERATIONS + 1, len(root.at)))
        self._weighed[0] = space.weights * root.at

    def grow(
        self, target: Coordinates, stride: float, free: Callable[[Waypoint], bool]
    ) -> int | None:
        """Grow towards coordinates as far as it is free, by at most a given length.

        Returns:
            The index of the new point, or None.
        """
        nearest = self._nearest(target)
        begin = self.points[nearest]
        share = min(1.0, stride / max(self._space.length([begin.at, target]), 1e-9))
        if share < 1.0:
            target = tuple(a + share * (b - a) for a, b in zip(begin.at, target, strict=True))
        last = None
        for point in self._space.line(begin, target, COARSE):
            if not free(point):
                break
            last = point
        return None if last is None else self._add(last, nearest)

    def path(self, number: int) -> Polyline:
        """Coordinates from the root to a point."""
        path: Polyline = []
        while number >= 0:
            path.append(self.points[number].at)
            number = self._parents[number]
        return path[::-1]

    def _add(self, point: Waypoint, parent: int) -> int:
        number = len(self.points)
        self.points.append(point)
        self._parents.append(parent)
        self._weighed[number] = self._space.weights * point.at
        return number

    def _nearest(self, at: Coordinates) -> int:
        gaps = self._weighed[: len(self.points)] - self._space.weights * at
        return int(np.einsum("ij,ij->i", gaps, gaps).argmin())
