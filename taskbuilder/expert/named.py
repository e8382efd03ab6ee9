"""Policies by name: the expert and two baselines."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from taskbuilder.env.actions import can_be_planned
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.players import HoldStill, RandomActions
from taskbuilder.task import Task
from taskbuilder.wording import suggestion

POLICIES: Mapping[str, Callable[[TaskEnv], Policy]] = {
    "expert": Expert,
    "random": lambda _: RandomActions(),
    "nothing": lambda _: HoldStill(),
}
"""Factories of these policies for an environment."""


def policy_named(name: str) -> Callable[[TaskEnv], Policy]:
    """The factory of a policy by its name.

    Raises:
        UnknownNameError: There is no policy of this name.
    """
    if name not in POLICIES:
        raise UnknownNameError(f'no policy "{name}"; {suggestion(name, POLICIES, what="one of")}')
    return POLICIES[name]


def has_expert(task: Task) -> bool:
    """Whether a task has an expert whose action modes can be planned for."""
    spec = task.file.spec
    robots = spec.scene.robots.values()
    return bool(spec.expert) and all(can_be_planned(robot.action) for robot in robots)
