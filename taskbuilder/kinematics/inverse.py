"""Inverse kinematics: joint positions that bring an arm's tool to a pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, norm, subtract, turn_between
from taskbuilder.kinematics.chain import Chain, homogeneous
from taskbuilder.kinematics.descent import METRES_PER_RADIAN, descend

Floats = NDArray[np.float64]

# After the first beginning so many times as many are tried as before, side by side: nineteen at
# once take less than half the time that they take one by one.
HANDFUL = 4
# How far joints of a redundant arm are from its posture where a beginning is drawn, rad.
POSTURE_SPREAD = 0.35


@dataclass(frozen=True)
class IkResult:
    """What inverse kinematics found.

    Attributes:
        joints: Joint positions, rad or m, inside the limits: the best found.
        position_error_m: Distance of the tool from where it should be.
        angle_error: Angle between its orientation and the one asked for, rad.
        ok: Whether both errors are within the tolerances.
    """

    joints: tuple[float, ...]
    position_error_m: float
    angle_error: float
    ok: bool


def solve(
    chain: Chain,
    target: Pose,
    *,
    start: Sequence[float],
    rng: np.random.Generator,
    attempts: int = 20,
    position_tolerance_m: float = 1e-3,
    angle_tolerance: float = math.radians(0.5),
) -> IkResult:
    """Find joint positions that bring the tool to a pose.

    The base of a redundant arm stays where it is if the arm alone can bring the tool there.

    The first attempt begins at ``start``, so a solution near it is found first; later ones begin
    at random inside the limits. Joints that turn further than a full circle are brought to the
    turn nearest ``start``.

    Args:
        chain: The arm.
        target: Of the tool, in the frame of the base link.
        start: Joint positions to begin at, rad or m.
        rng: Where the other beginnings come from.
        attempts: How many beginnings to try.
        position_tolerance_m: How far off the tool may be.
        angle_tolerance: How much it may be turned, rad.
    """
    if chain.base:
        found = _with_base_still(chain, target, start, rng, position_tolerance_m, angle_tolerance)
        if found.ok:
            return found
    goal = homogeneous(target)
    best: IkResult | None = None
    begun = 0
    while begun < attempts:
        before = rng.bit_generator.state
        count = min(max(1, HANDFUL * begun), attempts - begun)
        beginnings = beginnings_of(chain, rng, count) if begun else _within(chain, start)
        for number, descended in enumerate(descend(chain, goal, beginnings), start=1):
            joints = _nearest_turn(chain, descended, start)
            result = _judged(chain, target, joints, position_tolerance_m, angle_tolerance)
            if result.ok:
                if number < count:  # as if the later ones had never been drawn
                    rng.bit_generator.state = before
                    beginnings_of(chain, rng, number)
                return result
            if best is None or _badness(result) < _badness(best):
                best = result
        begun += count
    if best is None:
        raise SimulationError(f"inverse kinematics needs at least one attempt, not {attempts}")
    return best


def _with_base_still(
    chain: Chain,
    target: Pose,
    start: Sequence[float],
    rng: np.random.Generator,
    distance: float,
    angle: float,
) -> IkResult:
    """Joint positions with the base where it is at the start."""
    still = tuple(start[: chain.base])
    found = solve(
        chain.with_base_at(still),
        target,
        start=start[chain.base :],
        rng=rng,
        attempts=1,  # rather than bend the arm over, the base moves
        position_tolerance_m=distance,
        angle_tolerance=angle,
    )
    return replace(found, joints=(*still, *found.joints))


def _within(chain: Chain, start: Sequence[float]) -> Floats:
    """(1, n) joint positions, brought inside the limits."""
    return np.clip(np.asarray(start, dtype=np.float64), chain.lower, chain.upper)[None]


def beginnings_of(chain: Chain, rng: np.random.Generator, count: int) -> Floats:
    """(count, n) joint positions at random inside the limits."""
    # One turn is all there is to choose from; wider limits would only spread the guesses.
    widest = np.where(chain.revolute, math.pi, math.inf)
    lower, upper = np.maximum(chain.lower, -widest), np.minimum(chain.upper, widest)
    drawn = rng.uniform(lower, upper, (count, len(lower)))
    if chain.base and chain.posture is not None:  # the base comes near by itself, from all sides
        spread = rng.normal(0.0, POSTURE_SPREAD, (count, len(lower) - chain.base))
        near = chain.posture[chain.base :] + spread
        drawn[:, chain.base :] = np.clip(near, lower[chain.base :], upper[chain.base :])
    return drawn


def _nearest_turn(chain: Chain, positions: Floats, start: Sequence[float]) -> Floats:
    """The same posture, each turning joint on the full turn within limits nearest to start."""
    turn = 2.0 * math.pi
    most = np.floor((chain.upper - positions) / turn)
    least = np.ceil((chain.lower - positions) / turn)
    turns = np.clip(np.round((np.asarray(start) - positions) / turn), least, most)
    return np.where(chain.revolute, positions + turn * turns, positions)


def _judged(
    chain: Chain, target: Pose, positions: Floats, distance: float, angle: float
) -> IkResult:
    reached = chain.forward(positions.tolist())
    off = norm(subtract(target.position, reached.position))
    turned = turn_between(reached.quaternion, target.quaternion)
    good = off <= distance and turned <= angle and chain.within_limits(positions.tolist(), -1e-9)
    return IkResult(tuple(positions.tolist()), off, turned, good)


def _badness(result: IkResult) -> float:
    return result.position_error_m + METRES_PER_RADIAN * result.angle_error
