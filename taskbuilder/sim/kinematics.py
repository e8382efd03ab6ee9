"""Forward and inverse kinematics of an arm.

A `Chain` is read off the robot's URDF and is then plain numbers: solving does not need the
simulated arm. Poses are those of the tool in the frame of the base link.
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
from taskbuilder.geometry import Pose, Vec3, from_axes, norm, subtract, turn_between

Floats = NDArray[np.float64]

# One radian off weighs as much as 0.3 m off: about the lever arm at which a tool is used.
METRES_PER_RADIAN = 0.3
# Steps longer than this leave the region where the Jacobian says anything.
LONGEST_STEP = 0.5
ITERATIONS = 60
# An attempt that has not halved its error in this many iterations sits in a local minimum.
PATIENCE = 12
# After the first beginning so many times as many are tried as before, side by side: nineteen at
# once take less than half the time that they take one by one.
HANDFUL = 4
# Where iterating stops; well inside any tolerance asked for, because convergence is fast there.
CLOSE_ENOUGH = 2e-5

_IDENTITY = np.eye(6)


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
    """

    frames: Floats
    axes: Floats
    revolute: NDArray[np.bool_]
    lower: Floats
    upper: Floats

    @classmethod
    def of(cls, urdf: Urdf, joints: Sequence[str], tcp_link: str, tcp_offset: Pose) -> Self:
        """Read a chain off a URDF.

        Args:
            urdf: The robot.
            joints: Names of the arm's joints, from the base outwards. Other joints on the way are
                taken at zero.
            tcp_link: The link that carries the tool.
            tcp_offset: The tool's frame in that link's.

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
        )

    def forward(self, positions: Sequence[float]) -> Pose:
        """Pose of the tool with the joints at positions (rad or m)."""
        tool = self._frames_at(np.asarray(positions, dtype=np.float64))[-1]
        x, y, z = tool[:3, :3].T.tolist()
        return Pose(_vector(tool[:3, 3]), from_axes(tuple(x), tuple(y), tuple(z)))

    def within_limits(self, positions: Sequence[float], margin: float = 0.0) -> bool:
        """Whether every joint is at least ``margin`` (rad or m) inside its limits."""
        at = np.asarray(positions)
        return bool((at >= self.lower + margin).all() and (at <= self.upper - margin).all())

    def _frames_at(self, positions: Floats) -> Floats:
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

    def _jacobian(self, frames: Floats) -> Floats:
        """(..., 6, n) velocity of the tool's origin, then its angular velocity, for each joint's.

        Args:
            frames: (..., n + 1, 4, 4) as of `_frames_at`.
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
    goal = _matrix(target)
    best: IkResult | None = None
    begun = 0
    while begun < attempts:
        before = rng.bit_generator.state
        count = min(max(1, HANDFUL * begun), attempts - begun)
        beginnings = _beginnings(chain, rng, count) if begun else _within(chain, start)
        for number, descended in enumerate(_descend(chain, goal, beginnings), start=1):
            found = _nearest_turn(chain, descended, start)
            result = _judged(chain, target, found, position_tolerance_m, angle_tolerance)
            if result.ok:
                if number < count:  # as if the later ones had never been drawn
                    rng.bit_generator.state = before
                    _beginnings(chain, rng, number)
                return result
            if best is None or _badness(result) < _badness(best):
                best = result
        begun += count
    if best is None:
        raise SimulationError(f"inverse kinematics needs at least one attempt, not {attempts}")
    return best


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


def _descend(chain: Chain, goal: Floats, beginnings: Floats) -> list[Floats]:
    """Levenberg-Marquardt from several beginnings, side by side: (k, n), n for each.

    The damping is the error itself plus a constant, which makes steps bold near a solution and
    short near a singularity: Sugihara, "Solvability-unconcerned inverse kinematics by the
    Levenberg-Marquardt method", IEEE Trans. Robotics 27(5), 2011.
    """
    descents = [_Descent(beginning) for beginning in beginnings]
    going, positions = list(descents), beginnings
    for iteration in range(ITERATIONS + 1):
        frames = chain._frames_at(positions)
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
    jacobian = chain._jacobian(frames)
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


def _within(chain: Chain, start: Sequence[float]) -> Floats:
    """(1, n) joint positions, brought inside the limits."""
    return np.clip(np.asarray(start, dtype=np.float64), chain.lower, chain.upper)[None]


def _beginnings(chain: Chain, rng: np.random.Generator, count: int) -> Floats:
    """(count, n) joint positions at random inside the limits."""
    # One turn is all there is to choose from; wider limits would only spread the guesses.
    widest = np.where(chain.revolute, math.pi, math.inf)
    lower, upper = np.maximum(chain.lower, -widest), np.minimum(chain.upper, widest)
    return rng.uniform(lower, upper, (count, len(lower)))


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
