"""Reward terms, who earns them, and what they add up to."""

from __future__ import annotations

import functools
import operator

import pytest
from fake_world import A, FakeWorld, Number, describe
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.description import Bonus, Distance, Paid, Potential
from taskbuilder.description.description import Referee

AGENTS = ("left", "middle", "right")
X = Number("x")


def start(world, *terms, agents=("left", "right")):
    return Referee(describe(None, *terms), agents).start(world)


def test_a_bonus_pays_while_its_condition_holds(world, referee):
    judge = referee(None, Bonus("grasp", A, 1.5, agent="left"))
    pay = []
    for facts in ("", "a", "a", ""):
        world.facts = set(facts)
        pay.append((judge.judge(world) if pay else judge.start(world)).terms["grasp/left"])
    assert pay == [0.0, 1.5, 1.5, 0.0]


def test_distance_costs_metres(world):
    world.put("cube", 0.3, 0.4, 0.0)
    outcome = start(world, Distance("reach", "cube", "goal", agent="left"))
    assert outcome.terms == {"reach/left": pytest.approx(-0.5)}
    outcome = start(world, Distance("reach", "cube", "goal", 2.0))
    assert outcome.terms == {"reach": pytest.approx(-1.0)}


def test_a_measure_can_be_paid_as_it_is(world):
    world.numbers = {"x": 0.25}
    assert start(world, Paid("x", X, 4.0)).terms == {"x": 1.0}


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=20), st.floats(-2, 2))
def test_a_potential_pays_nothing_at_the_start_and_then_telescopes(values, weight):
    world = FakeWorld()
    judge = Referee(describe(None, Potential("gain", X, weight)), ("left",))
    paid = []
    for value in values:
        world.numbers = {"x": value}
        paid.append((judge.judge(world) if paid else judge.start(world)).team)
    assert paid[0] == 0.0
    assert sum(paid) == pytest.approx(weight * (values[-1] - values[0]), abs=1e-9)


def test_a_discounted_potential_is_that_of_ng_harada_and_russell(world, referee):
    judge = referee(None, Potential("gain", X, 2.0, 0.9))
    world.numbers = {"x": 1.0}
    assert judge.start(world).team == 0.0
    world.numbers = {"x": 3.0}
    assert judge.judge(world).team == pytest.approx(2.0 * (0.9 * 3.0 - 1.0))


def test_what_is_common_is_shared_evenly(world):
    world.numbers = {"x": 1.0}
    outcome = start(world, Paid("common", X, 3.0), Paid("own", X, agent="left"), agents=AGENTS)
    assert outcome.local == {"left": 2.0, "middle": 1.0, "right": 1.0}
    assert outcome.team == 4.0
    assert list(outcome.local) == list(AGENTS)


def test_terms_are_labelled_by_name_and_agent_in_the_description_s_order(world):
    world.numbers = {"x": 1.0}
    terms = Paid("x", X), Paid("x", X, agent="right"), Paid("x", X, agent="left")
    assert list(start(world, *terms).terms) == ["x", "x/right", "x/left"]


@given(
    st.lists(
        st.tuples(st.floats(-1e6, 1e6), st.sampled_from([*AGENTS, None])), min_size=1, max_size=12
    )
)
def test_the_agents_rewards_add_up_to_the_team_s_bit_for_bit(pay):
    terms = [Paid(str(i), X, weight, agent=agent) for i, (weight, agent) in enumerate(pay)]
    outcome = start(FakeWorld(numbers={"x": 0.1}), *terms, agents=AGENTS)
    assert outcome.team == functools.reduce(operator.add, outcome.local.values(), 0.0)
    assert outcome.team == pytest.approx(sum(outcome.terms.values()), abs=1e-6)
