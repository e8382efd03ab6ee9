"""Intervals, interquartile means and bootstrap bands, beside values worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from taskbuilder.evaluation.statistics import bootstrap_band, iqm, normalised
from taskbuilder.intervals import wilson

scores = arrays(
    np.float64, st.integers(1, 30), elements=st.floats(-1e3, 1e3, allow_subnormal=False)
)


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        # z² = 3.84146. None of 10: 3.84146 / 13.84146. All of 10: its mirror image.
        (0, 10, 0.0, 0.277533),
        (10, 10, 0.722467, 1.0),
        # Half of 10: ½ ± 1.95996 √(0.025 + 0.0096036) / 1.384146 = ½ ± 0.263405.
        (5, 10, 0.236593, 0.763407),
        # Newcombe 1998, table I: 81 of 263 has 0.2553 to 0.3662; 1 of 29 has 0.0061 to 0.1718.
        (81, 263, 0.2553, 0.3662),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_the_wilson_interval_is_as_worked_out_by_hand(successes, trials, low, high):
    assert wilson(successes, trials) == pytest.approx((low, high), abs=6e-5)


def test_the_wilson_interval_at_another_level():
    # z = 1 at 68.27 %: 1 of 4 has (¼ + ⅛ ± √(3/64 + 1/64)) / 1.25 = 0.1 and 0.5.
    assert wilson(1, 4, level=0.682689492) == pytest.approx((0.1, 0.5))


@given(st.integers(1, 2000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_wilson_interval_holds_the_share_and_mirrors_failures(case):
    successes, trials = case
    low, high = wilson(successes, trials)
    assert 0.0 <= low <= successes / trials <= high <= 1.0
    assert wilson(trials - successes, trials) == pytest.approx((1.0 - high, 1.0 - low))
    assert low > 0.0 or successes == 0
    wider = wilson(successes, trials, level=0.99)
    assert wider[1] - wider[0] > high - low


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (-1, 5), (6, 5)])
def test_a_share_that_is_none_is_refused(successes, trials):
    with pytest.raises(ValueError, match=f"{successes} successes in {trials} trials"):
        wilson(successes, trials)


@pytest.mark.parametrize(
    ("values", "mean"),
    [
        ([3.0], 3.0),
        ([1.0, 2.0, 9.0], 4.0),  # of three, no quarter can be left out
        ([100.0, 1.0, 3.0, -100.0], 2.0),
        ([5.0, 4.0, 3.0, 2.0, -70.0], 3.0),  # of five, one at either end
        ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 99.0], 3.5),
    ],
)
def test_the_interquartile_mean_leaves_a_quarter_out_at_either_end(values, mean):
    assert iqm(values) == mean


def test_the_interquartile_mean_is_taken_along_its_axis():
    runs = np.array([[0.0, 10.0], [1.0, 20.0], [2.0, 30.0], [30.0, 90.0]])
    assert iqm(runs).tolist() == [1.5, 25.0]
    assert iqm(runs.T, axis=1).tolist() == [1.5, 25.0]
    with pytest.raises(ValueError, match="no scores"):
        iqm([])


@given(scores, st.randoms(use_true_random=False))
def test_the_interquartile_mean_knows_no_order_and_lies_between_the_quartiles(values, random):
    shuffled = values.tolist()
    random.shuffle(shuffled)
    mean = iqm(values)
    assert iqm(shuffled) == mean
    ordered, cut = np.sort(values), len(values) // 4
    assert ordered[cut] - 1e-9 <= mean <= ordered[len(values) - 1 - cut] + 1e-9


@given(scores, st.floats(0.1, 10.0), st.floats(-100.0, 100.0))
def test_the_interquartile_mean_moves_with_its_scores(values, scale, shift):
    assert iqm(scale * values + shift) == pytest.approx(scale * iqm(values) + shift, abs=1e-6)


def test_a_band_of_equal_runs_has_no_width():
    low, high = bootstrap_band([np.full((5, 3), 2.5)], np.random.default_rng(0))
    assert low.tolist() == high.tolist() == [2.5, 2.5, 2.5]


def test_a_band_of_two_runs_reaches_from_one_to_the_other():
    # Both draws are the same run in half of the cases: 2.5 % lie at either.
    low, high = bootstrap_band([np.array([[0.0, 5.0], [1.0, 3.0]])], np.random.default_rng(0))
    assert (low.tolist(), high.tolist()) == ([0.0, 3.0], [1.0, 5.0])


def test_the_band_of_a_mean_is_as_wide_as_theory_has_it():
    # The bootstrap's standard error of a mean is the runs' standard deviation over √n.
    runs = np.random.default_rng(1).standard_normal((400, 1))
    low, high = bootstrap_band([runs], np.random.default_rng(2), statistic=np.mean)
    error = runs.std() / 20.0
    assert low[0] == pytest.approx(runs.mean() - 1.96 * error, abs=0.1 * error)
    assert high[0] == pytest.approx(runs.mean() + 1.96 * error, abs=0.1 * error)


def test_runs_are_drawn_within_their_stratum():
    # Two tasks without spread, far apart: the mean over both is certain, as no draw mixes them.
    strata = [np.zeros((3, 1)), np.full((3, 1), 100.0)]
    low, high = bootstrap_band(strata, np.random.default_rng(0), statistic=np.mean)
    assert (low[0], high[0]) == (50.0, 50.0)
    low, high = bootstrap_band(
        [np.concatenate(strata)], np.random.default_rng(0), statistic=np.mean
    )
    assert high[0] - low[0] > 30.0


def test_a_run_is_drawn_whole():
    # Points of each run add up to 1; so does a mean of whole runs at every draw.
    runs = np.array([[0.0, 1.0], [0.3, 0.7], [1.0, 0.0]])
    drawn = []

    def statistic(values, axis):
        drawn.append(values.sum(-1))
        return values.mean(axis)

    bootstrap_band([runs], np.random.default_rng(0), statistic=statistic)
    assert np.allclose(drawn[0], 1.0)
    assert drawn[0].shape == (2000, 3)


@given(scores)
def test_a_band_holds_the_scores_own_range(values):
    low, high = bootstrap_band([values], np.random.default_rng(0), resamples=50)
    assert values.min() - 1e-9 <= low <= high <= values.max() + 1e-9


def test_the_generator_decides_the_band():
    runs = np.random.default_rng(0).standard_normal((5, 4))
    bands = [bootstrap_band([runs], np.random.default_rng(seed), resamples=99) for seed in (1, 1)]
    assert np.array_equal(bands[0], bands[1])
    other = bootstrap_band([runs], np.random.default_rng(2), resamples=99)
    assert not np.array_equal(bands[0], other)


@pytest.mark.parametrize("strata", [[], [np.zeros((0, 3))], [np.zeros((2, 3)), np.zeros((0, 3))]])
def test_a_band_needs_runs(strata):
    with pytest.raises(ValueError, match="every stratum needs runs"):
        bootstrap_band(strata, np.random.default_rng(0))


def test_scores_are_normalised_between_random_and_expert():
    scores = normalised([-90.0, -50.0, -10.0, 10.0], random=-90.0, expert=-10.0)
    assert scores.tolist() == [0.0, 0.5, 1.0, 1.25]
    with pytest.raises(ValueError, match="both score 2"):
        normalised([1.0], random=2.0, expert=2.0)
