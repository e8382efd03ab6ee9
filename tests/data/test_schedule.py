"""When collecting gives up, by the attempts so far."""

from __future__ import annotations

import pytest

from taskbuilder.data.playing import AttemptResult
from taskbuilder.data.schedule import HOPELESS, MOST_ATTEMPTS, Series, next_attempts


class Numbered(int):
    """An attempt that is its number, with a seed."""

    @property
    def seed(self):
        return 100 - self


def series(wanted, kept, failed):
    results = [AttemptResult("", number < kept, "") for number in range(kept + failed)]
    return Series(wanted, Numbered, results)


@pytest.mark.parametrize(
    ("wanted", "kept", "failed", "hopeless"),
    [
        (3, 0, HOPELESS - 1, False),
        (3, 0, HOPELESS, True),
        (3, 1, HOPELESS + 3 * MOST_ATTEMPTS - 2, False),
        (3, 1, HOPELESS + 3 * MOST_ATTEMPTS - 1, True),
        (1, 1, 1000, False),
    ],
)
def test_attempts_per_episode_asked_for_are_bounded(wanted, kept, failed, hopeless):
    assert series(wanted, kept, failed).is_hopeless == hopeless


def test_as_many_attempts_follow_as_episodes_are_missing():
    assert series(5, 2, 4).next() == [6, 7, 8]
    assert series(50, 0, HOPELESS - 2).next() == [HOPELESS - 2, HOPELESS - 1]
    assert series(5, 0, HOPELESS).next() == []
    one, other = series(2, 0, 0), series(2, 1, 0)
    assert [attempt for _, attempt in next_attempts([one, other])] == [1, 1, 0]
