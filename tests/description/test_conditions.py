"""Conditions on one moment: where things are, what touches what, and what that adds up to."""

from __future__ import annotations

import math

import pytest
from fake_world import A, B, C, Fact

from taskbuilder.description import (
    Above,
    AtLeast,
    Below,
    Beyond,
    Contact,
    EmptyHanded,
    ForceAbove,
    Held,
    Inside,
    JointAngle,
    JointPosition,
    Level,
    Moved,
    Near,
    Never,
    On,
    Released,
    Stationary,
    Turned,
    Upright,
)
from taskbuilder.geometry import Ball, Box, Pose


@pytest.mark.parametrize("facts", ["", "a", "b", "ab"])
def test_conditions_combine_as_logic_does(world, now, facts):
    world.facts = set(facts)
    a, b = "a" in facts, "b" in facts
    assert now(A & B) is (a and b)
    assert now(A | B) is (a or b)
    assert now(~A) is (not a)
    assert now(~(A & ~B)) is (not a or b)
    assert now(AtLeast(1, A, B)) is (a or b)
    assert now(AtLeast(2, A, B)) is (a and b)


def test_never_is_false_and_its_opposite_true(now):
    assert now(Never()) is False
    assert now(~Never()) is True


@pytest.mark.parametrize(
    ("count", "facts", "value"), [(2, "ab", True), (2, "c", False), (3, "abc", True)]
)
def test_at_least_counts_what_holds(world, now, count, facts, value):
    world.facts = set(facts)
    assert now(AtLeast(count, A, B, C)) is value


@pytest.mark.parametrize("use", [bool, lambda a: a and B, lambda a: a or B, lambda a: not a])
def test_a_condition_has_no_truth_of_its_own(use):
    with pytest.raises(TypeError, match=r"combine conditions by &, \| and ~"):
        use(A)


@pytest.mark.parametrize("other", [True, None, "cube", 1.0, Fact])
def test_a_condition_combines_with_conditions_only(other):
    with pytest.raises(TypeError, match="combine conditions with conditions"):
        A & other
    with pytest.raises(TypeError, match="combine conditions with conditions"):
        A | other


def test_equal_conditions_are_one_value():
    assert Near("cube", "goal", within=0.1) == Near("cube", "goal", within=0.1)
    assert Near("cube", "goal", within=0.1) != Near("cube", "goal", within=0.2)
    assert len({A & B, Fact("a") & Fact("b"), B & A}) == 2
    assert A & B & C == (A & B) & C == A & (B & C)
    assert repr(~(A & B) | C) == "(~(Fact(name='a') & Fact(name='b')) | Fact(name='c'))"


@pytest.mark.parametrize(
    ("position", "axes", "value"),
    [
        ((0.06, 0.0, 0.08), "xyz", True),
        ((0.06, 0.0, 0.09), "xyz", False),
        ((0.06, 0.0, 5.0), "xy", True),
        ((0.06, 0.09, 0.0), "xy", False),
        ((9.0, 9.0, -0.1), "z", True),
        ((0.0, 0.0, -0.11), "z", False),
        ((0.05, 9.0, 9.0), "x", True),
        ((0.11, 0.0, 0.0), "x", False),
        ((9.0, 0.05, 9.0), "y", True),
        ((0.0, 0.11, 0.0), "y", False),
        ((0.08, 9.0, 0.08), "xz", False),
        ((0.05, 9.0, 0.05), "xz", True),
        ((9.0, 0.08, 0.08), "yz", False),
    ],
)
def test_near_is_a_distance_along_the_axes_asked_for(world, now, position, axes, value):
    world.put("cube", *position)
    assert now(Near("cube", "goal", within=0.1, axes=axes)) is value
    assert now(Near("goal", "cube", within=0.1, axes=axes)) is value


@pytest.fixture
def tray(world):
    """A tray of 0.4 x 0.2 x 0.05 m, turned by 90° and away from the origin, and a cube of 4 cm."""
    world.boxes = {
        "tray": Box((0.0, 0.0, 0.025), (0.2, 0.1, 0.025)),
        "cube": Box((0.0, 0.0, 0.0), (0.02, 0.02, 0.02)),
    }
    world.poses["tray"] = Pose.from_rpy_deg((1.0, 2.0, 3.0), (0.0, 0.0, 90.0))
    return lambda *in_tray: world.poses.update(cube=world.poses["tray"] @ Pose(in_tray))


@pytest.mark.parametrize(
    ("in_tray", "value"),
    [
        ((0.0, 0.0, 0.03), True),
        ((0.17, 0.07, 0.03), True),
        ((0.19, 0.0, 0.03), False),
        ((0.0, 0.09, 0.03), False),
        ((0.0, 0.0, 0.069), True),
        ((0.0, 0.0, 0.071), False),
        ((0.0, 0.0, 0.019), False),
    ],
)
def test_inside_an_object_is_within_its_walls_and_below_its_rim(tray, now, in_tray, value):
    tray(*in_tray)
    assert now(Inside("cube", "tray")) is value


def test_a_ball_that_has_rolled_takes_no_more_room_than_before(world, tray, now):
    world.boxes["cube"] = Ball((0.0, 0.0, 0.0), (0.02, 0.02, 0.02))
    for in_tray, inside in (((0.17, 0.07, 0.021), True), ((0.181, 0.0, 0.021), False)):
        tray(*in_tray)
        world.poses["cube"] = world.poses["cube"] @ Pose.from_rpy_deg((0.0, 0.0, 0.0), (45, 30, 0))
        assert now(Inside("cube", "tray")) is inside


def test_a_margin_keeps_what_is_inside_off_the_walls(tray, now):
    tray(0.17, 0.0, 0.03)
    assert now(Inside("cube", "tray", margin=0.009)) is True
    assert now(Inside("cube", "tray", margin=0.011)) is False


@pytest.mark.parametrize(("height", "value"), [(0.49, True), (0.51, False), (-0.49, True)])
def test_inside_a_site_is_the_centre_within_its_marker(world, now, height, value):
    world.sites = {"goal"}
    world.boxes = {
        "goal": Box((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)),
        "cube": Box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0)),
    }
    world.put("cube", 0.0, 0.0, height)
    assert now(Inside("cube", "goal")) is value
    assert now(Inside("cube", "goal", margin=0.1)) is False


def test_above_and_below_are_opposites_in_the_world_and_over_a_frame(world, now):
    for height, above in ((0.5, True), (0.49, False)):
        world.put("cube", 0.0, 0.0, height)
        world.put("tray", 0.0, 0.0, 0.2)
        assert now(Above("cube", height=0.5)) is above
        assert now(Below("cube", height=0.5)) is not above
        assert now(Above("cube", "tray", height=0.3)) is above
        assert now(Below("cube", "tray", height=0.3)) is not above


@pytest.mark.parametrize(
    ("tilt", "value"), [(0.0, True), (14.0, True), (16.0, False), (180.0, False)]
)
def test_upright_is_an_axis_that_points_up(world, now, tilt, value):
    world.poses["cube"] = Pose.from_rpy_deg((0.0, 0.0, 0.0), (tilt, 0.0, 77.0))
    assert now(Upright("cube", within_deg=15)) is value
    assert now(Level("cube", within_deg=15)) is value
    world.poses["cube"] = Pose.from_rpy_deg((0.0, 0.0, 0.0), (0.0, -90.0 + tilt, 0.0))
    assert now(Upright("cube", within_deg=15, axis="x")) is value


def test_what_stands_on_its_head_has_its_axis_down(world, now):
    upside_down = Upright("cube", within_deg=15, axis="-z")
    world.poses["cube"] = Pose.from_rpy_deg((0.0, 0.0, 0.0), (170.0, 0.0, 30.0))
    assert now(upside_down) is True
    world.poses["cube"] = Pose()
    assert now(upside_down) is False


@pytest.mark.parametrize(
    ("linear", "angular", "value"),
    [(0.009, 0.0, True), (0.011, 0.0, False), (0.0, 9.0, True), (0.0, 11.0, False)],
)
def test_stationary_is_slow_in_moving_and_in_turning(world, now, linear, angular, value):
    world.velocities["cube"] = ((0.0, linear, 0.0), (math.radians(angular), 0.0, 0.0))
    assert now(Stationary("cube")) is value
    assert now(Stationary("cube", speed=1.0, turn_deg=90.0)) is True


def test_moved_and_turned_compare_with_the_start_of_the_episode(world, referee):
    world.put("cube", 1.0, 0.0, 0.0)
    judge = referee(Moved("cube", by=0.1), failure=Turned("cube", by_deg=30))
    outcome = judge.start(world)
    assert (outcome.success, outcome.failure) == (False, False)
    world.poses["cube"] = Pose.from_rpy_deg((1.1, 0.0, 0.0), (0.0, 29.0, 0.0))
    outcome = judge.judge(world)
    assert (outcome.success, outcome.failure) == (True, False)
    world.poses["cube"] = Pose.from_rpy_deg((1.05, 0.0, 0.0), (0.0, 0.0, -31.0))
    outcome = judge.judge(world)
    assert (outcome.success, outcome.failure) == (False, True)
    assert judge.start(world).failure is False


@pytest.mark.parametrize(
    ("axis", "by", "value"),
    [
        ("x", 0.0, False),
        ("-x", 0.25, True),
        ("-x", 0.35, False),
        ("y", 0.35, True),
        ("y", 0.45, False),
        ("-z", 0.0, False),
        ("z", 0.45, True),
    ],
)
def test_a_frame_is_beyond_another_along_an_axis_of_that_one(world, now, axis, by, value):
    world.poses["gate"] = Pose.from_rpy_deg((1.0, 1.0, 0.0), (0, 0, 90))  # its x is the world's y
    world.put("cube", 0.6, 0.7, 0.5)
    assert now(Beyond("cube", "gate", axis=axis, by=by)) is value


@pytest.mark.parametrize(
    ("position", "above", "below", "value"),
    [
        (0.2, 0.1, None, True),
        (0.05, 0.1, None, False),
        (0.2, None, 0.1, False),
        (0.1, 0.1, 0.1, True),
        (0.2, 0.1, 0.3, True),
        (0.4, 0.1, 0.3, False),
    ],
)
def test_a_joint_is_between_its_bounds(world, now, position, above, below, value):
    world.joints = {"cabinet.slide": position, "cabinet.hinge": math.radians(100 * position)}
    bounds = [None if bound is None else 100 * bound for bound in (above, below)]
    if above != below:  # degrees are rounded
        angle = JointAngle("cabinet.hinge", above_deg=bounds[0], below_deg=bounds[1])
        assert now(angle) is value
    assert now(JointPosition("cabinet.slide", above=above, below=below)) is value


@pytest.mark.parametrize(
    ("holders", "by", "value"),
    [
        ("", None, False),
        ("right", None, True),
        ("right", "left", False),
        ("left", "left", True),
        ("left", ("left", "right"), False),
        ("left right", ("left", "right"), True),
    ],
)
def test_held_is_by_any_by_one_or_by_all_at_once(world, now, holders, by, value):
    world.holds = {("cube", robot) for robot in holders.split()}
    assert now(Held("cube", by=by)) is value


def test_released_is_touched_by_no_finger(world, now):
    assert now(Released("cube")) is True
    world.finger_touches = {("cube", "left")}
    assert now(Released("cube")) is False
    assert now(Released("cube", by="left")) is False
    assert now(Released("cube", by="right")) is True


def test_an_empty_handed_robot_holds_none_of_the_objects(world, now):
    world.holds = {("tray", "left")}
    assert now(EmptyHanded("left")) is False
    assert now(EmptyHanded("right")) is True


def test_contact_is_of_two_bodies_or_of_a_robot_with_one(world, now):
    world.touches = {("cube", "tray"), ("tray", "left")}
    assert now(Contact("cube", "tray")) is True
    assert now(Contact("tray", robot="left")) is True
    assert now(Contact("cube", robot="left")) is False


@pytest.mark.parametrize(
    ("force", "value"), [(0.0, False), (1e-4, False), (0.5, True), (-0.5, False)]
)
def test_on_is_being_carried_by_more_than_noise(world, now, force, value):
    world.supports = {("cube", "tray"): force}
    assert now(On("cube", "tray")) is value
    assert now(On("tray", "cube")) is False


@pytest.mark.parametrize(("force", "value"), [(0.0, False), (100.0, False), (100.1, True)])
def test_a_force_is_above_a_bound(world, now, force, value):
    world.forces = {("left", "right"): force}
    assert now(ForceAbove("left", "right", newtons=100)) is value
    assert now(ForceAbove("left", "tray", newtons=100)) is False
