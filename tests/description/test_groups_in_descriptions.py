"""Groups in descriptions: how many of their members an expression is about."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from fake_world import A, B, C, describe

from taskbuilder.description import (
    Above,
    All,
    Any,
    AtLeast,
    BodyName,
    Bonus,
    Count,
    Distance,
    ForceAbove,
    Height,
    Held,
    Inside,
    Ladder,
    Mean,
    Minimum,
    Moved,
    Near,
    Paid,
    Simultaneous,
    Stationary,
    Sustained,
    WorldView,
    condition,
)
from taskbuilder.description.check import check_description
from taskbuilder.description.description import Referee, with_members
from taskbuilder.errors import Location
from taskbuilder.schema.names import ObjectNames, SceneNames

CUBES = ("cubes_1", "cubes_2", "cubes_3")
HANDLED = ObjectNames(parts=("knob",))
NAMES = SceneNames(
    robots=("left", "right"),
    objects={**dict.fromkeys(CUBES, HANDLED), "red_1": HANDLED, "red_2": HANDLED, "bin": HANDLED},
    sites={"goal": True},
    groups={"cubes": CUBES, "red": ("red_1", "red_2")},
)


def expanded(condition):
    return with_members(describe(condition), NAMES).success


def found(*parts, **more):
    findings = check_description(describe(*parts, **more), NAMES, Location(Path("made.py")))
    return [(finding.code, finding.message) for finding in findings]


def test_a_condition_about_all_is_about_each_member():
    wanted = All(*(Inside(name, "bin") for name in CUBES))
    assert expanded(All(Inside("cubes", "bin"))) == wanted


def test_any_and_at_least_go_through_the_members_too():
    assert expanded(Any(Held("cubes", by="left"))) == Any(*(Held(n, by="left") for n in CUBES))
    several = AtLeast(2, *(Inside(n, "bin") for n in CUBES), Held("bin"))
    assert expanded(AtLeast(2, Inside("cubes", "bin"), Held("bin"))) == several


def test_one_member_at_a_time_takes_the_place_of_the_group_in_a_whole_part():
    part = Sustained(Inside("cubes", "bin") & ~Held("cubes.knob"), seconds=1.0)
    assert expanded(AtLeast(2, part)) == AtLeast(
        2, *(Sustained(Inside(n, "bin") & ~Held(f"{n}.knob"), seconds=1.0) for n in CUBES)
    )


def test_two_groups_in_a_part_give_every_pair():
    pairs = [(cube, red) for cube in CUBES for red in ("red_1", "red_2")]
    wanted = Any(*(ForceAbove(*pair, newtons=5.0) for pair in pairs))
    assert expanded(Any(ForceAbove("cubes", "red", newtons=5.0))) == wanted


def test_the_inner_one_decides_where_one_is_in_another():
    inner = Any(Near("cubes", "goal", within=0.1))
    assert expanded(AtLeast(1, inner, A)) == AtLeast(
        1, Any(*(Near(n, "goal", within=0.1) for n in CUBES)), A
    )


def test_functions_of_ones_own_are_about_members_too():
    @condition
    def higher(world: WorldView, body: BodyName, word: str) -> bool:
        return word == "cubes"

    assert expanded(All(higher("cubes", "cubes"))) == All(*(higher(n, "cubes") for n in CUBES))


def test_rewards_ladders_and_stages_are_written_out():
    inside = Inside("cubes", "bin")
    mean = Mean(Height("cubes"))
    task = describe(
        All(inside),
        Paid("lift", mean),
        progress=Ladder(0.0, (Any(inside), Count(inside))),
        stages={"one in": Any(inside)},
    )
    full = with_members(task, NAMES)
    each = [Inside(n, "bin") for n in CUBES]
    assert full.reward == (Paid("lift", Mean(*(Height(n) for n in CUBES))),)
    assert full.progress == Ladder(0.0, (Any(*each), Count(*each)))
    assert full.stages == {"one in": Any(*each)}
    assert full.conditions().keys() == task.conditions().keys()
    assert full.success.origin == task.success.origin


def test_a_scene_without_groups_leaves_its_description_as_it_is():
    task = describe(A & B)
    assert with_members(task, SceneNames((), {}, {})) is task


def test_what_is_about_a_group_says_of_how_many_members():
    ((code, message),) = found(Inside("cubes", "bin"))
    assert code == "TB215"
    assert "All(Inside(" in message
    assert "AtLeast(3, Inside(" in message
    ((code, message),) = found(A, Distance("carry", "cubes", "bin"))
    assert (code, "Mean(Closeness(" in message) == ("TB215", True)
    ((code, message),) = found(A, Paid("lift", Height("cubes")))
    assert (code, "write Mean(Height(" in message) == ("TB215", True)


def test_a_part_about_each_member_may_have_a_name_but_has_no_value():
    inside = Inside("cubes", "bin")
    task = describe(All(inside), inside=inside)
    assert found(All(inside), inside=inside) == []
    assert task.conditions().keys() - with_members(task, NAMES).conditions().keys() == {"inside"}


def test_what_says_of_how_many_is_right():
    inside = Inside("cubes", "bin")
    assert found(AtLeast(3, inside) & All(Stationary("cubes")), Bonus("x", Any(inside), 1.0)) == []
    assert found(A, Paid("lift", Minimum(Height("cubes.knob")))) == []


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (AtLeast(4, Inside("cubes", "bin")), "count is 4; from 1 to the 3 conditions given"),
        (All(), "lists no condition; give at least one"),
        (Any(), "lists no condition; give at least one"),
        (Simultaneous(A, within=0.3), "compares the moments of several conditions"),
        (Simultaneous(A, B, within=-1.0), "within is -1.0; seconds, 0 or more"),
        (All(Above("cubes_4", height=1)), '"cubes" has no member "cubes_4"; it has cubes_1 to cub'),
        (All(Above("cubes.lid", height=1)), '"cubes" has no frame "lid"; it has: knob'),
        (All(Held("red", by="cubes")), '"cubes" is no robot'),
    ],
)
def test_what_is_wrong_is_said(part, message):
    assert any(message in said for _, said in found(part)), found(part)


@pytest.mark.parametrize(("facts", "values"), [("", (False, False)), ("a", (False, True))])
def test_all_and_any_are_what_their_names_say(world, now, facts, values):
    world.facts = set(facts)
    assert (now(All(A, B)), now(Any(A, B))) == values


def test_mean_and_count_of_what_is(world, now):
    world.facts = {"a", "c"}
    assert now(Count(A, B, C)) == 2.0
    assert now(Mean(Count(A), Count(B), 5.0)) == pytest.approx(2.0)


class TestSimultaneous:
    def test_two_that_become_true_within_the_time(self, history):
        both = Simultaneous(A, B, within=0.2)
        assert history(both, "", "a", "", "b", "") == [False, False, False, True, True]

    def test_too_late_is_too_late_until_both_do_it_again(self, history):
        both = Simultaneous(A, B, within=0.1)
        values = history(both, "", "a", "a", "ab", "", "ab")
        assert values == [False] * 5 + [True]

    def test_what_holds_from_the_start_has_not_become_true(self, history):
        both = Simultaneous(A, B, within=1.0)
        assert history(both, "a", "ab", "b", "ab") == [False, False, False, True]

    def test_at_one_step_is_within_no_time(self, history):
        assert history(Simultaneous(A, B, within=0.0), "", "ab") == [False, True]

    def test_its_figure_says_how_far_apart_they_were(self, world):
        node = Simultaneous(A, B, within=0.1)
        judge = Referee(describe(node), ("left",))
        judge.start(world)
        assert node.figure(world, node.start(world), wanted=True) == ("2 of 2 have not become true")
        memory = (False, (True, True), (0.1, 0.9))
        assert node.figure(world, memory, wanted=True) == "0.8 s apart, within 0.1 s is needed"
        assert node.figure(world, memory, wanted=False) == "it has come about"
        assert math.isclose(0.8, 0.9 - 0.1)

    def test_the_members_of_a_group(self):
        node = expanded(Simultaneous(Moved("cubes", by=0.1), within=0.3))
        assert node == Simultaneous(*(Moved(n, by=0.1) for n in CUBES), within=0.3)
