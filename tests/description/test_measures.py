"""Measures: numbers read off the world, and sums and products of them."""

from __future__ import annotations

import math

import pytest
from fake_world import A, B, FakeWorld, Number, describe
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder import description
from taskbuilder.description import (
    Closeness,
    ContactForce,
    Fraction,
    Gap,
    GripperOpening,
    Height,
    JointTravel,
    Ladder,
    Minimum,
    Speed,
    Tilt,
)
from taskbuilder.description.description import Referee
from taskbuilder.description.measures import Constant
from taskbuilder.geometry import Pose

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
    assert now(1 - X) == 1 - x
    assert now(1.0 - 0.5 * X) == 1.0 - 0.5 * x


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


@pytest.mark.parametrize(
    ("axis", "rpy_deg", "tilt"),
    [
        ("z", (0, 0, 50), 0.0),
        ("z", (20, 0, 50), 20.0),
        ("z", (180, 0, 0), 180.0),
        ("x", (0, 0, 0), 90.0),
        ("x", (0, -90, 0), 0.0),
        ("y", (-60, 0, 0), 150.0),
    ],
)
def test_a_tilt_is_the_angle_to_the_vertical_in_degrees(world, now, axis, rpy_deg, tilt):
    world.poses["cube"] = Pose.from_rpy_deg((0.1, 0.2, 0.3), rpy_deg)
    assert now(Tilt("cube", axis=axis)) == pytest.approx(tilt, abs=1e-5)


def test_a_speed_is_in_metres_a_second_in_any_direction(world, now):
    assert now(Speed("cube")) == 0.0
    world.velocities["cube"] = ((0.3, 0.0, -0.4), (9.0, 0.0, 0.0))
    assert now(Speed("cube")) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("start", "positions", "travel"),
    [
        (0.0, [0.05, 0.2, 0.3, -0.1], [0.25, 1.0, 1.0, 0.0]),
        (0.1, [0.1, 0.15, 0.2], [0.0, 0.5, 1.0]),
        (0.3, [0.3, 0.25, 0.1], [0.0, 0.5, 1.0]),
        (0.2, [0.2, 0.1], [1.0, 1.0]),
    ],
)
def test_a_joints_travel_goes_from_its_start_to_its_target(start, positions, travel):
    world = FakeWorld(joints={"drawer": start, "lid": math.radians(100 * start)})
    slides, turns = JointTravel("drawer", to=0.2), JointTravel("lid", to_deg=20)
    for measure in (slides, turns) if start != 0.2 else (slides,):  # degrees are rounded
        world.joints = {"drawer": start, "lid": math.radians(100 * start)}
        referee = Referee(describe(progress=measure), ("left",))
        referee.start(world)
        for position, share in zip(positions, travel, strict=True):
            world.joints = {"drawer": position, "lid": math.radians(100 * position)}
            assert referee.judge(world).progress == pytest.approx(share)


def test_a_force_is_what_the_world_says(world, now):
    world.forces = {("left", "right"): 80.0}
    assert now(ContactForce("left", "right")) == 80.0
    assert now(ContactForce("left", "cube")) == 0.0


def test_closeness_is_one_at_the_place_and_falls_off_with_distance(world, now):
    assert now(Closeness("cube", "goal")) == 1.0
    world.put("cube", 0.2, 0.0, 0.0)
    assert now(Closeness("cube", "goal")) == pytest.approx(1 - math.tanh(1.0))
    assert now(Closeness("cube", "goal", scale=0.4)) == pytest.approx(1 - math.tanh(0.5))
    world.put("cube", 90.0, 0.0, 0.0)
    assert now(Closeness("cube", "goal")) == pytest.approx(0.0)


def test_an_opening_is_that_of_the_robots_gripper(world, now):
    world.openings = {"left": 0.25, "right": 1.0}
    assert now(GripperOpening("left")) == 0.25
    assert now(GripperOpening("right")) == 1.0


@pytest.mark.parametrize(("facts", "value"), [("", 0.25), ("a", 1.5), ("ab", 3.0), ("b", 3.0)])
def test_a_ladder_stands_on_the_last_rung_that_holds(world, now, facts, value):
    world.facts = set(facts)
    world.numbers = {"x": 0.25, "y": 0.5}
    assert now(Ladder(X, (A, 1 + Y), (B, 3))) == value


def test_a_ladder_without_rungs_is_its_ground(now):
    assert now(Ladder(0.5)) == 0.5


@pytest.mark.parametrize(
    ("height", "share"), [(0.0, 0.0), (0.02, 0.25), (0.08, 1.0), (0.5, 1.0), (-0.1, 0.0)]
)
def test_a_share_is_how_much_there_is_of_a_whole_and_no_more(world, now, height, share):
    world.put("cube", 0.0, 0.0, height)
    assert now(Fraction(Height("cube"), of=0.08)) == pytest.approx(share)
    assert now(2 * Fraction(Height("cube") - 0.01, of=0.08)) <= 2.0


@given(numbers=st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=2), bound=st.floats(-1e3, 1e3))
def test_the_least_of_measures_and_numbers_is_the_least(numbers, bound):
    world = FakeWorld(numbers=dict(zip("xy", numbers, strict=True)))

    def now(measure):
        return Referee(describe(progress=measure), ("left",)).start(world).progress

    assert now(Minimum(X, Y)) == now(Minimum(Y, X)) == min(numbers)
    assert now(Minimum(X, bound)) == min(numbers[0], bound)
    assert now(Minimum(X)) == numbers[0]


def test_parts_of_a_share_and_of_the_least_are_measured_once_and_follow_the_world(world):
    world.numbers = {"x": 4.0, "y": 1.0}
    referee = Referee(describe(progress=Fraction(Minimum(X, Y), of=2) + Minimum(X, Y)), ("left",))
    assert referee.start(world).progress == 1.5
    assert world.asked == {"x": 1, "y": 1}
    world.numbers = {"x": 0.5, "y": 1.0}
    assert referee.judge(world).progress == 0.75


def test_a_condition_is_no_measure():
    with pytest.raises(TypeError):
        X + A
    with pytest.raises(TypeError):
        1 - A
    with pytest.raises(TypeError):
        Minimum(X, A)
    with pytest.raises(TypeError):
        Ladder(X, (A, B))


def test_equal_measures_are_one_value():
    assert len({X + Y, Number("x") + Number("y"), Y + X}) == 2
    assert len({Minimum(X, Y), Minimum(Number("x"), Y), Minimum(Y, X)}) == 2
    assert len({Fraction(X, of=1.0), Fraction(Number("x"), of=1.0), Fraction(X, of=2.0)}) == 2
    assert len({Gap("a", "b"), Gap("a", "b"), Gap("b", "a")}) == 2


# --- names of before


@pytest.mark.parametrize(("old", "new"), [("Least", "Minimum"), ("Share", "Fraction")])
def test_names_that_descriptions_were_written_with_work_and_warn(old, new):
    with pytest.warns(FutureWarning, match=f"{old} is called {new} now"):
        found = getattr(description, old)
    assert found is getattr(description, new)
