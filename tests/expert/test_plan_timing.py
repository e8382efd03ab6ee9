"""Motions go as fast as their limits allow, and start and stop gently."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.expert.planning.timing import resampled, schedule

LENGTHS = st.floats(0.0, 200.0)
COSTS = st.lists(st.floats(0.0, 3.0), min_size=1, max_size=30)


def changes(points):
    """How far it is from each to the next, from 0 on."""
    return [after - before for before, after in pairwise([0.0, *points])]


@given(LENGTHS)
def test_no_control_step_is_longer_than_allowed(length):
    assert all(0.0 < change <= 1.0 + 1e-9 for change in changes(schedule(length)))


@given(LENGTHS.filter(lambda length: length > 1e-6))
def test_a_motion_ends_where_its_path_does(length):
    assert schedule(length)[-1] == length


@given(LENGTHS)
def test_ramps_cost_two_steps_at_most(length):
    assert len(schedule(length)) < length + 3.0


@given(st.floats(3.0, 200.0))
def test_a_motion_starts_and_stops_more_slowly_than_it_goes(length):
    first, second, *_, last_but_one, last = changes(schedule(length))
    assert max(first, last) <= 0.4 + 1e-9
    assert max(second, last_but_one) <= 0.8 + 1e-9


@given(LENGTHS)
def test_a_motion_stops_as_it_starts(length):
    there = changes(schedule(length))
    assert there == pytest.approx(there[::-1])


def test_a_path_of_no_length_takes_no_time():
    assert schedule(0.0) == ()
    assert resampled([(1.0,), (1.0,)], [0.0]) == ()


def test_a_very_short_path_takes_one_step():
    assert schedule(0.3) == (0.3,)


@given(COSTS)
def test_points_keep_to_the_limits_of_the_path_that_they_lie_on(costs):
    path = [(0.0, 0.0)]
    for number, cost in enumerate(costs):  # turns a corner after every line
        x, y = path[-1]
        path.append((x + cost, y) if number % 2 else (x, y + cost))
    points = [(0.0, 0.0), *resampled(path, costs)]
    steps = [abs(bx - ax) + abs(by - ay) for (ax, ay), (bx, by) in pairwise(points)]
    assert all(step <= 1.0 + 1e-6 for step in steps)
    if sum(costs) > 1e-6:
        assert points[-1] == path[-1]
