"""Figures of a suite: the interquartile mean over its cells, and the performance profile.

Both are as Agarwal et al. 2021 define them ("Deep reinforcement learning at the edge of the
statistical precipice", and the package ``rliable``): the scores are those of all runs of all tasks,
and bands are percentiles of a bootstrap that resamples the runs of each task.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.evaluation.statistics import Numbers, bootstrap_band, iqm

SCORES = np.linspace(0.0, 1.0, 101)
"""Scores at which profiles are computed."""


@dataclass(frozen=True)
class Banded:
    """A figure, or a curve, with its bootstrap band.

    Attributes:
        value: The figure.
        low: Lower end of its 95 % band; None if a task has a single run.
        high: Upper end; None likewise.
    """

    value: Numbers
    low: Numbers | None
    high: Numbers | None


def interquartile_mean(scores: Sequence[Sequence[float]]) -> Banded:
    """The mean of the middle half of all scores.

    Args:
        scores: The scores of the runs of each task.

    Raises:
        ValueError: There are no tasks, or a task has no runs.
    """
    strata = [np.asarray(runs, dtype=np.float64) for runs in scores]
    return _banded(strata, iqm)


def performance_profile(scores: Sequence[Sequence[float]]) -> Banded:
    """The fraction of runs whose score is above each of `SCORES`: (101,) values.

    Args:
        scores: The scores of the runs of each task.

    Raises:
        ValueError: There are no tasks, or a task has no runs.
    """
    strata = [(np.asarray(runs)[:, None] > SCORES).astype(np.float64) for runs in scores]
    return _banded(strata, _mean)


def _mean(values: Numbers, axis: int = 0) -> Numbers:
    mean: Numbers = values.mean(axis)
    return mean


def _banded(strata: Sequence[Numbers], statistic: Callable[[Numbers, int], Numbers]) -> Banded:
    if not strata or any(not len(runs) for runs in strata):
        raise ValueError("every task needs a run")
    value = statistic(np.concatenate(strata), 0)
    if min(map(len, strata)) < 2:
        return Banded(value, None, None)
    rng = np.random.default_rng(0)  # the same draws for all, so that pages repeat
    return Banded(value, *bootstrap_band(strata, rng, statistic=statistic))
