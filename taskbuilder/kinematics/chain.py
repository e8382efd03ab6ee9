"""The joints between a robot's base and its tool, and where they bring it.

A `Chain` is read off the robot's URDF and is then plain numbers. Poses are those of the tool in
the frame of the base link.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, Vec3, from_axes

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """The n movable joints between a robot's base and its tool.

    Attributes:
        frames: (n + 1, 4, 4) each joint's frame at zero in the one before, then the tool's in the
            last joint's.
        axes: (n, 3) unit axis of each joint in its own frame.
        revolute: (n,) whether each joint turns; the others slide.
        lower: (n,) smallest positions, rad or m; minus infinity where there is no limit.
        upper: (n,) largest positions.
        posture: (n,) the positions that a redundant arm prefers, or None.
    """

    frames: Floats
    axes: Floats
    revolute: NDArray[np.bool_]
    lower: Floats
    upper: Floats
    posture: Floats | None = None

    @classmethod
    def of(
        cls,
        urdf: Urdf,
        joints: Sequence[str],
        tcp_link: str,
        tcp_offset: Pose,
        posture: Sequence[float] | None = None,
    ) -> Self:
        """Read a chain off a URDF.

        Args:
            urdf: The robot.
            joints: Names of the arm's joints, from the base outwards. Other joints on the way are
                taken at zero.
            tcp_link: The link that carries the tool.
            tcp_offset: The tool's frame in that link's.
            posture: Joint positions that the arm prefers if it is redundant, rad or m.

        Raises:
            SimulationError: The joints are not all between base and tool, in that order.
        """
        path = _path(urdf, tcp_link)
        own = [joint for joint in path if joint.name in joints]
        if [joint.name for joint in own] != list(joints):
            raise SimulationError(
                f"{urdf.path.name}: joints {list(joints)} are not, in this order, on the way from "
                f"the base to {tcp_link}, which is {[joint.name for joint in path]}"
            )
        frames, frame = [], Pose()
        for joint in path:
            frame = frame @ joint.origin
            if joint in own:
                frames.append(frame)
                frame = Pose()
        frames.append(frame @ tcp_offset)
        return cls(
            frames=np.array([homogeneous(frame) for frame in frames]),
            axes=np.array([joint.axis for joint in own]),
            revolute=np.array([joint.type != "prismatic" for joint in own]),
            lower=np.array([-math.inf if j.lower is None else j.lower for j in own]),
            upper=np.array([math.inf if j.upper is None else j.upper for j in own]),
            posture=None if posture is None else np.array(posture),
        )

    @cached_property
    def base(self) -> int:
        """How many of the first joints carry a base that need not move for the tool to.

        Six joints are enough for all poses. Where joints slide and there are more than six, the
        first ones are the base's.
        """
        return 0 if self._all_turn else max(0, len(self.axes) - 6)

    def with_base_at(self, positions: Sequence[float]) -> Chain:
        """The arm alone, with its base at joint positions (rad or m)."""
        count = len(positions)
        rest = [*positions, *(0.0,) * (len(self.axes) - count)]
        moved = self.frames[:-1] @ self._motions(np.asarray(rest))
        first = np.eye(4)
        for index in range(count):
            first = first @ moved[index]
        frames = self.frames[count:].copy()
        frames[0] = first @ frames[0]
        return Chain(
            frames, self.axes[count:], self.revolute[count:], self.lower[count:], self.upper[count:]
        )

    def forward(self, positions: Sequence[float]) -> Pose:
        """Pose of the tool with the joints at positions (rad or m)."""
        tool = self.frames_at(np.asarray(positions, dtype=np.float64))[-1]
        x, y, z = tool[:3, :3].T.tolist()
        return Pose(_vector(tool[:3, 3]), from_axes(tuple(x), tuple(y), tuple(z)))

    def within_limits(self, positions: Sequence[float], margin: float = 0.0) -> bool:
        """Whether every joint is at least ``margin`` (rad or m) inside its limits."""
        at = np.asarray(positions)
        return bool((at >= self.lower + margin).all() and (at <= self.upper - margin).all())

    def frames_at(self, positions: Floats) -> Floats:
        """(..., n + 1, 4, 4) frames of the joints at (..., n), then of the tool, in the base's."""
        moved = _repeated(self.frames, positions)
        moved[..., :-1, :, :] @= self._motions(positions)
        for index in range(1, len(self.frames)):
            moved[..., index, :, :] = moved[..., index - 1, :, :] @ moved[..., index, :, :]
        return moved

    def _motions(self, positions: Floats) -> Floats:
        """(..., n, 4, 4) what each joint does at its position: Rodrigues' formula, or a shift."""
        motions = _repeated(self._at_zero, positions)
        angles = positions
        if not self._all_turn:
            angles = np.where(self.revolute, positions, 0.0)
            shifts = np.where(self.revolute, 0.0, positions)
            motions[..., :3, 3] = self.axes * shifts[..., None]
        angles = angles[..., None, None]
        motions[..., :3, :3] += np.sin(angles) * self._turns
        motions[..., :3, :3] += (1.0 - np.cos(angles)) * self._turns_twice
        return motions

    @cached_property
    def _at_zero(self) -> Floats:
        """(n, 4, 4) what each joint does at zero: nothing."""
        return np.tile(np.eye(4), (len(self.axes), 1, 1))

    @cached_property
    def _all_turn(self) -> bool:
        return bool(self.revolute.all())

    @cached_property
    def _turns(self) -> Floats:
        """(n, 3, 3) matrices of the cross product with each axis."""
        x, y, z = self.axes.T
        zero = np.zeros_like(x)
        return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)

    @cached_property
    def _turns_twice(self) -> Floats:
        return self._turns @ self._turns

    def jacobian(self, frames: Floats) -> Floats:
        """(..., 6, n) velocity of the tool's origin, then its angular velocity, for each joint's.

        Args:
            frames: (..., n + 1, 4, 4) as of `frames_at`.
        """
        axes = (frames[..., :-1, :3, :3] @ self.axes[:, :, None])[..., 0]
        arms = frames[..., -1:, :3, 3] - frames[..., :-1, :3, 3]
        turned, turning = _cross(axes, arms), axes.swapaxes(-1, -2)
        if not self._all_turn:
            turned = np.where(self.revolute, turned, turning)
            turning = np.where(self.revolute, turning, 0.0)
        jacobian = np.empty((*turned.shape[:-2], 6, turned.shape[-1]))
        jacobian[..., :3, :], jacobian[..., 3:, :] = turned, turning
        return jacobian


def homogeneous(pose: Pose) -> Floats:
    """(4, 4) homogeneous matrix of a pose."""
    matrix = np.eye(4)
    for column in range(3):
        matrix[:3, column] = pose.axis(column)
    matrix[:3, 3] = pose.position
    return matrix


def _path(urdf: Urdf, link: str) -> list[UrdfJoint]:
    """Joints from the base to a link."""
    path: list[UrdfJoint] = []
    while (joint := urdf.joint_above(link)) is not None:
        path.insert(0, joint)
        link = joint.parent
    return path


def _repeated(matrices: Floats, positions: Floats) -> Floats:
    """(..., n, 4, 4) a copy of matrices for each row of (..., n) positions."""
    repeated = np.empty(positions.shape[:-1] + matrices.shape)
    repeated[...] = matrices
    return repeated


def _cross(a: Floats, b: Floats) -> Floats:
    """(..., 3, n) cross products of (..., n, 3) vectors; numpy's own takes longer on few."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    product = np.empty((*ax.shape[:-1], 3, ax.shape[-1]))
    product[..., 0, :] = ay * bz - az * by
    product[..., 1, :] = az * bx - ax * bz
    product[..., 2, :] = ax * by - ay * bx
    return product


def _vector(values: Floats) -> Vec3:
    x, y, z = values.tolist()
    return (x, y, z)
