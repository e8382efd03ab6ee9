"""The replay memory: a ring that grows, and draws with replacement."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.learn.replay import Replay

CAPACITY = 7


def numbered(first, count):
    """Rows that hold their own number."""
    return np.arange(first, first + count, dtype=np.float32)[:, None].repeat(2, axis=1)


def filled(sizes, capacity=CAPACITY):
    memory, added = Replay(2, capacity), 0
    for size in sizes:
        memory.add(numbered(added, size))
        added += size
    return memory


@given(st.lists(st.integers(0, CAPACITY), max_size=12), st.integers(0, 60))
def test_the_last_rows_are_kept_in_their_order(sizes, since):
    memory, added = filled(sizes), sum(sizes)
    assert memory.added == added
    assert len(memory) == min(added, CAPACITY)
    kept = list(range(max(0, added - CAPACITY), added))
    expected = [number for number in kept if number >= since]
    assert memory.since(since)[:, 0].tolist() == expected


@given(st.lists(st.integers(1, CAPACITY), min_size=1, max_size=12), st.integers(0, 2**32 - 1))
def test_only_what_is_kept_is_drawn_and_rows_stay_whole(sizes, seed):
    memory = filled(sizes)
    drawn = memory.sample(50, np.random.default_rng(seed))
    assert set(drawn[:, 0]) <= set(memory.since(0)[:, 0])
    assert np.array_equal(drawn[:, 0], drawn[:, 1])


def test_rows_are_drawn_evenly_and_with_replacement():
    memory = filled([5, 5])
    drawn = memory.sample(70_000, np.random.default_rng(0))[:, 0]
    numbers, counts = np.unique(drawn, return_counts=True)
    assert numbers.tolist() == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
    assert counts == pytest.approx([10_000] * 7, rel=0.05)


def test_the_generator_alone_decides_what_is_drawn():
    memory = filled([7])
    first, again, other = (memory.sample(20, np.random.default_rng(n)) for n in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_what_was_drawn_or_listed_may_be_changed_without_harm():
    memory = filled([7])
    memory.sample(20, np.random.default_rng(0))[:] = -1.0
    memory.since(0)[:] = -1.0
    assert memory.since(0)[:, 0].tolist() == list(range(7))


def test_memory_is_taken_as_rows_come_and_nothing_is_lost_by_growing():
    memory = Replay(2, 10**12)
    added = 0
    for size in (4000, 4000, 20_000):
        memory.add(numbered(added, size))
        added += size
        assert memory.since(0)[:, 0].tolist() == list(range(added))
