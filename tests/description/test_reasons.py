"""Why a condition is not as it is wanted: the part to blame, its figure, its bound, since when."""

from __future__ import annotations

import math

import pytest
from fake_world import A, B, C, Fact, describe

from taskbuilder import description
from taskbuilder.description import (
    Above,
    AtLeast,
    Below,
    Beyond,
    Condition,
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
    Once,
    Released,
    Stationary,
    Sustained,
    Then,
    Turned,
    condition,
)
from taskbuilder.description.description import Referee
from taskbuilder.description.reasons import label, reasons
from taskbuilder.geometry import Box, Pose


@pytest.fixture
def why(world):
    """The reasons, in words, why a condition is not as wanted after these steps of 0.1 s.

    Each step is what is done to the world before it is judged.
    """

    def told(node, *steps, wanted=True, of="success"):
        referee = Referee(describe(node), ("left",))
        history = []
        for number, step in enumerate(steps or (lambda: None,)):
            world.time = 0.1 * number
            step()
            if number:
                referee.judge(world)
            else:
                referee.start(world)
            history.append(referee.values)
        moment = referee.moment(world, history)
        return [str(reason) for reason in reasons(node, moment, wanted=wanted, of=of)]

    return told


@pytest.fixture
def facts(world, why):
    """The same after steps at each of which these facts are true."""

    def told(node, *steps, wanted=True, of="success"):
        def put(text):
            return lambda: setattr(world, "facts", set(text))

        return why(node, *map(put, steps), wanted=wanted, of=of)

    return told


def _box(x, y, z):
    return Box((0.0, 0.0, 0.0), (x / 2, y / 2, z / 2))


def test_figures_stand_beside_their_bounds(world, why):
    world.put("cube", 0.073, 0.0, 0.2)
    world.put("goal", 0.0, 0.0, 0.2)
    world.joints = {"drawer": 0.021, "lid": math.radians(30)}
    world.poses["tray"] = Pose.from_rpy_deg((0.0, 0.0, 0.5), (14.24, 0.0, 0.0))
    world.velocities["cube"] = ((0.042, 0.0, 0.0), (0.0, 0.0, math.radians(20)))
    world.forces["left", "right"] = 239.7
    start = " (from the start)"
    for node, wanted, said in (
        (Near("cube", "goal", within=0.05), True, "7.3 cm, within 5 cm is needed"),
        (Near("cube", "goal", within=0.08), False, "7.3 cm, more than 8 cm is needed"),
        (
            Near("cube", "goal", within=0.05, axes="xy"),
            True,
            "7.3 cm along x and y, within 5 cm is",
        ),
        (Near("cube", "goal", within=0.07299), True, "7.300 cm, within 7.299 cm is needed"),
        (Above("cube", height=0.6), True, "20.0 cm high, at least 60 cm is needed"),
        (Below("cube", height=0.35), False, "20.0 cm high, at least 35 cm is needed"),
        (Level("tray", within_deg=10), True, "tilted by 14.2°, within 10° is needed"),
        (Beyond("cube", "goal", by=0.5), True, "cm beyond it, at least 50 cm is needed"),
        (Moved("cube", by=0.1), True, "moved by 0.0 cm, at least 10 cm is needed"),
        (Turned("cube", by_deg=90), True, "turned by 0.0°, at least 90° is needed"),
        (
            Stationary("cube"),
            True,
            "moves at 4.2 cm/s, less than 1 cm/s is needed, turns at 20.0°/s, less than 10°/s is",
        ),
        (JointPosition("drawer", above=0.1), True, "2.1 cm, at least 10 cm is needed"),
        (JointAngle("lid", above_deg=0, below_deg=20), True, "30.0°, at most 20° is needed"),
        (JointAngle("lid", above_deg=0), False, "30.0°, less than 0° is needed"),
        (ForceAbove("left", "right", newtons=100), False, "240 N, 100 N is allowed"),
        (ForceAbove("left", "right", newtons=300), True, "240 N, more than 300 N is needed"),
        (Held("cube", by=("left", "right")), True, "left does not hold it, right does not hold it"),
        (Held("cube"), True, "no robot holds it"),
        (Contact("cube", "tray"), True, "they do not touch"),
        (On("cube", "tray"), True, "tray carries none of it"),
        (Never(), True, "can never hold"),
        (Fact("a"), True, "does not hold"),
    ):
        (told,) = why(node, wanted=wanted)
        assert said in told
        assert told.endswith(start)


def test_what_touches_and_what_holds_is_told_by_name(world, why):
    world.holds = {("cube", "left")}
    world.finger_touches = {("cube", "left"), ("cube", "right")}
    assert why(~Held("cube", by="left")) == ["Held(cube, by=left): left holds it (from the start)"]
    assert why(Released("cube"))[0].startswith("Released(cube): touched by left and right")
    assert why(EmptyHanded("left"))[0].startswith("EmptyHanded(left): it holds cube")


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ((0.1, 0.0, 0.02), "its outline is 4.0 cm too far out"),
        ((0.0, 0.0, 0.09), "its lowest point is 4.0 cm above the rim"),
        ((0.0, 0.0, -0.06), "its lowest point is 5.0 cm below the floor"),
    ],
)
def test_how_far_something_is_from_being_inside(world, why, at, said):
    world.boxes = {"cube": _box(0.04, 0.04, 0.04), "tray": _box(0.16, 0.16, 0.06)}
    world.put("cube", *at)
    told = why(Inside("cube", "tray"))
    assert said in told[0]


def test_only_the_parts_that_are_to_blame_are_told(facts):
    assert facts(A & B & ~C, "ac") == [
        f"{_name('b')}: does not hold (from the start)",
        f"{_name('c')}: holds (from the start)",
    ]
    assert facts(A & B, "ab") == []


def _name(fact):
    return label(Fact(fact))


def test_since_when_it_has_been_so(facts):
    assert facts(A, "a", "a", "", "a", "", "")[0].endswith("(since step 4)")
    assert facts(A, "", "", "")[0].endswith("(from the start)")


def test_parts_of_which_any_would_do_are_one_reason(facts):
    (told,) = facts(A | B, "")
    both = f"{_name('a')}: does not hold; or {_name('b')}: does not hold"
    assert told == f"one of: {both} (from the start)"
    assert len(facts(A | (B & C), "b")) == 1
    assert len(facts(~(A | B), "ab")) == 2
    assert len(facts(AtLeast(2, A, B, C), "")) == 1
    assert len(facts(AtLeast(3, A, B, C), "a")) == 2


def test_what_must_last_says_how_long_it_did(facts):
    kept = Sustained(A, seconds=0.5)
    (told,) = facts(kept, "", "a", "a", "a")
    assert told.startswith(f"Sustained({_name('a')}): kept for 0.2 of 0.5 s")
    first, second = facts(kept, "a", "a", "a", "", "a", "")
    assert first.endswith("(since step 5)")
    assert second.startswith(f"Sustained({_name('a')}): kept for 0.2 of 0.5 s at most")
    assert len(facts(kept, "", "")) == 1
    _, lost = facts(kept, "a", "a", "a", "a", "a", "a", "a", "a", "")
    assert lost.startswith(
        f"Sustained({_name('a')}): kept for 0.7 s, 0.5 s were needed, but not to the end"
    )


def test_what_must_come_in_order_says_what_it_waits_for(facts):
    (told,) = facts(Then(A, B), "a", "")
    assert told.startswith(_name("b"))
    assert facts(Once(A), "", "")[0].startswith(_name("a"))
    assert facts(~Once(A), "", "a", "") == [
        f"Once({_name('a')}): has held before, first at step 1 (since step 1)"
    ]
    (told,) = facts(~Once(A), "a", "")
    assert told.startswith(f"Once({_name('a')}): has held before, from the start")


def test_a_failure_names_all_that_made_it_up(facts):
    failed = facts(Once(A) & ~B, "b", "ab", "b", "", wanted=False, of="failure")
    assert failed == [
        f"failure held at step 3: all of: Once({_name('a')}): has held before, first at step 1; "
        f"and {_name('b')}: does not hold"
    ]
    assert facts(Once(A) | C, "", "a", wanted=False, of="failure") == [
        f"failure held at step 1: {_name('a')}: holds"
    ]
    (told,) = facts((A & B) | (B & C), "ab", wanted=False, of="failure")
    assert told == f"failure held at step 0: all of: {_name('a')}: holds; and {_name('b')}: holds"


def test_of_a_failure_that_has_not_come_about_one_part_would_be_enough(facts):
    (told,) = facts(A | B, "", wanted=True, of="failure")
    assert told.endswith(f"one of: {_name('a')}: does not hold; or {_name('b')}: does not hold")


def test_the_figure_of_a_failure_that_has_just_come_about_is_told(world, why):
    world.put("cube", 0.03, 0.0, 0.0)
    world.put("goal", 0.0, 0.0, 0.0)
    node = Once(Near("cube", "goal", within=0.05)) & ~Held("cube")
    assert why(node, wanted=False, of="failure") == [
        "failure held at step 0: all of: Near(cube, goal): 3.0 cm, more than 5 cm is needed; "
        "and Held(cube): no robot holds it"
    ]


def test_parts_that_the_description_names_are_told_by_their_names(world):
    class Named(description.Description):
        dropped = Below("cube", height=0.1)
        left_early = Once(dropped)
        success = Sustained(left_early & ~dropped, seconds=1.0)
        reward = ()

    world.put("cube", 0.0, 0.0, 0.0)
    referee = Referee(Named, ("left",))
    referee.start(world)
    history = [referee.values]
    world.put("cube", 0.0, 0.0, 0.5)
    world.time = 0.1
    referee.judge(world)
    history.append(referee.values)
    moment = referee.moment(world, history)
    (kept,) = reasons(Named.success, moment, wanted=True, of="success")
    assert kept.part == "Sustained((left_early & ~dropped))"
    (once,) = reasons(Named.left_early, moment, wanted=False, of="failure")
    assert once.part == "Once(dropped)"


def test_ones_own_conditions_are_told_too(world, why):
    @condition
    def higher(world, upper, lower):
        return world.position(upper)[2] > world.position(lower)[2]

    assert why(higher("cube", "tray")) == [
        "higher(upper='cube', lower='tray'): does not hold (from the start)"
    ]


def test_every_condition_has_its_figure_or_names_the_parts_to_blame():
    public = (getattr(description, name) for name in description.__all__)
    silent = {
        thing.__name__
        for thing in public
        if isinstance(thing, type) and issubclass(thing, Condition) and thing is not Condition
        if thing.figure is Condition.figure and thing.blamed is Condition.blamed
    }
    assert silent == set()
