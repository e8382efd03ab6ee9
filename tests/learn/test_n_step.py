"""Transitions over n control steps, against returns worked out from the whole episode."""

from __future__ import annotations

import numpy as np
import pytest
from hand_made import Given, row, set_to
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.learn.n_step import NStepTransitions
from taskbuilder.learn.shapes import Shapes

SHAPES = Shapes({"left": 1, "right": 1}, {"left": 1, "right": 1}, 1)
LAYOUT = SHAPES.layout
DISCOUNT = 0.9

steps_of = st.lists(st.sampled_from(["on", "ended", "terminated", "lost"]), max_size=12)


def numbered(number, flag):
    """A transition whose parts say at which step it was."""
    return row(
        SHAPES,
        observations={"left": number, "right": -number},
        actions={"left": number / 100.0, "right": 0.0},
        next_observations={"left": number + 1.0, "right": -number - 1.0},
        rewards=[number + 1.0, 2.0 * number],
        state=number,
        next_state=number + 1.0,
        ended=float(flag in ("ended", "terminated")),
        terminated=float(flag == "terminated"),
    )[0]


def joined(flags, n):
    """What comes out when a single environment makes these steps, in order."""
    transitions, out = NStepTransitions(LAYOUT, 1, n, DISCOUNT), []
    for number, flag in enumerate(flags):
        lost = np.array([flag == "lost"])
        out += list(transitions.add(numbered(number, flag)[None], lost))
    return out


def expected(flags, n):
    """For each transition that must come out: first step, steps, how it ends."""
    for first, flag in enumerate(flags):
        if flag == "lost":
            continue
        last = first
        while flags[last] == "on" and last - first < n - 1:
            if last + 1 == len(flags):
                last = None  # still in progress
                break
            if flags[last + 1] == "lost":
                break
            last += 1
        if last is not None:
            yield first, last


@given(steps_of, st.integers(1, 5))
def test_rewards_are_discounted_sums_and_the_rest_is_that_of_the_last_step(flags, n):
    out = joined(flags, n)
    wanted = sorted(expected(flags, n))
    assert sorted(int(each[LAYOUT.state.start]) for each in out) == [first for first, _ in wanted]
    for each, (first, last) in zip(
        sorted(out, key=lambda r: r[LAYOUT.state][0]), wanted, strict=True
    ):
        own, end = numbered(first, flags[first]), numbered(last, flags[last])
        rewards = sum(
            DISCOUNT**age * numbered(first + age, "on")[LAYOUT.rewards]
            for age in range(last - first + 1)
        )
        assert each[LAYOUT.rewards] == pytest.approx(rewards, rel=1e-5)
        assert each[LAYOUT.extra_steps].tolist() == [last - first]
        for part in (LAYOUT.critic_input, LAYOUT.actions):
            assert np.array_equal(each[part], own[part])
        for part in (LAYOUT.ended, LAYOUT.terminated, LAYOUT.next_critic_input):
            assert np.array_equal(each[part], end[part])


@given(steps_of)
def test_single_steps_stay_as_they_are(flags):
    out = joined(flags, 1)
    kept = [numbered(n, flag) for n, flag in enumerate(flags) if flag != "lost"]
    assert np.array_equal(out, kept)


def test_environments_do_not_mix_and_a_reset_drops_what_is_in_progress():
    transitions = NStepTransitions(LAYOUT, 2, 2, DISCOUNT)
    none = np.zeros(2, dtype=np.bool_)
    assert not len(transitions.add(np.stack([numbered(0, "on"), numbered(50, "on")]), none))
    both = transitions.add(np.stack([numbered(1, "on"), numbered(51, "ended")]), none)
    assert both[:, LAYOUT.state.start].tolist() == [0.0, 50.0, 51.0]
    transitions.begin()
    assert not len(transitions.add(np.stack([numbered(9, "on"), numbered(59, "on")]), none))


@pytest.mark.parametrize("name", ["maddpg", "maddpg_openai"])
def test_values_after_n_steps_are_discounted_by_as_many(name):
    pytest.importorskip("torch")
    from taskbuilder.learn.algorithms import find_algorithm

    algorithm = find_algorithm(name)
    settings = algorithm.settings(hidden=(), discount=DISCOUNT, regulariser=0.0)
    learner = algorithm.learner(SHAPES, settings, shared_reward=True, seed=0, device="cpu")
    biases = (
        n
        for n in learner.arrays()
        if n.endswith(("target_critics/layers.0.bias", "target_critic/1"))
    )
    set_to(learner, dict.fromkeys(biases, 2.0))
    rows = row(SHAPES, rewards=[0.5, 0.5], extra_steps=2.0)
    loss = learner.update(Given(rows), np.random.default_rng(0), 0)["critic"]
    critics = 2 if name == "maddpg" else 1  # whose losses are added
    assert loss == pytest.approx(critics * (0.5 + DISCOUNT**3 * 2.0) ** 2, rel=1e-5)
