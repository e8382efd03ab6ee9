"""What agents should observe, read from the scene by the definitions of the channels.

The environment has code of its own for this; the values here are what it is checked against. Poses
and joints are read from the physics engine, past everything that an environment keeps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.episode import Episode
from taskbuilder.env.foreign_channels import ForeignChannel
from taskbuilder.env.naming import channel_names, with_matrix
from taskbuilder.env.observations import POSITIONS
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.whole_scene import everything, surroundings
from taskbuilder.geometry import NO_TURN, ORIGIN, Pose, Quat
from taskbuilder.schema.channels import Channel, default_channels, parse_channel
from taskbuilder.schema.task import Noise
from taskbuilder.world.world import World

UNKNOWN = math.nan
"""Stands for a number with noise, or one that only the environment itself can tell, as a force."""

Numbers = NDArray[np.float64]

Previous = Mapping[str, Sequence[float]]
"""The last action of every robot, from -1 to 1."""


class SceneValues:
    """The numbers that an agent should observe, or those of the state.

    Args:
        env: The environment.
        agent: The agent; None for the state.

    Attributes:
        names: The name of each number, as `TaskEnv.observation_names` should have them.
    """

    def __init__(self, env: TaskEnv, agent: str | None) -> None:
        self._env = env
        self._agent = agent
        self._channels = [
            (replace(channel, subject=member), noisy)
            for text, channel in _channels(env, agent)
            for noisy in (_is_noisy(env, agent, text, channel),)
            for member in env.task.file.names.members(channel.subject) or (channel.subject,)
        ]
        self.names = tuple(name for channel, _ in self._channels for name in self._names(channel))

    def now(self, previous: Previous, names: Sequence[str]) -> Numbers:
        """The values now, `UNKNOWN` where there is nothing to compare with.

        Args:
            previous: The last action of every robot, from -1 to 1.
            names: The names of the numbers, in the order of the environment.
        """
        numbers: list[float] = []
        for channel, noisy in self._channels:
            values = self._formatted(channel, _values(channel, self._env.episode, previous))
            numbers += [UNKNOWN] * len(values) if noisy else values
        if names == self.names:
            return np.array(numbers)
        by_name = dict(zip(self.names, numbers, strict=True))
        return np.array([by_name.get(name, UNKNOWN) for name in names])

    def _names(self, channel: Channel) -> tuple[str, ...]:
        if channel.added:
            return ForeignChannel.of(channel, self._env.episode.world).names
        acts = channel.quantity == "previous_action"
        action = self._env.action_names[channel.subject] if acts else ()
        short = [name.rpartition(".")[2] for name in action]
        names = channel_names(channel, self._env.episode.world, short)
        turns = _TURNS.get(channel.quantity)
        matrix = turns is not None and self._env.options.rotation == "matrix"
        return with_matrix(names, turns) if matrix and turns is not None else names

    def _formatted(self, channel: Channel, values: Sequence[float]) -> list[float]:
        """The values in the format of the environment's options."""
        numbers = list(values)
        options, turns = self._env.options, _TURNS.get(channel.quantity)
        near = channel.quantity in POSITIONS and channel.frame.endswith(".tcp")
        if near and options.distances == "log":
            numbers[:3] = [math.asinh(metres / 0.02) / 2.0 for metres in numbers[:3]]
        if turns is not None:
            x, y, z, w = numbers[turns:]
            turn = Pose(ORIGIN, (x, y, z, w))
            if options.rotation == "matrix":
                numbers[turns:] = [*turn.axis(0), *turn.axis(1)]
        return numbers


_TURNS = {"pose": 3, "tcp": 3, "orientation": 0}
"""Where the quaternion of a channel begins, by the channel's quantity."""


def _channels(env: TaskEnv, agent: str | None) -> Iterator[tuple[str, Channel]]:
    """The channels that the task file or the options list for an agent, without cameras."""
    spec, names = env.task.file.spec, env.task.file.names
    if agent is None:
        texts = everything(env.episode.world) if spec.state == ("all",) else spec.state
    elif env.options.observe == "scene":
        texts = surroundings(agent, env.episode.world)
    else:
        texts = spec.observe[agent] if spec.observe else default_channels(names, agent)
    for text in dict.fromkeys(texts):
        channel = parse_channel(text, agent, names)
        if isinstance(channel, Channel) and channel.subject not in spec.scene.cameras:
            if agent and env.options.frame == "base" and channel.frame == "world":
                channel = replace(channel, frame=f"{agent}.base")
            yield text, channel


def _is_noisy(env: TaskEnv, agent: str | None, text: str, channel: Channel) -> bool:
    if agent is None:
        return False
    listed: Mapping[str, Noise] = env.task.file.spec.observation_noise.get(agent, {})
    return text in listed or bool(env.options.position_noise and channel.quantity in POSITIONS)


def _values(channel: Channel, episode: Episode, previous: Previous) -> Sequence[float]:
    world, subject = episode.world, channel.subject
    if channel.added:  # which only its package can tell
        return (UNKNOWN,) * len(ForeignChannel.of(channel, world).names)
    if channel.quantity == "time_left":
        return (max(0.0, 1.0 - episode.steps / episode.horizon),)
    if subject in world.robots:
        return _of_robot(channel, episode, previous)
    thing = world.objects.get(subject)
    if thing is not None and channel.quantity in thing.body.joints:
        return (thing.body.joint_position(channel.quantity),)
    return _of_frame(subject, channel.quantity, channel.frame, world)


def _of_robot(channel: Channel, episode: Episode, previous: Previous) -> Sequence[float]:
    world, name = episode.world, channel.subject
    robot = world.robots[name]
    match channel.quantity:
        case "tcp":
            return _of_frame(f"{name}.tcp", "pose", channel.frame, world)
        case "tcp_velocity":
            return _of_frame(f"{name}.tcp", "velocity", channel.frame, world)
        case "joints":
            return robot.arm_state()[0]
        case "joint_velocities":
            return robot.arm_state()[1]
        case "gripper":
            return (robot.opening(),)
        case "holding":
            return (float(any(world.held(thing, name) for thing in world.holdable)),)
        case "previous_action":
            return previous[name]
        case _:
            return (UNKNOWN,) * len(robot.gripper.tips)


def _of_frame(subject: str, quantity: str, frame: str, world: World) -> Sequence[float]:
    if quantity == "velocity":
        linear, angular = world.velocity(subject)
        turn = Pose(ORIGIN, _pose(frame, world).quaternion).inverse()
        return (*turn.apply(linear), *turn.apply(angular))
    pose = _pose(frame, world).inverse() @ _pose(subject, world)
    parts = {"position": pose.position, "orientation": _upper(pose.quaternion)}
    return parts.get(quantity, (*pose.position, *_upper(pose.quaternion)))


def _pose(frame: str, world: World) -> Pose:
    if frame == "world":
        return Pose(ORIGIN, NO_TURN)
    if frame in world.objects:
        return world.objects[frame].body.pose()
    robot, _, part = frame.partition(".")
    if part == "tcp" and robot in world.robots:
        return world.robots[robot].tcp
    return world.pose(frame)


def _upper(q: Quat) -> Quat:
    """Of the two quaternions of a rotation, the one with w at least 0."""
    return q if q[3] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])


def differ(seen: Numbers, expected: Numbers) -> NDArray[np.bool_]:
    """Where numbers are not what they should be; where that is unknown, they are."""
    return np.abs(seen - expected) > 1e-4 + 1e-4 * np.abs(expected)


def alike(seen: Numbers, other: Numbers | None) -> bool:
    """Whether numbers are others, as far as these are known; never if there are none."""
    if other is None or len(other) != len(seen) or np.isnan(other).all():
        return False
    return not differ(seen, other).any()
