"""Means and standard deviations of rows that come in batches are those of all rows together."""

from __future__ import annotations

import numpy as np
import pytest

from taskbuilder.learn.running_moments import LEAST_SCALE, RunningMoments


def test_batches_of_any_size_have_the_moments_of_all_rows_together():
    rng = np.random.default_rng(3)
    batches = [rng.normal(mean, 2.0, (size, 2)) for mean, size in ((0.0, 5), (40.0, 1), (7.0, 30))]
    moments = RunningMoments(2)
    for batch in batches:
        moments.add(batch)
    rows = np.concatenate(batches)
    assert moments.mean == pytest.approx(rows.mean(0))
    assert moments.scale == pytest.approx(rows.std(0))


def test_what_hardly_varies_is_not_amplified_and_nothing_has_scale_one():
    moments = RunningMoments(1)
    assert (moments.mean, moments.scale) == (0.0, 1.0)
    moments.add(np.full((4, 1), 3.0))
    assert (moments.mean, moments.scale) == (3.0, LEAST_SCALE)
    again = RunningMoments(1)
    again.load(moments.arrays())
    again.add(np.full((4, 1), 5.0))
    assert (again.mean, again.scale) == (4.0, 1.0)
