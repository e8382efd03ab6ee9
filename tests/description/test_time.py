"""Conditions over time, step by step."""

from __future__ import annotations

import pytest
from fake_world import A, B, C, describe

from taskbuilder.description import Duration, Fraction, Once, Sustained, Then
from taskbuilder.description.description import Referee

NO, YES = False, True


@pytest.mark.parametrize(
    ("steps", "values"),
    [
        (["", "a", "", "b", "", "c", ""], [NO, NO, NO, NO, NO, YES, YES]),
        (["abc", ""], [YES, YES]),  # all at one step, the first one
        (
            ["c", "b", "a", "", "bc", ""],
            [NO, NO, NO, NO, YES, YES],
        ),  # out of order counts for nothing
        (["ab", "a", "c"], [NO, NO, YES]),  # none needs to go on holding
        (["a", "a", "bc"], [NO, NO, YES]),
        (["b", "c", ""], [NO, NO, NO]),
    ],
)
def test_then_waits_for_each_in_turn_and_stays_true(history, steps, values):
    assert history(Then(A, B, C), *steps) == values


def test_then_begins_afresh_with_each_episode(history):
    condition = Then(A, B)
    assert history(condition, "a", "b") == [NO, YES]
    assert history(condition, "b", "") == [NO, NO]


def test_one_condition_may_stand_twice_in_an_order(history):
    assert history(Then(A, ~A, A), "a", "", "", "a", "") == [NO, NO, NO, YES, YES]


@pytest.mark.parametrize(
    ("steps", "values"),
    [
        (["a", "a", "a", "a", "", "a"], [NO, NO, YES, YES, NO, NO]),
        (["", "a", "a", "", "a", "a", "a"], [NO, NO, NO, NO, NO, NO, YES]),
    ],
)
def test_sustained_holds_once_its_time_has_passed_without_a_gap(history, steps, values):
    assert history(Sustained(A, 0.2), *steps) == values


def test_times_that_are_sums_of_steps_are_not_missed_for_their_rounding(history):
    # 0.1 * 3 is a little more than 0.3, and 0.7 - 0.4 a little less.
    assert history(Sustained(A, 0.3), *"xxxxaaaa") == [NO] * 7 + [YES]
    assert history(Sustained(A, 0.3), *"aaaa") == [NO] * 3 + [YES]


@pytest.mark.parametrize(
    ("steps", "seconds"),
    [
        (["a", "a", "a", "", "a"], [0.0, 0.1, 0.2, 0.0, 0.0]),
        (["", "a", "a", "a"], [0.0, 0.0, 0.1, 0.2]),
    ],
)
def test_a_duration_is_the_time_for_which_something_has_held_without_a_gap(world, steps, seconds):
    judge = Referee(describe(progress=Duration(A) + 2.0 * Fraction(Duration(A), of=0.2)), ("left",))
    for _ in range(2):  # it begins afresh with each episode
        told = []
        for index, facts in enumerate(steps):
            world.time, world.facts = index * 0.1, set(facts)
            told.append((judge.judge(world) if index else judge.start(world)).progress)
        assert told == pytest.approx([s + 2.0 * min(s / 0.2, 1.0) for s in seconds])


def test_once_remembers(history):
    assert history(Once(A), "", "a", "", "") == [NO, YES, YES, YES]
    assert history(Once(A), "", "") == [NO, NO]


def test_conditions_in_time_compose(history):
    condition = Then(Sustained(A, 0.1), ~Once(B) & C)
    assert history(condition, "a", "a", "c", "") == [NO, NO, YES, YES]
    assert history(condition, "b", "a", "a", "c") == [NO, NO, NO, NO]
