"""The layout of a row: every part in a place of its own, whatever the sizes."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.env.vector import make_vec
from taskbuilder.learn.shapes import Layout, Shapes, joined
from taskbuilder.learn.training import shapes_of

sizes = st.lists(
    st.tuples(st.integers(1, 5), st.integers(1, 4)), min_size=1, max_size=4
)  # of what each agent sees and does


def made(pairs, state=3):
    names = [f"agent{number}" for number in range(len(pairs))]
    seen, done = zip(*pairs, strict=True)
    return Shapes(dict(zip(names, seen, strict=True)), dict(zip(names, done, strict=True)), state)


def places(layout):
    """All parts, by name."""
    flags = ("rewards", "ended", "terminated", "demonstrated", "extra_steps")
    parts = {name: getattr(layout, name) for name in ("state", "next_state", *flags)}
    for name in ("observations", "action", "next_observations"):
        parts |= {f"{name}/{agent}": part for agent, part in getattr(layout, name).items()}
    return parts


@given(sizes, st.integers(0, 6))
def test_parts_fill_a_row_and_none_lies_upon_another(pairs, state):
    shapes = made(pairs, state)
    layout = shapes.layout
    taken = [n for part in places(layout).values() for n in range(part.start, part.stop)]
    assert sorted(taken) == list(range(layout.width))


@given(sizes)
def test_parts_have_the_sizes_that_were_given(pairs):
    shapes = made(pairs, state=6)
    layout = shapes.layout
    for agent, (seen, done) in zip(shapes.agents, pairs, strict=True):
        for part in (layout.observations[agent], layout.next_observations[agent]):
            assert part.stop - part.start == seen
        assert layout.action[agent].stop - layout.action[agent].start == done
    assert layout.rewards.stop - layout.rewards.start == len(pairs)
    assert layout.actions.stop - layout.actions.start == shapes.joint_action
    for part in (layout.state, layout.next_state):
        assert part.stop - part.start == 6


@given(sizes)
def test_the_joint_action_is_the_agents_one_after_the_other(pairs):
    shapes = made(pairs)
    layout = shapes.layout
    own = [n for part in layout.action.values() for n in range(part.start, part.stop)]
    assert own == list(range(layout.actions.start, layout.actions.stop))


@pytest.mark.parametrize("demonstrated", [False, True])
def test_transitions_are_laid_out_where_the_layout_says(demonstrated):
    shapes = made([(2, 1), (1, 3)], state=2)
    draws, layout = np.random.default_rng(0), shapes.layout
    now = {a: draws.random((4, n)) for a, n in shapes.observations.items()}
    later = {a: draws.random((4, n)) for a, n in shapes.observations.items()}
    actions = {a: draws.random((4, n)) for a, n in shapes.actions.items()}
    state, next_state, rewards = (draws.random((4, 2)) for _ in range(3))
    ended, terminated = (np.array(flags, dtype=bool) for flags in ([1, 1, 0, 0], [0, 1, 0, 0]))
    rest = (ended, terminated, later, next_state)
    rows = layout.rows(now, state, actions, rewards, *rest, demonstrated=demonstrated)
    assert rows.shape == (4, layout.width)
    assert rows.dtype == np.float32
    for agent in shapes.agents:
        assert rows[:, layout.observations[agent]] == pytest.approx(now[agent])
        assert rows[:, layout.next_observations[agent]] == pytest.approx(later[agent])
        assert rows[:, layout.action[agent]] == pytest.approx(actions[agent])
    assert rows[:, layout.actions] == pytest.approx(joined(actions, shapes.agents))
    assert rows[:, layout.state] == pytest.approx(state)
    assert rows[:, layout.next_state] == pytest.approx(next_state)
    assert rows[:, layout.rewards] == pytest.approx(rewards)
    assert rows[:, layout.ended][:, 0].tolist() == [1.0, 1.0, 0.0, 0.0]
    assert rows[:, layout.terminated][:, 0].tolist() == [0.0, 1.0, 0.0, 0.0]
    assert set(rows[:, layout.demonstrated][:, 0]) == {float(demonstrated)}
    assert set(rows[:, layout.extra_steps][:, 0]) == {0.0}


def test_agents_that_see_and_do_equally_many_numbers_are_alike():
    shapes = made([(2, 1), (3, 1), (2, 1), (2, 2)])
    assert shapes.same_spaces() == (("agent0", "agent2"), ("agent1",), ("agent3",))


@pytest.mark.parametrize(("task", "grippers"), [("handover", (4, 9)), ("pusher_and_picker", (8,))])
def test_actions_that_command_grippers_are_known(task, grippers):
    with closing(make_vec(task, 1)) as envs:
        assert shapes_of(envs, 0).grippers == grippers


def test_parts_are_joined_in_the_order_asked_for():
    parts = {"a": np.array([[1.0], [2.0]]), "b": np.array([[3.0, 4.0], [5.0, 6.0]])}
    assert joined(parts, ("b", "a")).tolist() == [[3.0, 4.0, 1.0], [5.0, 6.0, 2.0]]


def test_the_layout_is_worked_out_once():
    shapes = made([(1, 1)])
    assert shapes.layout is shapes.layout
    assert isinstance(shapes.layout, Layout)
