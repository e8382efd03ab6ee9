"""Evaluating policies during training, in episodes that are not used for training."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.env.parallel import parallel_env
from taskbuilder.evaluation.summary import summarise
from taskbuilder.learn.plan import Plan
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task

SEEDS_FROM = 800_000
"""First seed of the episodes that policies are chosen by; results are reported on others."""


FILMS = "films"
"""Folder of a run's films."""


@dataclass(frozen=True)
class Evaluation:
    """The result of evaluating a policy.

    Attributes:
        success_at_end: Fraction of the episodes in which success held at the last control step.
        row: The row for the table of evaluations.
    """

    success_at_end: float
    row: Mapping[str, float]


class CheckpointEvaluator:
    """Evaluates policies in the same episodes each time, without exploration.

    Args:
        task: The task.
        plan: The plan of the run.
        folder: Folder of the run, for its films.
    """

    def __init__(self, task: Task, plan: Plan, folder: Path) -> None:
        self._plan, self._films = plan, folder / FILMS
        self._env = parallel_env(task, **plan.env)
        self._stages = len(task.description.stages)
        self._seeds = range(SEEDS_FROM, SEEDS_FROM + plan.evaluate_episodes)

    def __call__(self, policy: TrainedPolicy) -> Evaluation:
        """Evaluate a policy.

        Raises:
            OSError: A film cannot be written.
        """
        player = policy.player()
        episodes = [play(self._env, player, seed) for seed in self._seeds]
        played = summarise(episodes, self._stages)
        if self._plan.films_at(step := int(policy.about["step"])):
            self._film(episodes[0], step)
        steps = played.steps_to_success
        row = {
            "episodes": played.episodes,
            "success_rate": played.success_rate,
            "success_at_end_rate": played.success_at_end_rate,
            "team_return": played.mean_return,
            "steps_to_success": -1.0 if steps is None else steps,
            **{f"stage/{stage}": count for stage, count in enumerate(played.stages)},
        }
        return Evaluation(played.success_at_end_rate, row)

    def _film(self, episode: Rollout, step: int) -> None:
        """Film an episode from the first camera of the scene."""
        from taskbuilder.visual.film import save_film  # loads OpenCV

        self._films.mkdir(exist_ok=True)
        save_film(self._env, episode, (), self._films / f"step-{step:09d}", gif=False)

    def close(self) -> None:
        """Close the environment."""
        self._env.close()
