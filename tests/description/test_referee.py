"""The referee: a description applied to a world, step by step, with nothing shared or skipped."""

from __future__ import annotations

import copy
import pickle
from collections import Counter

import pytest
from fake_world import A, B, C, Fact, FakeWorld, Number, describe

from taskbuilder.description import (
    Bonus,
    Closeness,
    Description,
    Held,
    Moved,
    Never,
    Once,
    Potential,
    Sustained,
    Then,
)
from taskbuilder.description.description import Referee


def test_every_distinct_expression_is_evaluated_once_a_step_and_never_skipped(world, referee):
    judge = referee(
        A & Fact("a") & ~B,  # false at once, and still looks at b
        Bonus("one", A | B, 1.0),
        Bonus("two", Then(A, B, C), 1.0),
        failure=B & C,
        stages={"first": A, "second": Fact("b")},
        progress=Number("x") + 2 * Number("x"),
    )
    world.numbers = {"x": 1.0}
    judge.start(world)
    assert world.asked == Counter(a=1, b=1, c=1, x=1)
    for _ in range(3):
        judge.judge(world)
    assert world.asked == Counter(a=4, b=4, c=4, x=4)


def test_an_outcome_names_every_condition_of_the_description(world):
    task = describe(A & B, failure=C, stages={"almost": A | B}, touched=A)
    world.facts = {"a"}
    outcome = Referee(task, ("left",)).start(world)
    assert outcome.conditions == {
        "success": False,
        "failure": False,
        "almost": True,
        "touched": True,
        "setback": False,
    }
    assert list(outcome.conditions)[:3] == ["success", "failure", "almost"]


def test_conditions_of_a_base_class_are_named_too(world):
    class Base(Description):
        touched = A
        left_alone = ~A

    class Task(Base):
        left_alone = ~B
        success = B
        reward = (Bonus("done", B, 1.0),)

    assert Task.conditions() == {
        "success": B,
        "failure": Never(),
        "setback": Never(),
        "touched": A,
        "left_alone": ~B,
    }


def test_a_description_never_fails_unless_it_says_when(world, referee):
    assert referee(A).start(world).failure is False


def test_progress_is_nothing_unless_the_description_has_some(world, referee):
    world.numbers = {"x": 0.3}
    assert referee(A).start(world).progress == 0.0
    assert referee(A, progress=Number("x")).start(world).progress == 0.3


def test_the_last_stage_ever_to_hold_counts(world, referee):
    judge = referee(C, stages={"one": A, "two": B, "three": C})
    reached = []
    for facts in ("", "a", "", "b", "a", "c", ""):
        world.facts = set(facts)
        reached.append((judge.judge(world) if reached else judge.start(world)).stage)
    assert reached == [0, 1, 1, 2, 2, 3, 3]
    assert judge.start(world).stage == 0


def test_a_stage_that_is_skipped_does_not_hold_up_those_after_it(world, referee):
    world.facts = {"b"}
    assert referee(C, stages={"one": A, "two": B}).start(world).stage == 2


@pytest.mark.parametrize("name", ["success", "failure", "touched"])
def test_a_stage_may_not_take_the_place_of_an_attribute_of_its_name(world, name):
    judge = Referee(describe(A & B, failure=A & C, touched=~A, stages={name: A}), ("left",))
    world.facts = {"a"}
    outcome = judge.start(world)
    assert (outcome.success, outcome.failure) == (False, False)
    assert outcome.stage == 1
    assert outcome.conditions[name] is False


def remembering() -> type[Description]:
    """A description of everything that has a memory."""
    return describe(
        Then(A, B, C),
        Bonus("once", Once(B), 1.0, agent="left"),
        Potential("gain", Number("x"), 2.0),
        failure=Sustained(A, 0.2),
        stages={"a": A, "b": Once(B) & Moved("cube", by=0.1)},
    )


def play(judge: Referee, world: FakeWorld, steps: str, first: int = 0) -> list[object]:
    outcomes = []
    for index, facts in enumerate(steps, start=first):
        world.time = index * 0.1
        world.facts = {facts}
        world.numbers = {"x": 1.0 / (1 + index)}
        world.put("cube", 0.03 * index, 0.0, 0.0)
        outcomes.append(judge.judge(world) if index else judge.start(world))
    return outcomes


@pytest.mark.parametrize(
    "way", [lambda m: m, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))]
)
def test_memory_that_is_set_back_continues_as_before(world, way):
    judge = Referee(remembering(), ("left", "right"))
    play(judge, world, "-aab")
    kept = way(judge.memory)
    expected = play(judge, world, "bcaaac", first=4)
    play(judge, world, "ccc")
    judge.memory = kept
    assert play(judge, world, "bcaaac", first=4) == expected


def test_memory_can_be_given_to_another_referee_of_the_same_description(world):
    first, second = (Referee(remembering(), ("left", "right")) for _ in range(2))
    play(first, world, "-aab")
    second.memory = first.memory
    assert play(second, world, "bca", first=4) == play(first, world, "bca", first=4)


def test_referees_of_one_description_do_not_share_memory():
    first, second = (Referee(remembering(), ("left", "right")) for _ in range(2))
    alone = play(Referee(remembering(), ("left", "right")), FakeWorld(), "-aabbc")
    worlds = FakeWorld(), FakeWorld()
    mixed = []
    for index, facts in enumerate("-aabbc"):
        mixed += play(first, worlds[0], facts, first=index)
        play(second, worlds[1], "c", first=index)
    assert mixed == alone


def test_an_episode_remembers_nothing_of_the_one_before(world):
    judge = Referee(remembering(), ("left", "right"))
    first = play(judge, world, "-aabbc")
    assert play(judge, world, "-aabbc") == first


def test_memory_and_outcomes_are_values(world):
    judge = Referee(remembering(), ("left", "right"))
    (outcome,) = play(judge, world, "a")
    kept = judge.memory
    play(judge, world, "abc")
    again = Referee(remembering(), ("left", "right"))
    play(again, FakeWorld(), "a")
    assert kept == again.memory
    with pytest.raises(AttributeError):
        outcome.success = True


def test_expressions_are_values_that_cannot_change():
    held = Held("cube", by="left")
    with pytest.raises(AttributeError):
        held.body = "tray"
    again = pickle.loads(pickle.dumps(held))
    assert again == held
    assert again.origin == held.origin == copy.deepcopy(held).origin
    assert hash(Closeness("a", "b")) == hash(Closeness("a", "b"))
