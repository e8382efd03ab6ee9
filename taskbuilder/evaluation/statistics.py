"""Statistics over several episodes or runs.

Learning curves follow Agarwal et al. 2021 ("Deep reinforcement learning at the edge of the
statistical precipice"): the interquartile mean over runs, with a stratified bootstrap band.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskbuilder.intervals import LEVEL

Numbers = NDArray[np.float64]

RESAMPLES = 2000
"""Resamples of a bootstrap."""


def iqm(scores: ArrayLike, axis: int = 0) -> Numbers:
    """The interquartile mean: the mean of the middle half.

    Of n scores, n // 4 are left out at either end; if there are fewer than four, all are used.

    Args:
        scores: Any array with at least one score along the axis.
        axis: Axis of the mean.

    Raises:
        ValueError: There are no scores.
    """
    ordered = np.moveaxis(np.sort(np.asarray(scores, dtype=np.float64), axis=axis), axis, 0)
    if not len(ordered):
        raise ValueError("the interquartile mean of no scores")
    cut = len(ordered) // 4
    mean: Numbers = ordered[cut : len(ordered) - cut].mean(0)
    return mean


def bootstrap_band(
    strata: Sequence[Numbers],
    rng: np.random.Generator,
    *,
    statistic: Callable[[Numbers, int], Numbers] = iqm,
    level: float = LEVEL,
    resamples: int = RESAMPLES,
) -> tuple[Numbers, Numbers]:
    """The stratified bootstrap band of a statistic over runs (percentiles).

    Whole runs are resampled with replacement within each stratum. So the number of runs of each
    task is kept, and each curve stays whole.

    Args:
        strata: The runs of each task: (runs, …) scores each, alike except for the number of runs.
        rng: Generator of the resamples.
        statistic: The statistic of all runs, called with an array and the axis of the runs.
        level: Confidence level of the band.
        resamples: Number of resamples.

    Returns:
        Low and high, each of the shape of one run's scores.

    Raises:
        ValueError: A stratum has no runs.
    """
    if not strata or any(not len(runs) for runs in strata):
        raise ValueError("every stratum needs runs")
    drawn = [runs[rng.integers(len(runs), size=(resamples, len(runs)))] for runs in strata]
    values = statistic(np.concatenate(drawn, axis=1), 1)
    low, high = np.quantile(values, [0.5 - level / 2.0, 0.5 + level / 2.0], axis=0)
    return low, high


def normalised(scores: ArrayLike, *, random: float, expert: float) -> Numbers:
    """Normalised scores: 0 for random actions and 1 for the expert.

    Raises:
        ValueError: The expert and random actions have the same score, so there is no scale.
    """
    if expert == random:
        raise ValueError(f"random actions and the expert both score {expert}")
    scale: Numbers = (np.asarray(scores, dtype=np.float64) - random) / (expert - random)
    return scale
