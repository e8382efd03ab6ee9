"""Wilson's interval, against values from tables."""

from __future__ import annotations

import pytest

from taskbuilder.validate.proportion import Proportion


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    [
        (40, 40, 0.9124, 1.0),
        (0, 40, 0.0, 0.0876),
        (5, 10, 0.2366, 0.7634),
        (81, 263, 0.2553, 0.3662),  # Newcombe, Statistics in Medicine 17, 1998, table I
        (15, 148, 0.0624, 0.1605),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_the_interval_is_that_of_the_tables(count, of, low, high):
    assert Proportion(count, of).interval == pytest.approx((low, high), abs=5e-5)


def test_the_interval_holds_the_share_and_narrows_with_more_episodes():
    widths = []
    for of in (5, 10, 40, 160):
        share = Proportion(4 * of // 5, of)
        low, high = share.interval
        assert 0.0 <= low <= share.value <= high <= 1.0
        widths.append(high - low)
    assert widths == sorted(widths, reverse=True)


def test_a_share_reads_as_counts_and_percents():
    assert str(Proportion(40, 40)) == "40/40 (91–100 %)"
