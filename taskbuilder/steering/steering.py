"""Who steers which robot, and a policy of people and a player together."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from statistics import median
from typing import Any

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.actions import can_be_planned
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.expert.planning.reach import Reach
from taskbuilder.expert.script.player import Expert
from taskbuilder.geometry import Pose
from taskbuilder.rollout.play import Policy, Scripted
from taskbuilder.rollout.record import ScriptLog
from taskbuilder.steering.operator import Operator
from taskbuilder.wording import suggestion

HUMAN = "human"
"""The policy of episodes in which a person steered."""

STANDS_STILL = -1
"""Label of a control step in which a robot stood still that its person had left."""

OPEN = 0.5
"""Commanded opening above which a gripper counts as open."""


class Steering:
    """Who steers which robot; everybody steers at most one, and nobody the robot of another.

    Args:
        robots: The robots of the task.

    Attributes:
        robots: The same.
    """

    def __init__(self, robots: Sequence[str]) -> None:
        self.robots = tuple(robots)
        self._people: dict[Hashable, tuple[str, Operator]] = {}
        self._left: set[str] = set()

    def take(self, person: Hashable, robot: str, name: str = "") -> Operator:
        """A person takes a robot, and lets go of another one.

        Args:
            person: Who: anything that identifies a window.
            robot: The robot.
            name: Name of the person; by default they are numbered.

        Raises:
            UnknownNameError: There is no such robot.
            UsageError: Another person steers it.
        """
        if robot not in self.robots:
            raise UnknownNameError(f'no robot "{robot}"; {suggestion(robot, self.robots)}')
        for other, (own, operator) in self._people.items():
            if own == robot and other != person:
                raise UsageError(
                    f"{robot} is steered by {operator.name}; choose another robot, or ask "
                    f"{operator.name} to let go of it"
                )
        self.let_go(person)
        self._left.discard(robot)
        operator = Operator(name or f"person {len(self._people) + 1}")
        self._people[person] = robot, operator
        return operator

    def let_go(self, person: Hashable) -> None:
        """A person lets go of a robot, which follows the player again."""
        self._people.pop(person, None)

    def leave(self, person: Hashable) -> None:
        """A person is gone; the robot stands still until somebody takes it."""
        robot, _ = self._people.pop(person, ("", None))
        if robot:
            self._left.add(robot)

    def begin(self) -> None:
        """An episode begins: robots that stood still follow the player again."""
        self._left.clear()

    def robot_of(self, person: Hashable) -> str:
        """The robot that a person steers, or ""."""
        return self._people.get(person, ("", None))[0]

    @property
    def operators(self) -> dict[str, Operator]:
        """Who steers each robot that is steered."""
        return dict(self._people.values())

    @property
    def standing(self) -> frozenset[str]:
        """The robots that stand still because their people are gone."""
        return frozenset(self._left)


class SteeredPolicy:
    """A policy in which people steer some robots, and a player the others.

    An expert that plays waits in each of its stages for the robots that people steer; see
    `Expert.leave_out`.

    Args:
        player: The policy for the robots that nobody steers.
        name: What the player is called.
        steering: Who steers.
    """

    def __init__(self, player: Policy, name: str, steering: Steering) -> None:
        self.steering = steering
        self._player, self._name = player, name
        self._stopped = False
        self._lags: list[float] = []

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode."""
        self._player.reset(env, seed)
        self._env, self._encoder = env, ActionEncoder(env)
        self._stopped = False
        self._without: frozenset[str] = frozenset()
        self._names: list[str] = []
        self._labels: dict[str, list[int]] = {robot: [] for robot in env.possible_agents}
        self._lags = []
        self._reaches = {name: Reach.of(env.episode.world, name) for name in env.possible_agents}

    def stop(self) -> None:
        """End the episode before the next control step."""
        self._stopped = True

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The actions of the player, and of people in place of its own for their robots."""
        if self._stopped:
            return None
        operators, standing = self.steering.operators, self.steering.standing
        without = standing.union(operators)
        if isinstance(self._player, Expert) and without != self._without:
            self._player.leave_out(without)
        self._without = without
        actions = self._player.act(observations) or self._encoder.hold()
        commanded = self._commanded(operators)
        for robot in self._env.possible_agents:
            if robot in without:
                actions[robot] = commanded[robot]
            self._labels[robot].append(self._label(robot, operators, standing))
        return actions

    def _label(
        self, robot: str, operators: Mapping[str, Operator], standing: frozenset[str]
    ) -> int:
        """Whose a robot's next control step is: the player's, or a person's by number."""
        if robot in operators:
            return self._number(operators[robot])
        return STANDS_STILL if robot in standing else 0

    def _commanded(self, operators: Mapping[str, Operator]) -> Actions:
        """The actions of people; robots that nobody steers are held still."""
        joints, openings = {}, {}
        for robot, operator in operators.items():
            reach, modes = self._reaches[robot], self._env.episode.actions[robot]
            start = tuple(modes.commanded_after(self._env.episode.waiting(robot)))
            command = operator.command(reach.tool(start), modes.arm.spec)
            joints[robot] = self._joints(reach, start, command.tool)
            if command.grips:
                told = modes.arm.robot.gripper.told()
                openings[robot] = 0.0 if told > OPEN else 1.0
            self._lags += operator.lags_s
            operator.lags_s.clear()
        return self._encoder.actions(joints, openings)

    @staticmethod
    def _joints(reach: Reach, start: tuple[float, ...], tool: Pose) -> tuple[float, ...]:
        arm = reach.arm
        target = arm.base_from_world @ reach.commandable(tool)
        return arm.ik.step(start, target, reach.mode.longest)

    def _number(self, operator: Operator) -> int:
        """The number of a person in this episode, from 1."""
        if operator.name not in self._names:
            self._names.append(operator.name)
        return self._names.index(operator.name) + 1

    @property
    def lag_ms(self) -> float | None:
        """Median time from a key or a drag to its command, in milliseconds; None without any."""
        return round(median(self._lags) * 1000.0, 1) if self._lags else None

    def log(self) -> ScriptLog | None:
        """The log of the player's stages, if it follows any."""
        return self._player.log() if isinstance(self._player, Scripted) else None

    def notes(self) -> tuple[Mapping[str, Any], Arrays]:
        """Whose each control step of the episode was, for its record."""
        if not self._names:
            return {"policy": self._name}, {}
        about = {
            "policy": HUMAN,
            "player": self._name,
            "operators": list(self._names),
            "lag_ms": self.lag_ms,
        }
        rows = {
            f"agents/{robot}/operator": np.array(labels, dtype=np.int64)
            for robot, labels in self._labels.items()
        }
        return about, rows


def check_steerable(env: TaskEnv) -> None:
    """Check that people can steer the robots of an environment.

    Raises:
        UsageError: The action mode of a robot commands torques.
    """
    for name, robot in env.episode.world.scene.robots.items():
        if not can_be_planned(robot.action):
            raise UsageError(
                f"{name} cannot be steered: its action mode {robot.action.arm} commands torques; "
                "write another under action, such as tcp_delta"
            )
