"""Judging the robots that play a probe by what success asks of them, and not of the missing ones.

A probe without a robot may fail for no other reason than that success has a clause about this
robot, such as that it holds something. The same episode is therefore judged a second time, by
success without the clauses that speak of the missing robots only.
"""

from __future__ import annotations

from typing import Any

from taskbuilder.description.description import Description, Referee
from taskbuilder.description.logic import Sustained
from taskbuilder.description.node import Condition
from taskbuilder.description.robot_clauses import Reduced, without_robots
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.baselines import Baseline, BaselineKind
from taskbuilder.task import Task

KEPT_S = 0.5
"""Time in seconds for which the rest of success must hold; what only falls past it does not."""


def missing_robots(task: Task, baseline: Baseline) -> tuple[str, ...]:
    """The robots that take no part in a probe although others do."""
    if baseline.kind is BaselineKind.WITHOUT:
        return (baseline.robot,)
    if baseline.kind is BaselineKind.ALONE:
        return tuple(robot for robot in task.agents if robot != baseline.robot)
    return ()


def reduced_success(task: Task, missing: tuple[str, ...]) -> Reduced:
    """Success without the clauses that speak of the missing robots only."""
    return without_robots(task.description.success, missing, task.agents)


class RestReferee:
    """Watches an episode, and judges it by the rest of success.

    Call it with the environment after its reset and after each control step.

    Args:
        task: The task.
        rest: The rest of success.
    """

    def __init__(self, task: Task, rest: Condition) -> None:
        kept = Sustained(rest, KEPT_S)
        description = type("Rest", (Description,), {"success": kept, "rest": rest, "reward": ()})
        self._referee = Referee(description, task.agents)
        self._begun = self._reached = False

    @classmethod
    def of(cls, task: Task, baseline: Baseline) -> RestReferee | None:
        """A referee for a probe; None if success has no such clauses, or nothing else."""
        reduced = reduced_success(task, missing_robots(task, baseline))
        if not reduced.dropped or reduced.rest is None:
            return None
        return cls(task, reduced.rest)

    def __call__(self, env: TaskEnv) -> None:
        """Judge the current state of the environment."""
        episode = env.episode
        if episode.exploded:
            return
        if not episode.steps:
            self._begun = self._referee.start(episode.world).conditions["rest"]
            return
        won = self._referee.judge(episode.world).success
        self._reached = self._reached or (won and not episode.failed)

    @property
    def reached(self) -> bool:
        """Whether the rest of success was reached, and was not there from the start."""
        return self._reached and not self._begun

    @property
    def memory(self) -> Any:
        """What it remembers; set it to go back with the environment to a saved state."""
        return self._referee.memory

    @memory.setter
    def memory(self, memory: Any) -> None:
        self._referee.memory = memory
