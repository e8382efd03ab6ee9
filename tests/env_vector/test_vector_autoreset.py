"""What follows the end of an episode, by either kind of autoreset."""

from __future__ import annotations

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from vector_tasks import random_actions

HORIZON = 5


@pytest.fixture(params=[0, 2])
def workers(request):
    return request.param


def test_same_step_shows_the_next_beginning_and_the_old_end(vec, workers):
    env = vec(2, workers)
    env.reset(seed=1)
    actions = random_actions(env, HORIZON)
    for action in actions[:-1]:
        *_, infos = env.step(action)
        assert "final_obs" not in infos
    observations, rewards, terminations, truncations, infos = env.step(actions[-1])
    assert not terminations.any()
    assert truncations.all()
    assert (rewards["left"] < 0.0).all()  # the last step of the old episode pays
    assert infos["step"].tolist() == [0.0, 0.0]
    assert infos["_final_obs"].all()
    assert infos["final_info"]["step"].tolist() == [HORIZON] * 2
    assert infos["final_state"].shape == env.state().shape
    for number in range(2):
        assert infos["final_obs"][number] in env.single_observation_space
        assert infos["final_obs"][number]["left"][-1] == 0.0  # time left
    assert (observations["left"][:, -1] == 1.0).all()
    assert (env.state()[:, -1] == 1.0).all()


def test_same_step_leaves_episodes_alone_that_go_on(vec, workers):
    env = vec(2, workers, horizon=100)
    actions = random_actions(env, 60)
    env.reset(seed=2)
    for action in actions:  # until one of the balls has fallen
        *_, terminations, truncations, infos = env.step(action)
        if terminations.any():
            break
    assert terminations.sum() == 1
    assert not truncations.any()
    ended, other = int(np.argmax(terminations)), int(np.argmin(terminations))
    assert infos["_final_obs"].tolist() == terminations.tolist()
    assert infos["final_obs"][other] is None
    assert infos["final_info"]["failure"][ended] == 1.0
    assert infos["step"][ended] == 0.0
    assert infos["step"][other] > 0.0


def test_next_step_shows_the_end_and_then_begins(vec, workers):
    env = vec(2, workers, autoreset="NextStep")
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    env.reset(seed=1)
    *actions, last = random_actions(env, HORIZON + 1)
    for action in actions:
        observations, _, _, truncations, infos = env.step(action)
    assert truncations.all()
    assert "final_obs" not in infos
    assert (observations["left"][:, -1] == 0.0).all()
    observations, rewards, terminations, truncations, infos = env.step(last)
    assert not (terminations | truncations).any()
    assert rewards["left"].tolist() == [0.0, 0.0]
    assert infos["step"].tolist() == [0.0, 0.0]
    assert (observations["left"][:, -1] == 1.0).all()


def test_both_kinds_run_the_same_episodes(vec):
    same, following = vec(2), vec(2, autoreset="NextStep")
    actions = random_actions(same, 4 * HORIZON)
    same.reset(seed=1)
    following.reset(seed=1)
    for number, action in enumerate(actions):
        expected, *_ = same.step(action)
        seen, _, _, truncations, _ = following.step(action)
        assert truncations.all() == (number % HORIZON == HORIZON - 1)
        if truncations.all():
            seen, *_ = following.step(action)  # which is not carried out
        np.testing.assert_array_equal(seen["left"], expected["left"])
