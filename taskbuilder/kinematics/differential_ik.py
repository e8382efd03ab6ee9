"""One step of inverse kinematics, for control loops: a few tens of microseconds an arm.

In plain floats rather than arrays: for six joints the arithmetic costs less than numpy's dispatch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple, Self, cast

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import (
    Pose,
    Quat,
    Vec3,
    add,
    conjugate,
    cross,
    from_axes,
    multiply,
    norm,
    scale,
    subtract,
    unit,
)
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.descent import METRES_PER_RADIAN

DAMPING = 0.02
"""Metres of tool motion per radian below which a direction counts as singular and is damped."""

BASE_SHARE = 0.1
"""How readily a base moves, where the joints of the arm that it carries count 1."""

POSTURE_M = 0.2
"""Way of the tool, in metres, along which a redundant arm comes back to its posture."""


class LinkFrames(NamedTuple):
    """Where everything is at some joint positions, in the base link's frame."""

    tool: Pose
    axes: list[Vec3]
    origins: list[Vec3]


@dataclass(frozen=True)
class DifferentialIK:
    """A chain, prepared for stepping: every joint turns about, or slides along, its own z axis.

    Attributes:
        offsets: Position and orientation of each joint's frame in the one before.
        tool: The tool's frame in the last joint's.
        turns: Whether each joint turns; the others slide.
        lower: Smallest joint positions, rad or m.
        upper: Largest joint positions.
        base: How many of the first joints carry a base; see `Chain.base`.
        posture: Joint positions that a redundant arm prefers; those of the base do not count.
    """

    offsets: tuple[tuple[Vec3, Quat], ...]
    tool: Pose
    turns: tuple[bool, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    base: int = 0
    posture: tuple[float, ...] = ()

    @classmethod
    def of(cls, chain: Chain) -> Self:
        """Prepare a chain."""
        frames = [_pose(frame) for frame in chain.frames]
        aligned = [_z_to(axis) for axis in chain.axes.tolist()]
        offsets = []
        before = Pose()
        for frame, turn in zip(frames[:-1], aligned, strict=True):
            offset = before.inverse() @ frame @ turn
            offsets.append((offset.position, offset.quaternion))
            before = turn
        return cls(
            tuple(offsets),
            before.inverse() @ frames[-1],
            tuple(chain.revolute.tolist()),
            tuple(chain.lower.tolist()),
            tuple(chain.upper.tolist()),
            chain.base if chain.posture is not None else 0,
            () if chain.posture is None else tuple(chain.posture.tolist()),
        )

    def forward(self, positions: Sequence[float]) -> Pose:
        """Pose of the tool in the base link's frame."""
        return self.frames(positions).tool

    def step(
        self,
        positions: Sequence[float],
        target: Pose,
        longest: Sequence[float],
    ) -> tuple[float, ...]:
        """Joint positions that bring the tool near a pose that is a step away.

        Two iterations of damped least squares that share one Jacobian: for a step of 5 cm the
        tool ends within a few tenths of a millimetre. Where that would take a joint further than
        allowed, the whole step is shortened.

        Args:
            positions: Where the joints are, rad or m.
            target: Of the tool, in the base link's frame.
            longest: How far each joint may move, rad or m.
        """
        return self._known_steps(tuple(positions), target, tuple(longest))

    @cached_property
    def _known_steps(
        self,
    ) -> Callable[[tuple[float, ...], Pose, tuple[float, ...]], tuple[float, ...]]:
        """`step`, kept for a while: arms that hold still take the same one again and again."""
        return lru_cache(maxsize=64)(self._step)

    def _step(
        self, positions: tuple[float, ...], target: Pose, longest: tuple[float, ...]
    ) -> tuple[float, ...]:
        here = self.frames(positions)
        inverse = self._damped_inverse(here)
        error = _error(here.tool, target)
        first = (inverse @ error).tolist()
        if self.base:
            first = self._towards_posture(first, positions, here, inverse, math.hypot(*error))
        halfway = [q + d for q, d in zip(positions, first, strict=True)]
        second = (inverse @ _error(self._frames(halfway).tool, target)).tolist()
        move = [a + b for a, b in zip(first, second, strict=True)]
        share = max(abs(d) / most for d, most in zip(move, longest, strict=True))
        if share > 1.0:
            move = [d / share for d in move]
        return tuple(
            min(max(q + d, low), high)
            for q, d, low, high in zip(positions, move, self.lower, self.upper, strict=True)
        )

    def _towards_posture(
        self,
        step: Sequence[float],
        positions: Sequence[float],
        frames: LinkFrames,
        inverse: NDArray[np.float64],
        way: float,
    ) -> list[float]:
        """A step, and with it so much of the way to the posture as does not move the tool.

        The longer the tool's own way, the more: while it stands still, so does the base.
        """
        away = np.array(self.posture) - np.array(positions)
        away[: self.base] = 0.0
        away *= min(1.0, way / POSTURE_M)
        seen = inverse @ (self._columns(frames).T @ away)
        moved: list[float] = (np.array(step) + away - seen).tolist()
        return moved

    def frames(self, positions: Sequence[float]) -> LinkFrames:
        """The tool's pose, and each joint's axis and origin, in the base link's frame."""
        return self._known_frames(tuple(positions))

    @cached_property
    def _known_frames(self) -> Callable[[tuple[float, ...]], LinkFrames]:
        """`frames`, kept for a while: where one step ends, the next begins."""
        return lru_cache(maxsize=64)(self._frames)

    def _frames(self, positions: Sequence[float]) -> LinkFrames:
        # Written out, for this is most of a control step's Python: `at` moves by the offset turned
        # by the quaternion so far, which then takes the offset's turn and the joint's own.
        x, y, z, w = 0.0, 0.0, 0.0, 1.0
        px = py = pz = 0.0
        axes, origins = [], []
        for ((ox, oy, oz), (a, b, c, d)), position, turns in zip(
            self.offsets, positions, self.turns, strict=True
        ):
            tx, ty, tz = 2.0 * (y * oz - z * oy), 2.0 * (z * ox - x * oz), 2.0 * (x * oy - y * ox)
            px += ox + w * tx + y * tz - z * ty
            py += oy + w * ty + z * tx - x * tz
            pz += oz + w * tz + x * ty - y * tx
            x, y, z, w = (
                w * a + x * d + y * c - z * b,
                w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d,
                w * d - x * a - y * b - z * c,
            )
            axis = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
            if turns:
                s, c = math.sin(position / 2.0), math.cos(position / 2.0)
                x, y, z, w = x * c + y * s, y * c - x * s, z * c + w * s, w * c - z * s
            else:
                px, py, pz = add((px, py, pz), scale(axis, position))
            axes.append(axis)
            origins.append((px, py, pz))
        tool = Pose((px, py, pz), (x, y, z, w)) @ self.tool
        return LinkFrames(tool, axes, origins)

    def _damped_inverse(self, frames: LinkFrames) -> NDArray[np.float64]:
        """(n, 6) damped inverse of the Jacobian, rotations weighed in metres."""
        transposed = self._columns(frames)
        weighted: NDArray[np.float64] = transposed
        if self.base:
            weighted = transposed.copy()
            weighted[: self.base] *= BASE_SHARE
        square = weighted.T @ transposed
        square.flat[::7] += DAMPING * DAMPING
        return cast("NDArray[np.float64]", np.linalg.solve(square, weighted.T).T)

    def _columns(self, frames: LinkFrames) -> NDArray[np.float64]:
        """(n, 6) transposed Jacobian, rotations weighed in metres."""
        columns = []
        tx, ty, tz = frames.tool.position
        for (x, y, z), (ox, oy, oz), turns in zip(
            frames.axes, frames.origins, self.turns, strict=True
        ):
            if turns:
                ax, ay, az = tx - ox, ty - oy, tz - oz
                m = METRES_PER_RADIAN
                across = (y * az - z * ay, z * ax - x * az, x * ay - y * ax)
                columns.append((*across, x * m, y * m, z * m))
            else:
                columns.append((x, y, z, 0.0, 0.0, 0.0))
        return np.array(columns)


def _error(tool: Pose, target: Pose) -> tuple[float, ...]:
    """Position error (m), then rotation vector error weighed in metres."""
    x, y, z, w = multiply(target.quaternion, conjugate(tool.quaternion))
    if w < 0.0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.sqrt(x * x + y * y + z * z)
    # angle / sin(angle / 2), which tends to 2 for small angles
    factor = METRES_PER_RADIAN * (2.0 * math.atan2(sine, w) / sine if sine > 1e-9 else 2.0)
    return (*subtract(target.position, tool.position), x * factor, y * factor, z * factor)


def _pose(matrix: NDArray[np.float64]) -> Pose:
    x, y, z, position = (tuple(column) for column in matrix[:3].T.tolist())
    return Pose(position, from_axes(x, y, z))


def _z_to(axis: Sequence[float]) -> Pose:
    """A frame turned such that its z axis is the given one."""
    z = unit((axis[0], axis[1], axis[2]))
    helper: Vec3 = (1.0, 0.0, 0.0) if abs(z[0]) < 0.9 else (0.0, 1.0, 0.0)
    x = cross(helper, z)
    x = scale(x, 1.0 / norm(x))
    return Pose((0.0, 0.0, 0.0), from_axes(x, cross(z, x), z))
