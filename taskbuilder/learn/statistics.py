"""Statistics of what was measured: what several episodes or runs say together.

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
"""Of a bootstrap."""


def iqm(scores: ArrayLike, axis: int = 0) -> Numbers:
    """The interquartile mean: of the middle half, a quarter being left out at either end.

    Of n scores, n // 4 are left out at either end; fewer than four are all taken.

    Args:
        scores: Any array; along the axis there is at least one.
        axis: Along which the mean is taken.

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
    """The stratified bootstrap's band of a statistic over runs (percentiles).

    Runs are drawn again, with replacement, within each stratum, a whole run at a time, so that
    neither how many runs a task has nor what happens along a curve is left to chance.

    Args:
        strata: The runs of each task: (runs, …) scores each, alike but for the number of runs.
        rng: Draws.
        statistic: Of all runs together, given an array and the axis of the runs.
        level: How sure the band is.
        resamples: How often runs are drawn.

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
    """Scores on a scale on which random actions have 0 and the expert has 1.

    Raises:
        ValueError: The expert scores as random actions do, so that there is no scale.
    """
    if expert == random:
        raise ValueError(f"random actions and the expert both score {expert}")
    scale: Numbers = (np.asarray(scores, dtype=np.float64) - random) / (expert - random)
    return scale
