"""What actions should command: joint positions, velocities or torques, and gripper openings.

They are computed from the action modes and the spaces' bounds, past everything through which
actions reach the robots: wrappers, the views of an environment, and its episode.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from taskbuilder.env.actions import HYSTERESIS, make_mode
from taskbuilder.env.arm_modes import Arm, ArmMode
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

NEAR = 1e-5
"""Difference up to which commands count as equal: rad, m, or a share of an opening."""

_DIRECT = {"joint_velocity": "velocity", "joint_torque": "torque"}
"""Action modes whose numbers are themselves what motors are told."""


@dataclass(frozen=True)
class RobotCommand:
    """What a robot's motors are told.

    Attributes:
        mode: ``position``, ``velocity`` or ``torque``.
        arm: A value for each joint of the arm.
        opening: Of the gripper, from 0 to 1; None for a robot without one.
    """

    mode: str
    arm: Sequence[float]
    opening: float | None

    @classmethod
    def of(cls, robot: Robot) -> RobotCommand:
        """The last command of a robot."""
        told = robot.arm.command
        opening = robot.gripper.told() if robot.model.takes_hold else None
        return cls(told.mode, told.values, opening)

    def equals(self, other: RobotCommand) -> bool:
        """Whether another command is the same."""
        if self.mode != other.mode or len(self.arm) != len(other.arm):
            return False
        told, expected = list(self.arm), list(other.arm)
        if self.opening is not None and other.opening is not None:
            told, expected = [*told, self.opening], [*expected, other.opening]
        pairs = zip(told, expected, strict=True)
        return all(math.isclose(*pair, rel_tol=NEAR, abs_tol=NEAR) for pair in pairs)

    def difference(self, other: RobotCommand) -> str:
        """In what it differs from what it should be, in words."""
        if self.mode != other.mode:
            return f"its motors are told a {self.mode}, not a {other.mode}"
        pairs = list(zip(self.arm, other.arm, strict=False))
        number = max(range(len(pairs)), key=lambda at: abs(pairs[at][0] - pairs[at][1]))
        told, expected = pairs[number]
        if math.isclose(told, expected, rel_tol=NEAR, abs_tol=NEAR):
            return f"its gripper is told {self.opening:.3g}, not {other.opening:.3g}"
        return f"joint_{number + 1} is told {told:.4g}, not {expected:.4g}"


class Commands:
    """The commands that actions should lead to.

    Args:
        env: The environment.
    """

    def __init__(self, env: TaskEnv) -> None:
        self._env = env
        self._file = env.options.applied(env.task)
        self._dt = 1.0 / self._file.spec.timing.control_hz
        self._world: World | None = None
        self._specs: dict[str, ActionSpec] = {}
        self._modes: dict[str, ArmMode] = {}
        self._sent: dict[str, deque[list[float]]] = {}
        self.begin()

    def begin(self) -> None:
        """Begin an episode."""
        self._look_up()
        self._sent = {name: deque() for name in self._specs}

    def _look_up(self) -> None:
        """Make the modes of the world, which another variation or a divergence replaces."""
        world = self._env.episode.world
        if world is not self._world:
            self._world = world
            self._specs = {
                name: _framed(robot.action, self._env.options.frame)
                for name, robot in self._file.scenes[self._env.episode.variation].robots.items()
            }
            self._modes = {
                name: make_mode(Arm.of(world, world.robots[name], spec, self._dt))
                for name, spec in self._specs.items()
            }

    def size(self, name: str) -> int:
        """How many numbers an action of a robot has."""
        return len(self._bounds(name))

    def names(self, name: str) -> tuple[str, ...]:
        """The name of each number of a robot's action."""
        grips = ("gripper",) if self._robot(name).model.takes_hold else ()
        return tuple(f"{name}.{part}" for part in (*self._modes[name].names, *grips))

    def unit(self, name: str, action: Sequence[float]) -> list[float]:
        """An action, scaled to the range from -1 to 1 and clipped to it."""
        if not self._env.options.normalize:
            bounds = self._bounds(name)
            shares = zip(action, bounds, strict=True)
            action = [2.0 * (value - low) / (high - low) - 1.0 for value, (low, high) in shares]
        return [min(max(value, -1.0), 1.0) for value in action]

    def units(self, robots: Sequence[str], action: Any) -> dict[str, list[float]]:
        """The action of each robot, from -1 to 1.

        Args:
            robots: The robots that an agent moves.
            action: The agent's action, with the numbers of all robots in their order.
        """
        if isinstance(action, Mapping) and all(
            isinstance(action.get(robot), Mapping) for robot in robots
        ):
            parts = {robot: list(numbers(action[robot])) for robot in robots}
        else:
            flat = numbers(action)
            parts = {robot: list(islice(flat, self.size(robot))) for robot in robots}
        return {robot: self.unit(robot, part) for robot, part in parts.items()}

    def mistakes(
        self, robot: str, sent: Mapping[str, Sequence[float]], before: Sequence[float]
    ) -> dict[str, RobotCommand]:
        """What a robot would be told by common mistakes, by their description.

        Args:
            robot: The robot.
            sent: The action of each robot, from -1 to 1.
            before: The robot's action in the step before.
        """
        own = sent[robot]
        wrong = {
            "half of it": [0.5 * number for number in own],
            "its opposite": [-number for number in own],
            "its numbers in reverse order": own[::-1],
            "the action before it": before,
        }
        for other, action in sent.items():
            if other != robot and len(action) == len(own):
                wrong[f"the action of {other}"] = action
        known = {why: action for why, action in wrong.items() if not any(map(math.isnan, action))}
        return {why: self.command(robot, action) for why, action in known.items()}

    def expected(self, sent: Mapping[str, Sequence[float]]) -> dict[str, RobotCommand]:
        """The command of each robot that has something to carry out now.

        Args:
            sent: The action of each robot, from -1 to 1, that is sent now.
        """
        self._look_up()
        due = {}
        for name, action in sent.items():
            waiting = self._sent[name]
            waiting.append(list(action))
            if len(waiting) > self._env.episode.delay(name):
                due[name] = waiting.popleft()
        return {name: self.command(name, action) for name, action in due.items()}

    def command(self, name: str, action: Sequence[float]) -> RobotCommand:
        """The command that an action, from -1 to 1, of a robot leads to from where it stands."""
        robot, mode, spec = self._robot(name), self._modes[name], self._specs[name]
        values = [
            low + (share + 1.0) / 2.0 * (high - low)
            for share, (low, high) in zip(action, self._bounds(name), strict=True)
        ]
        opening = None
        if robot.model.takes_hold:
            opening = self._opening(robot, spec, values.pop())
        if spec.arm in _DIRECT:
            return RobotCommand(_DIRECT[spec.arm], values, opening)
        return RobotCommand("position", mode.command(values) or (), opening)

    def _opening(self, robot: Robot, spec: ActionSpec, value: float) -> float:
        if spec.gripper == "continuous":
            return value / robot.model.stroke
        return robot.gripper.told() if abs(value) <= HYSTERESIS else float(value > 0.0)

    def _bounds(self, name: str) -> list[tuple[float, float]]:
        robot, bounds = self._robot(name), list(self._modes[name].bounds)
        if robot.model.takes_hold:
            continuous = self._specs[name].gripper == "continuous"
            bounds.append((0.0, robot.model.stroke) if continuous else (-1.0, 1.0))
        return bounds

    def _robot(self, name: str) -> Robot:
        return self._env.episode.world.robots[name]


def numbers(action: Any) -> Iterator[float]:
    """The numbers of an action in order, also of one that is a dictionary."""
    if isinstance(action, Mapping):
        for part in ("arm", "gripper"):
            if part in action:
                yield from numbers(action[part])
    else:
        yield from np.asarray(action, dtype=np.float64).ravel().tolist()


def _framed(spec: ActionSpec, frame: str) -> ActionSpec:
    if frame == "base" and spec.frame == "world":
        return spec.model_copy(update={"frame": "base"})
    return spec
