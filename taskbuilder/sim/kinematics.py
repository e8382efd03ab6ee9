"""Forward and inverse kinematics of an arm.

A `Chain` is read off the robot's URDF and is then plain numbers: solving does not need the
simulated arm. Poses are those of the tool in the frame of the base link.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, Vec3, from_axes, norm, subtract, turn_between
from taskbuilder.sim.descent import METRES_PER_RADIAN, descend

Floats = NDArray[np.float64]

# After the first beginning so many times as many are tried as before, side by side: nineteen at
# once take less than half the time that they take one by one.
HANDFUL = 4
# How far joints of a redundant arm are from its posture where a beginning is drawn, rad.
POSTURE_SPREAD = 0.35


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
            frames=np.array([_matrix(frame) for frame in frames]),
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
    goal = _matrix(target)
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


def _path(urdf: Urdf, link: str) -> list[UrdfJoint]:
    """Joints from the base to a link."""
    path: list[UrdfJoint] = []
    while (joint := urdf.joint_above(link)) is not None:
        path.insert(0, joint)
        link = joint.parent
    return path


def _matrix(pose: Pose) -> Floats:
    """(4, 4) homogeneous matrix of a pose."""
    matrix = np.eye(4)
    for column in range(3):
        matrix[:3, column] = pose.axis(column)
    matrix[:3, 3] = pose.position
    return matrix


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
