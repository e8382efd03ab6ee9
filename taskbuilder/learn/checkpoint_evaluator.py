"""Evaluating policies during training, in episodes that are not used for training."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from taskbuilder.env.parallel import parallel_env
from taskbuilder.learn.evaluation import summarise
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.rollout.play import play
from taskbuilder.task import Task

SEEDS_FROM = 800_000
"""First seed of the episodes that policies are chosen by; results are reported on others."""


@dataclass(frozen=True)
class Evaluation:
    """The result of evaluating a policy.

    Attributes:
        success: Fraction of the episodes that succeeded.
        row: The row for the table of evaluations.
    """

    success: float
    row: Mapping[str, float]


class CheckpointEvaluator:
    """Evaluates policies in the same episodes each time, without exploration.

    Args:
        task: The task.
        options: Options of the environment; see `Options`.
        episodes: Number of episodes.
    """

    def __init__(self, task: Task, options: Mapping[str, Any], episodes: int) -> None:
        self._env = parallel_env(task, **options)
        self._stages = len(task.description.stages)
        self._seeds = range(SEEDS_FROM, SEEDS_FROM + episodes)

    def __call__(self, policy: TrainedPolicy) -> Evaluation:
        """Evaluate a policy."""
        player = policy.player()
        played = summarise([play(self._env, player, seed) for seed in self._seeds], self._stages)
        steps = played.steps_to_success
        row = {
            "episodes": played.episodes,
            "success_rate": played.success_rate,
            "team_return": played.mean_return,
            "steps_to_success": -1.0 if steps is None else steps,
            **{f"stage/{stage}": count for stage, count in enumerate(played.stages)},
        }
        return Evaluation(played.success_rate, row)

    def close(self) -> None:
        """Close the environment."""
        self._env.close()
