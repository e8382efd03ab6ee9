"""Measures: numbers read off the world, and sums and products of them."""

from __future__ import annotations

import math

import pytest
from fake_world import A, B, FakeWorld, Number, describe
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.description import Closeness, Gap, Height, Ladder
from taskbuilder.description.description import Referee
from taskbuilder.description.measures import Constant

X, Y = Number("x"), Number("y")


@given(x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3))
def test_measures_calculate_as_numbers_do(x, y):
    world = FakeWorld(numbers={"x": x, "y": y})

    def now(measure):
        return Referee(describe(progress=measure), ("left",)).start(world).progress

    assert now(X + Y) == x + y
    assert now(X - Y) == x - y
    assert now(X * Y) == x * y
    assert now(2 + X) == now(X + 2) == x + 2
    assert now(2 * X) == now(X * 2) == x * 2
    assert now(0.5 * (3 + X)) == 0.5 * (3 + x)
    assert now(X - 1) == x - 1


def test_measures_are_always_floats(world, now):
    world.numbers = {"x": 1}
    assert type(now(X)) is float
    assert type(now(Constant(2))) is float


def test_distances_and_heights_are_in_metres(world, now):
    world.put("cube", 0.3, 0.0, 0.4)
    world.put("tray", 0.0, 0.0, 0.1)
    assert now(Gap("cube", "goal")) == pytest.approx(0.5)
    assert now(Height("cube")) == pytest.approx(0.4)
    assert now(Height("cube", "tray")) == pytest.approx(0.3)


def test_closeness_is_one_at_the_place_and_falls_off_with_distance(world, now):
    assert now(Closeness("cube", "goal")) == 1.0
    world.put("cube", 0.2, 0.0, 0.0)
    assert now(Closeness("cube", "goal")) == pytest.approx(1 - math.tanh(1.0))
    assert now(Closeness("cube", "goal", scale=0.4)) == pytest.approx(1 - math.tanh(0.5))
    world.put("cube", 90.0, 0.0, 0.0)
    assert now(Closeness("cube", "goal")) == pytest.approx(0.0)


@pytest.mark.parametrize(("facts", "value"), [("", 0.25), ("a", 1.5), ("ab", 3.0), ("b", 3.0)])
def test_a_ladder_stands_on_the_last_rung_that_holds(world, now, facts, value):
    world.facts = set(facts)
    world.numbers = {"x": 0.25, "y": 0.5}
    assert now(Ladder(X, (A, 1 + Y), (B, 3))) == value


def test_a_ladder_without_rungs_is_its_ground(now):
    assert now(Ladder(0.5)) == 0.5


def test_a_condition_is_no_measure():
    with pytest.raises(TypeError):
        X + A
    with pytest.raises(TypeError):
        Ladder(X, (A, B))


def test_equal_measures_are_one_value():
    assert len({X + Y, Number("x") + Number("y"), Y + X}) == 2
    assert len({Gap("a", "b"), Gap("a", "b"), Gap("b", "a")}) == 2
