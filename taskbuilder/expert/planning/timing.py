"""Timing of motions: positions at the end of each control step."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from taskbuilder.expert.planning.reach import Reach
from taskbuilder.expert.planning.spaces import Waypoint
from taskbuilder.expert.planning.subspaces import ArmJoints
from taskbuilder.geometry import total

RAMP = (0.4, 0.8)
"""Fractions of full speed in the first control steps, and in reverse in the last: a start at full
speed makes held objects swing."""

NOTHING = 1e-6
"""Control steps that a motion which takes no time may take."""


@dataclass(frozen=True)
class Trajectory:
    """Commanded joint positions over time.

    Attributes:
        joints: For each robot, joint positions (rad or m) by the end of each control step.
    """

    joints: Mapping[str, tuple[tuple[float, ...], ...]]

    @property
    def steps(self) -> int:
        """Its duration in control steps."""
        return max((len(points) for points in self.joints.values()), default=0)


def timed(
    path: Sequence[Waypoint],
    reaches: Mapping[str, Reach],
    speeds: Mapping[str, float],
    laden: Collection[str],
) -> Trajectory:
    """A trajectory along a path, at the pace of the slowest arm.

    Args:
        path: Points of the path in small steps.
        reaches: The arms that move.
        speeds: Fraction of full speed of each arm.
        laden: The arms that carry a load.
    """
    costs = [
        max(_cost(reach, pair, name in laden) / speeds[name] for name, reach in reaches.items())
        for pair in pairwise(path)
    ]
    waypoints = {
        name: resampled([point.posture.joints[name] for point in path], costs) for name in reaches
    }
    return Trajectory(waypoints)


def resampled(points: Sequence[Sequence[float]], costs: Sequence[float]) -> tuple[ArmJoints, ...]:
    """Points of a path at the ends of control steps.

    Args:
        points: n + 1 points of the path, connected by straight segments.
        costs: n durations of the segments at full speed, in control steps.

    Returns:
        A point for each control step; the last is that of the path.
    """
    ends = [0.0, *accumulate(costs)]
    samples: list[ArmJoints] = []
    for at in schedule(ends[-1])[:-1]:
        index = min(bisect_right(ends, at) - 1, len(costs) - 1)
        share = (at - ends[index]) / costs[index]
        pairs = zip(points[index], points[index + 1], strict=True)
        samples.append(tuple(begin + share * (end - begin) for begin, end in pairs))
    return (*samples, tuple(points[-1])) if ends[-1] > NOTHING else ()


def schedule(length: float) -> tuple[float, ...]:
    """The schedule of a motion along a path.

    Args:
        length: Duration of the path at full speed, in control steps.

    Returns:
        The position along the path at the end of each control step, in the same unit. It rises by
        at most 1 per step from 0 (not included) to the length, in as few steps as the ramps at both
        ends allow. Empty for a path of length 0.
    """
    if length <= NOTHING:
        return ()
    count = 1
    while (most := total(_speeds(count))) < length:
        count += max(1, int(length - most))  # each further step adds at most 1
    slower = length / most
    *inner, _ = accumulate(speed * slower for speed in _speeds(count))
    return (*inner, length)


def _speeds(count: int) -> Iterator[float]:
    """Fraction of full speed in each control step."""
    for step in range(count):
        nearest = min(step, count - 1 - step)
        yield RAMP[nearest] if nearest < len(RAMP) else 1.0


def _cost(reach: Reach, pair: tuple[Waypoint, Waypoint], laden: bool) -> float:
    before, after = (point.posture for point in pair)
    name = reach.name
    tools = (before.tools[name], after.tools[name])
    return reach.cost(before.joints[name], after.joints[name], tools, laden=laden)
