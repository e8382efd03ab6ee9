"""Evaluating policies in episodes that they have never seen.

Episodes begin in the task's own initial states, and actions have no exploration noise. The seeds
are separate from those of demonstrations and of the evaluations that policies are chosen by (see
`demonstrations` and `checkpoint_evaluator`). Training draws its seeds at random from 31 bits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean, median

import numpy as np

from taskbuilder.evaluation.comparison import Comparison
from taskbuilder.evaluation.statistics import iqm
from taskbuilder.intervals import wilson
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.disturbances import disturbance_text

SEED = 2_000_000
"""First seed of held-out evaluations: neither training nor checkpoints use these episodes."""

EPISODES = 300
"""Default number of episodes of an evaluation."""


@dataclass(frozen=True)
class EvaluationSummary:
    """The results of an evaluation.

    Attributes:
        episodes: Number of episodes.
        successes: Number of episodes in which success held at some step.
        interval: 95 % Wilson interval of the success rate.
        mean_return: Mean team return.
        iqm_return: Interquartile mean of the team return.
        steps_to_success: Median over the successful episodes, or None if there are none.
        successes_at_end: Number of successful episodes in which success held at the last step.
        interval_at_end: 95 % Wilson interval of the success rate at the end.
        success_held_s: Mean and median time for which success held in the successful episodes, in
            seconds, or None if there are none.
        peak_robot_force: Median and maximum over the episodes of the largest force between two
            robots, in newtons, or None if it was not measured.
        stages: Number of episodes by the last stage reached, none (0) first.
        terms: Mean sum of every reward term, by label.
        best: Seed of the best episode: success first, then the highest return.
        median: Seed of the median episode in this order.
        failed: Seed of the median unsuccessful episode, or None.
        task_version: The version of the task.
        baselines: The comparison with the baselines, or None if none have played.
        rollouts: The records of all episodes, where they were kept.
        disturbed: The results under each disturbance that was asked for, from the same seeds.
    """

    episodes: int
    successes: int
    interval: tuple[float, float]
    mean_return: float
    iqm_return: float
    steps_to_success: float | None
    successes_at_end: int
    interval_at_end: tuple[float, float]
    success_held_s: tuple[float, float] | None
    peak_robot_force: tuple[float, float] | None
    stages: tuple[int, ...]
    terms: Mapping[str, float]
    best: int
    median: int
    failed: int | None
    task_version: int = 1
    baselines: Comparison | None = None
    rollouts: tuple[Rollout, ...] = field(default=(), repr=False, compare=False)
    disturbed: tuple[Disturbed, ...] = ()

    @property
    def success_rate(self) -> float:
        """Fraction of the episodes in which success held at some step."""
        return self.successes / self.episodes

    @property
    def success_at_end_rate(self) -> float:
        """Fraction of the episodes that succeeded and in which success held at the end."""
        return self.successes_at_end / self.episodes


@dataclass(frozen=True)
class Disturbed:
    """A disturbance, and what a policy achieves under it.

    Attributes:
        axis: What is disturbed, such as ``mass``.
        level: How much.
        why_not: Why the disturbance does not apply to this policy and task; "" if it does.
        summary: The results under the disturbance; None if it does not apply.
    """

    axis: str
    level: float
    why_not: str = ""
    summary: EvaluationSummary | None = None

    def __str__(self) -> str:
        return disturbance_text(self.axis, self.level)


def summarise(played: Sequence[Rollout], stages: int) -> EvaluationSummary:
    """Summarise episodes.

    Args:
        played: At least one episode.
        stages: Number of stages of the task.
    """
    returns = [episode.team_return for episode in played]
    to_success = [e.first_success for e in played if e.first_success is not None]
    at_end = sum(episode.success_at_end for episode in played)
    held = [episode.success_held_s for episode in played if episode.success]
    peaks = [e.peak_robot_force for e in played if e.peak_robot_force is not None]
    order = sorted(played, key=_merit)
    failed = [episode.seed for episode in order if not episode.success]
    furthest = np.bincount([episode.stage[-1] for episode in played], minlength=stages + 1)
    terms = [episode.term_returns for episode in played]
    return EvaluationSummary(
        episodes=len(played),
        successes=len(to_success),
        interval=wilson(len(to_success), len(played)),
        mean_return=fmean(returns),
        iqm_return=float(iqm(returns)),
        steps_to_success=median(to_success) if to_success else None,
        successes_at_end=at_end,
        interval_at_end=wilson(at_end, len(played)),
        success_held_s=(fmean(held), median(held)) if held else None,
        peak_robot_force=(median(peaks), max(peaks)) if peaks else None,
        stages=tuple(furthest.tolist()),
        terms={label: fmean(each[label] for each in terms) for label in terms[0]},
        best=order[-1].seed,
        median=order[len(order) // 2].seed,
        failed=failed[len(failed) // 2] if failed else None,
    )


def _merit(episode: Rollout) -> tuple[bool, float, int]:
    return episode.success, episode.team_return, -episode.seed
