"""The interquartile mean and the performance profile of a suite, beside values found by hand."""

from __future__ import annotations

import numpy as np
import pytest

from taskbuilder.benchmark.statistics import SCORES, interquartile_mean, performance_profile

TWO_TASKS = [(0.0, 0.2, 0.4, 1.0), (0.5, 0.6, 0.9, 1.0)]


def test_the_interquartile_mean_is_that_of_all_runs_of_all_tasks():
    # 0 0.2 | 0.4 0.5 0.6 0.9 | 1 1: of eight scores, two are left out at either end.
    found = interquartile_mean(TWO_TASKS)
    assert float(found.value) == pytest.approx((0.4 + 0.5 + 0.6 + 0.9) / 4)
    assert found.low < found.value < found.high


def test_the_profile_is_the_share_of_runs_above_each_score():
    found = performance_profile(TWO_TASKS)
    at = {round(score, 2): share for score, share in zip(SCORES, found.value, strict=True)}
    # Above 0: all but one run. Above 0.5: 1.0, 0.6, 0.9 and 1.0. Nothing is above 1.
    assert (at[0.0], at[0.5], at[0.95], at[1.0]) == (7 / 8, 4 / 8, 2 / 8, 0.0)
    assert np.all(np.diff(found.value) <= 0.0)
    assert np.all(found.low <= found.value)
    assert np.all(found.value <= found.high)


def test_a_band_resamples_the_runs_within_each_task():
    # Within a task all runs are alike, so no resample differs, however far tasks are apart.
    found = interquartile_mean([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)])
    assert (found.low, found.value, found.high) == (0.5, 0.5, 0.5)


def test_a_band_of_two_runs_is_that_of_their_resamples():
    # Of two runs, resamples are both the first (1/4), both the second (1/4), or one of each.
    found = interquartile_mean([(0.0, 1.0)])
    assert (found.low, found.value, found.high) == (0.0, 0.5, 1.0)


def test_there_is_no_band_where_a_task_has_a_single_run():
    found = performance_profile([(0.3,), (0.7, 0.9)])
    assert found.low is None
    assert found.high is None


@pytest.mark.parametrize("scores", [[], [()], [(0.5,), ()]])
def test_there_are_no_figures_without_runs(scores):
    with pytest.raises(ValueError, match="every task needs a run"):
        interquartile_mean(scores)
