"""Steps that are begun, and waited for later."""

from __future__ import annotations

import os
import signal
import time

import numpy as np
import pytest
from vector_tasks import digest, random_actions, roll

from taskbuilder.env.errors import ActionError, EpisodeOverError
from taskbuilder.errors import UsageError


def rolled(env, actions, seed):
    """What `roll` gives, by steps in two halves."""
    seen = [env.reset(seed=seed), env.state()]
    for action in actions:
        env.step_async(action)
        seen += [env.step_wait(), env.state()]
    return seen


@pytest.mark.parametrize("workers", [0, 2])
def test_both_halves_are_a_step(vec, workers):
    env, other = vec(2, workers), vec(2)
    actions = random_actions(env, 12)
    assert digest(rolled(env, actions, 7)) == digest(roll(other, actions, seed=7))


def test_workers_work_while_the_caller_does_something_else(vec, task_file):
    env = vec(2, 2)
    env.reset(seed=1)
    task_file.with_suffix(".order").write_text("slow")
    action = random_actions(env, 1)[0]
    begun = time.perf_counter()
    env.step_async(action)
    assert time.perf_counter() - begun < 0.5  # the work itself takes that long
    env.step_wait()
    assert time.perf_counter() - begun >= 0.5


def test_actions_belong_to_the_caller_once_a_step_has_begun(vec):
    env, other = vec(2, 1), vec(2)
    env.reset(seed=3)
    other.reset(seed=3)
    action = random_actions(env, 1)[0]
    expected = digest(other.step(action))
    env.step_async(action)
    for values in action.values():
        values[:] = 0.0
    assert digest(env.step_wait()) == expected


@pytest.mark.parametrize("workers", [0, 1])
def test_halves_out_of_order_are_refused_and_change_nothing(vec, workers):
    env, other = vec(2, workers), vec(2)
    first, second = random_actions(env, 2)
    with pytest.raises(EpisodeOverError, match="no step is under way; call step_async"):
        env.step_wait()
    env.reset(seed=1)
    other.reset(seed=1)
    with pytest.raises(EpisodeOverError, match="no step is under way"):
        env.step_wait()
    env.step_async(first)
    for too_early in (env.step_async, env.step):
        with pytest.raises(EpisodeOverError, match="a step is under way; call step_wait"):
            too_early(second)
    with pytest.raises(EpisodeOverError, match="a step is under way"):
        env.state()
    assert digest(env.step_wait()) == digest(other.step(first))
    with pytest.raises(ActionError):
        env.step_async({agent: values * np.nan for agent, values in second.items()})
    with pytest.raises(EpisodeOverError, match="no step is under way"):
        env.step_wait()
    assert digest(env.step(second)) == digest(other.step(second))


@pytest.mark.parametrize("workers", [0, 2])
def test_a_reset_leaves_a_step_that_nobody_waited_for_behind(vec, workers):
    env, other = vec(2, workers), vec(2)
    actions = random_actions(env, 4)
    env.reset(seed=1)
    env.step_async(actions[0])
    assert digest(roll(env, actions, seed=5)) == digest(roll(other, actions, seed=5))


def test_a_worker_that_dies_meanwhile_is_replaced(vec):
    env = vec(2, 2)
    first, second = random_actions(env, 2)
    env.reset(seed=1)
    env.step_async(first)
    os.kill(env.worker_pids[1], signal.SIGKILL)
    *_, truncations, infos = env.step_wait()
    if infos["lost"][1]:  # it may have been quicker
        assert truncations.tolist() == [False, True]
        *_, infos = env.step(second)
        assert infos["step"].tolist() == [2.0, 1.0]
    else:
        *_, infos = env.step(second)
        assert infos["lost"].tolist() == [0.0, 1.0]


def test_closing_ends_a_step_under_way(vec):
    env = vec(2, 1)
    env.reset(seed=1)
    env.step_async(random_actions(env, 1)[0])
    env.close()
    with pytest.raises(UsageError, match="closed"):
        env.step_wait()
