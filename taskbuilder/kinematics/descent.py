"""Descents of inverse kinematics: from joint positions to ones that bring the tool to a pose."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskbuilder.kinematics.chain import Chain

Floats = NDArray[np.float64]

# One radian off weighs as much as 0.3 m off: about the lever arm at which a tool is used.
METRES_PER_RADIAN = 0.3
# Steps longer than this leave the region where the Jacobian says anything.
LONGEST_STEP = 0.5
ITERATIONS = 60
# An attempt that has not halved its error in this many iterations sits in a local minimum.
PATIENCE = 12
# Where iterating stops; well inside any tolerance asked for, because convergence is fast there.
CLOSE_ENOUGH = 2e-5

_IDENTITY = np.eye(6)


class _Descent:
    """How far one of several descents has come.

    Attributes:
        best: The best joint positions so far.
    """

    def __init__(self, beginning: Floats) -> None:
        self.best = beginning
        self._least = self._milestone = math.inf
        self._patience = PATIENCE

    def note(self, positions: Floats, error: float) -> None:
        """Keep positions that are better than all before."""
        if error < self._least:
            self.best, self._least = positions, error

    def goes_on(self, error: float) -> bool:
        """Whether there is a point in a further step."""
        if error < CLOSE_ENOUGH:
            return False
        if error < 0.5 * self._milestone:
            self._milestone, self._patience = error, PATIENCE
        self._patience -= 1
        return self._patience > 0


def descend(chain: Chain, goal: Floats, beginnings: Floats) -> list[Floats]:
    """Levenberg-Marquardt from several beginnings, side by side: (k, n), n for each.

    The damping is the error itself plus a constant, which makes steps bold near a solution and
    short near a singularity: Sugihara, "Solvability-unconcerned inverse kinematics by the
    Levenberg-Marquardt method", IEEE Trans. Robotics 27(5), 2011.
    """
    descents = [_Descent(beginning) for beginning in beginnings]
    going, positions = list(descents), beginnings
    for iteration in range(ITERATIONS + 1):
        frames = chain.frames_at(positions)
        errors = [_error(tool, goal) for tool in frames[:, -1]]
        sizes = [math.sqrt(error @ error) for error in errors]
        for descent, at, size in zip(going, positions, sizes, strict=True):
            descent.note(at, size)
        if iteration == ITERATIONS:
            break
        kept = [k for k, descent in enumerate(going) if descent.goes_on(sizes[k])]
        if not kept:
            break
        if len(kept) < len(going):
            going, sizes = [going[k] for k in kept], [sizes[k] for k in kept]
            positions, frames = positions[kept], frames[kept]
            errors = [errors[k] for k in kept]
        step = _step(chain, frames, np.array(errors), np.array(sizes))
        # np.clip takes four times as long.
        positions = np.minimum(np.maximum(positions + step, chain.lower), chain.upper)
    return [descent.best for descent in descents]


def _step(chain: Chain, frames: Floats, errors: Floats, sizes: Floats) -> Floats:
    """(k, n) the next step of each of several descents.

    Args:
        chain: The arm.
        frames: (k, n + 1, 4, 4) where its joints are.
        errors: (k, 6) where the goal lies as seen from the tool.
        sizes: (k,) lengths of the errors.
    """
    jacobian = chain.jacobian(frames)
    jacobian[:, 3:] *= METRES_PER_RADIAN
    transposed = jacobian.swapaxes(1, 2)
    damping = 0.1 * sizes * sizes + 1e-5
    square = jacobian @ transposed + damping[:, None, None] * _IDENTITY
    step: Floats = (transposed @ np.linalg.solve(square, errors[:, :, None]))[:, :, 0]
    longest = np.maximum(np.abs(step).max(axis=1), LONGEST_STEP)
    step *= (LONGEST_STEP / longest)[:, None]
    return step


def _error(tool: Floats, goal: Floats) -> Floats:
    """(6,) where the goal lies as seen from the tool: metres, then a rotation vector, scaled."""
    turn = goal[:3, :3] @ tool[:3, :3].T
    (a, b, c), (d, e, f), (g, h, i) = turn.tolist()
    x, y, z = h - f, c - g, d - b  # 2·sin(angle)·axis
    twice_sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(twice_sine, a + e + i - 1.0)
    if twice_sine > 1e-9:
        gain = METRES_PER_RADIAN * angle / twice_sine
    elif angle < 1.0:
        gain = 0.0
    else:  # half a turn has no one axis: any gets the descent going
        x, y, z, gain = 1.0, 0.0, 0.0, METRES_PER_RADIAN * angle
    px, py, pz = (goal[:3, 3] - tool[:3, 3]).tolist()
    return np.array([px, py, pz, gain * x, gain * y, gain * z])
