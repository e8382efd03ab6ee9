"""Observation channels: reading them from the world, and their layout in a vector."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.actions import RobotActions
from taskbuilder.env.foreign_channels import ForeignChannel
from taskbuilder.env.naming import channel_names, with_matrix
from taskbuilder.geometry import Pose, Quat, multiply
from taskbuilder.schema.channels import CAMERA_QUANTITIES, Channel
from taskbuilder.schema.task import Noise
from taskbuilder.sim.divergence import REACH_M, SPEED_LIMIT
from taskbuilder.world.world import World

if TYPE_CHECKING:
    from taskbuilder.env.episode import Episode

Read = Callable[["Episode"], Sequence[float]]

_FORCE_LIMIT = 1e4  # newtons

POSITIONS = ("pose", "position", "tcp")
"""Quantities of channels that have a position."""


@dataclass(frozen=True)
class ObservedValue:
    """A channel of numbers.

    Attributes:
        name: Name in the task file.
        read: Reads the numbers from an episode.
        low: Lower bound of each number.
        high: Upper bound of each number.
        turns: Index of the first number of a quaternion, or None.
        noise: Gaussian noise on the numbers, or None.
        names: Name of each number, such as ``left.joint_3``.
        matrix: Convert the quaternion to the first two columns of its rotation matrix.
        log: Compress the position, the first three numbers; see `compressed`.
    """

    name: str
    read: Read
    low: tuple[float, ...]
    high: tuple[float, ...]
    turns: int | None = None
    noise: Noise | None = None
    names: tuple[str, ...] = ()
    matrix: bool = False
    log: bool = False

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.low)

    def with_matrix(self) -> ObservedValue:
        """The same channel with its rotation as two columns of the matrix, six numbers."""
        if self.turns is None:
            return self
        unit = (1.0,) * 6
        low = (*self.low[: self.turns], *(-n for n in unit))
        high = (*self.high[: self.turns], *unit)
        names = with_matrix(self.names, self.turns)
        return replace(self, low=low, high=high, names=names, matrix=True)

    def with_log(self) -> ObservedValue:
        """The same channel with its position compressed."""
        low, high = (_with_position_compressed(bound) for bound in (self.low, self.high))
        return replace(self, low=low, high=high, log=True)

    def values_of(self, episode: Episode) -> Sequence[float]:
        """The current values."""
        values = self.read(episode)
        if self.noise is not None:
            values = self.noisy(values, episode.noise_rng)
        if self.log:
            values = _with_position_compressed(values)
        if self.matrix and self.turns is not None:
            x, y, z, w = values[self.turns :]
            return (*values[: self.turns], *_columns((x, y, z, w)))
        return values

    def noisy(self, values: Sequence[float], rng: np.random.Generator) -> Sequence[float]:
        """The values with the channel's noise."""
        if self.noise is None:
            return values
        numbers = list(values)
        plain = self.turns if self.turns is not None else len(numbers)
        spread = self.noise.std or self.noise.position_std
        if spread:
            numbers[:plain] = [v + float(rng.normal(0.0, spread)) for v in numbers[:plain]]
        if self.turns is not None and self.noise.angle_std_deg:
            half = math.radians(self.noise.angle_std_deg) / 2.0
            x, y, z = (float(v) for v in rng.normal(0.0, half, 3))
            length = math.sqrt(1.0 + x * x + y * y + z * z)
            small: Quat = (x / length, y / length, z / length, 1.0 / length)
            a, b, c, d = numbers[plain : plain + 4]
            numbers[plain : plain + 4] = _upper(multiply(small, (a, b, c, d)))
        return numbers


@dataclass(frozen=True)
class ObservedGroup:
    """A channel of a group: that of every member, one after the other.

    Attributes:
        name: Name in the task file.
        of: The members' channels.
    """

    name: str
    of: tuple[ObservedValue, ...]

    @property
    def low(self) -> tuple[float, ...]:
        """Lower bound of each number."""
        return tuple(bound for each in self.of for bound in each.low)

    @property
    def high(self) -> tuple[float, ...]:
        """Upper bound of each number."""
        return tuple(bound for each in self.of for bound in each.high)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number."""
        return tuple(name for each in self.of for name in each.names)

    @property
    def size(self) -> int:
        """Number of values."""
        return sum(each.size for each in self.of)

    def with_matrix(self) -> ObservedGroup:
        """The same channel with rotations as columns of matrices."""
        return replace(self, of=tuple(each.with_matrix() for each in self.of))

    def with_log(self) -> ObservedGroup:
        """The same channel with positions compressed."""
        return replace(self, of=tuple(each.with_log() for each in self.of))

    def values_of(self, episode: Episode) -> Sequence[float]:
        """The current values."""
        return [value for each in self.of for value in each.values_of(episode)]


Reading = ObservedValue | ObservedGroup


class View:
    """The channels of one observer: a vector of numbers, and cameras."""

    def __init__(self, readings: Sequence[Reading], cameras: Sequence[Channel]) -> None:
        self.readings = tuple(readings)
        self.cameras = tuple(cameras)
        numbers = [value for reading in self.readings for value in reading.low]
        self.low = np.array(numbers, dtype=np.float32)
        numbers = [value for reading in self.readings for value in reading.high]
        self.high = np.array(numbers, dtype=np.float32)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number of the vector."""
        return tuple(name for reading in self.readings for name in reading.names)

    def vector(self, episode: Episode) -> NDArray[np.float32]:
        """All channels of numbers, concatenated: (n,) float32, clipped to the bounds."""
        values: list[float] = []
        for reading in self.readings:
            values += reading.values_of(episode)
        array = np.array(values, dtype=np.float32)
        np.maximum(array, self.low, out=array)  # np.clip takes four times as long
        np.minimum(array, self.high, out=array)
        return array

    def split(self, vector: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
        """A vector's channels by name."""
        if not self.readings:
            return {}
        ends = np.cumsum([reading.size for reading in self.readings])[:-1]
        pieces = np.split(vector, ends)
        return {r.name: piece.copy() for r, piece in zip(self.readings, pieces, strict=True)}


def make_reading(name: str, channel: Channel, world: World, noise: Noise | None = None) -> Reading:
    """Make the reading of a channel of numbers.

    Args:
        name: Name in the task file.
        channel: The parsed channel.
        world: The world, for sizes and limits.
        noise: Gaussian noise on the channel.
    """
    if members := world.task.names.members(channel.subject):
        of = (replace(channel, subject=member) for member in members)
        return ObservedGroup(name, tuple(_reading(name, one, world, noise) for one in of))
    return _reading(name, channel, world, noise)


def _reading(name: str, channel: Channel, world: World, noise: Noise | None) -> ObservedValue:
    if channel.added:
        foreign = ForeignChannel.of(channel, world)
        low, high = (tuple(bound) for bound in zip(*foreign.bounds, strict=True))
        return ObservedValue(name, foreign.read, low, high, None, noise, foreign.names)
    read, low, high, turns = _parts(channel, world)
    acts = channel.quantity == "previous_action"
    action = _actions(world, channel.subject).short_names if acts else ()
    names = channel_names(channel, world, action)
    return ObservedValue(name, read, low, high, turns, noise, names)


def is_camera(channel: Channel, world: World) -> bool:
    """Whether a channel is an image of a camera."""
    return channel.subject in world.scene.cameras and channel.quantity in CAMERA_QUANTITIES


def with_position_noise(noise: Noise | None, std: float) -> Noise:
    """The noise of a channel of positions, with independent noise of a standard deviation added.

    Args:
        noise: Its noise in the task file, or None.
        std: In metres.
    """
    own = noise or Noise()
    total = math.hypot(own.std or own.position_std or 0.0, std)
    return own.model_copy(update={"std": None, "position_std": total})


_Parts = tuple[Read, tuple[float, ...], tuple[float, ...], int | None]


def _parts(channel: Channel, world: World) -> _Parts:
    if channel.quantity == "time_left":
        return (lambda e: (e.time_left,)), (0.0,), (1.0,), None
    if channel.subject in world.robots:
        return _robot_parts(channel, world)
    inside = world.objects.get(channel.subject)
    if inside is not None and channel.quantity in inside.body.joints:
        name = f"{channel.subject}.{channel.quantity}"
        return (lambda e: (e.world.joint(name),)), (-REACH_M,), (REACH_M,), None
    return _frame_parts(channel.subject, channel.quantity, channel.frame)


def _robot_parts(channel: Channel, world: World) -> _Parts:
    name, robot = channel.subject, world.robots[channel.subject]
    dof = robot.dof
    match channel.quantity:
        case "tcp":
            return _frame_parts(f"{name}.tcp", "pose", channel.frame)
        case "tcp_velocity":
            return _frame_parts(f"{name}.tcp", "velocity", channel.frame)
        case "joints":
            return (lambda e: e.world.robots[name].arm_state()[0]), *_around(dof, REACH_M), None
        case "joint_velocities":
            return (lambda e: e.world.robots[name].arm_state()[1]), *_around(dof, SPEED_LIMIT), None
        case "gripper":
            return (lambda e: (e.world.robots[name].opening(),)), (-0.5,), (1.5,), None
        case "holding":
            return (lambda e: (e.holding(name),)), (0.0,), (1.0,), None
        case "force":
            tips = len(robot.gripper.tips)
            return (lambda e: e.forces(name)), (0.0,) * tips, (_FORCE_LIMIT,) * tips, None
        case "previous_action":
            size = _actions(world, name).size
            return (lambda e: e.previous_action(name)), *_around(size, 1.0), None
    raise ValueError(f"a robot has no channel {channel.quantity}")


def _actions(world: World, name: str) -> RobotActions:
    """The actions of a robot, for their size and names."""
    dt = 1.0 / world.spec.timing.control_hz
    return RobotActions(world, world.robots[name], world.scene.robots[name].action, dt)


def _frame_parts(subject: str, quantity: str, frame: str) -> _Parts:
    here = _pose_reader(subject, frame)
    match quantity:
        case "pose":
            low, high = _around(3, REACH_M)
            unit = (1.0,) * 4
            low, high = (*low, -1.0, -1.0, -1.0, 0.0), (*high, *unit)
            return (lambda e: _pose_numbers(here(e.world))), low, high, 3
        case "position":
            return (lambda e: here(e.world).position), *_around(3, REACH_M), None
        case "orientation":
            low, high = (-1.0, -1.0, -1.0, 0.0), (1.0,) * 4
            return (lambda e: _upper(here(e.world).quaternion)), low, high, 0
        case "velocity":
            return (lambda e: _velocity(e.world, subject, frame)), *_around(6, SPEED_LIMIT), None
    raise ValueError(f"{subject} has no channel {quantity}")


def _pose_reader(subject: str, frame: str) -> Callable[[World], Pose]:
    if frame == "world":
        return lambda world: world.pose(subject)
    return lambda world: world.pose(frame).inverse() @ world.pose(subject)


def _velocity(world: World, subject: str, frame: str) -> Sequence[float]:
    """Velocity relative to the world, in the axes of a frame."""
    linear, angular = world.velocity(subject)
    if frame == "world":
        return (*linear, *angular)
    back = Pose((0.0, 0.0, 0.0), world.pose(frame).quaternion).inverse()
    return (*back.apply(linear), *back.apply(angular))


def _pose_numbers(pose: Pose) -> Sequence[float]:
    return (*pose.position, *_upper(pose.quaternion))


def compressed(metres: float) -> float:
    """asinh(x / 2 cm) / 2: linear for small x and logarithmic for large x, of either sign."""
    return math.asinh(metres / 0.02) / 2.0


def _with_position_compressed(values: Sequence[float]) -> tuple[float, ...]:
    """Compress the first three numbers, a position."""
    return (*map(compressed, values[:3]), *values[3:])


def _upper(q: Quat) -> Quat:
    """Of the two quaternions of a rotation, the one with w at least 0."""
    return q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])


def _columns(q: Quat) -> Sequence[float]:
    """The first two columns of a rotation's matrix (Zhou et al. 2019): continuous everywhere."""
    x, y, z, w = q
    first = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))
    return (*first, 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x))


def _around(size: int, limit: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return (-limit,) * size, (limit,) * size
