"""What an arm reaches: the points of a level plane to which inverse kinematics brings its tool."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose, Vec3, from_rpy_deg
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.inverse import solve

SPACING_M = 0.05
"""Distance between the points that are tried."""

_TOLERANCE_M, _TOLERANCE = 4e-3, math.radians(2.0)
_SEEDS = 5  # along each side: points from which the rest is found
_ENTERED_FROM = 3  # neighbours from which a point is tried, at most


@dataclass(frozen=True)
class ReachMap:
    """The points of a level rectangle that a tool that points straight down can reach.

    Attributes:
        low: The corner of the rectangle with the smallest x and y, in the world, in metres.
        spacing: Distances between the points along x and y, in metres.
        reached: (rows, columns) whether each point is reached; rows go along y.
    """

    low: Vec3
    spacing: tuple[float, float]
    reached: NDArray[np.bool_]

    @property
    def share(self) -> float:
        """The fraction of the points that is reached."""
        return float(self.reached.mean())


def reach_map(
    chain: Chain,
    base: Pose,
    home: Sequence[float],
    low: Vec3,
    high: tuple[float, float],
    *,
    spacing: float = SPACING_M,
) -> ReachMap:
    """Find out which points of a level rectangle a tool that points straight down reaches.

    At each point, the tool is turned in the direction away from the base, or at right angles to
    it. What is in the way is not considered.

    Args:
        chain: The arm.
        base: Of the arm, in the world.
        home: Joint positions to begin at, in rad or m.
        low: The corner with the smallest x and y, and the height, in metres.
        high: The largest x and y.
        spacing: Distance between the points, in metres.
    """
    columns = max(2, round((high[0] - low[0]) / spacing) + 1)
    rows = max(2, round((high[1] - low[1]) / spacing) + 1)
    steps = (high[0] - low[0]) / (columns - 1), (high[1] - low[1]) / (rows - 1)
    finder = _Finder(chain, base, low, steps, (rows, columns))
    for row in np.linspace(0, rows - 1, _SEEDS).round().astype(int).tolist():
        for column in np.linspace(0, columns - 1, _SEEDS).round().astype(int).tolist():
            finder.spread((row, column), tuple(home))
    return ReachMap(low, steps, finder.reached)


Cell = tuple[int, int]


class _Finder:
    """Spreads over the points from one to the next, which makes inverse kinematics fast."""

    def __init__(
        self,
        chain: Chain,
        base: Pose,
        low: Vec3,
        spacing: tuple[float, float],
        shape: tuple[int, int],
    ) -> None:
        self._chain, self._base, self._low, self._spacing = chain, base, low, spacing
        self._rng = np.random.default_rng(0)
        self._longest = longest_reach(chain)
        self._tries = np.zeros(shape, dtype=int)
        self.reached = np.zeros(shape, dtype=bool)

    def spread(self, start: Cell, joints: tuple[float, ...]) -> None:
        """Try a point thoroughly; if it is reached, go on to its neighbours, and to theirs."""
        if self.reached[start] or (found := self._solved(start, joints, attempts=4)) is None:
            return
        self.reached[start] = True
        queue = deque([(start, found)])
        while queue:
            (row, column), near = queue.popleft()
            for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                cell = row + down, column + right
                if not self._open(cell):
                    continue
                self._tries[cell] += 1
                if (found := self._solved(cell, near, attempts=1)) is not None:
                    self.reached[cell] = True
                    queue.append((cell, found))

    def _open(self, cell: Cell) -> bool:
        rows, columns = self.reached.shape
        there = 0 <= cell[0] < rows and 0 <= cell[1] < columns
        return there and not self.reached[cell] and self._tries[cell] < _ENTERED_FROM

    def _solved(
        self, cell: Cell, start: tuple[float, ...], *, attempts: int
    ) -> tuple[float, ...] | None:
        point = (
            self._low[0] + cell[1] * self._spacing[0],
            self._low[1] + cell[0] * self._spacing[1],
            self._low[2],
        )
        x, y, z = self._base.inverse().apply(point)
        if math.sqrt(x * x + y * y + z * z) > self._longest:
            return None
        away = math.degrees(
            math.atan2(point[1] - self._base.position[1], point[0] - self._base.position[0])
        )
        for yaw in (away, away + 90.0):
            target = self._base.inverse() @ Pose(point, from_rpy_deg((180.0, 0.0, yaw)))
            found = solve(
                self._chain,
                target,
                start=start,
                rng=self._rng,
                attempts=attempts,
                position_tolerance_m=_TOLERANCE_M,
                angle_tolerance=_TOLERANCE,
            )
            if found.ok:
                return found.joints
        return None


def longest_reach(chain: Chain) -> float:
    """No point is reached that is further than this from the base, in metres."""
    links = float(np.linalg.norm(chain.frames[:, :3, 3], axis=1).sum())
    slides = ~chain.revolute
    travel = np.maximum(np.abs(chain.lower), np.abs(chain.upper))[slides]
    return links + float(travel.sum())
