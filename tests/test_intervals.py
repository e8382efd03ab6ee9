"""Intervals are those of the textbooks."""

from __future__ import annotations

import math

import pytest

from taskbuilder.intervals import PairedDifference


@pytest.mark.parametrize(("pairs", "quantile"), [(2, 12.706), (3, 4.303), (11, 2.228), (31, 2.042)])
def test_the_half_width_is_students_for_one_pair_fewer(pairs, quantile):
    ours = [float(n % 2) for n in range(pairs)]
    mean = sum(ours) / pairs
    spread = math.sqrt(sum((one - mean) ** 2 for one in ours) / (pairs - 1))
    difference = PairedDifference.of(ours, [0.0] * pairs)
    assert difference.mean == pytest.approx(mean)
    assert difference.half_width == pytest.approx(quantile * spread / math.sqrt(pairs))


def test_many_pairs_have_the_last_quantile_and_a_single_one_no_interval():
    many = PairedDifference.of([1.0, 0.0] * 40, [0.0] * 80)
    assert many.half_width == pytest.approx(2.042 * math.sqrt(20.0 / 79.0) / math.sqrt(80))
    assert math.isinf(PairedDifference.of([1.0], [0.0]).half_width)
