"""The vector environment that `gymnasium.make_vec` finds: the joint view, many at once."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import taskbuilder.gym  # registers the tasks
from taskbuilder.env.errors import ActionError
from taskbuilder.env.joint import JointEnv
from taskbuilder.env.joint_vector import JointVectorEnv

assert taskbuilder.gym
NAME, TASK = "taskbuilder/Handover-v1", "handover"


def steps(envs, count):
    """What several steps give, resets of ended episodes included."""
    envs.action_space.seed(5)
    yield envs.reset(seed=3)[0]
    for _ in range(count):
        yield envs.step(envs.action_space.sample())[:4]


def same(first, second):
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(same(first[k], second[k]) for k in first)
    if isinstance(first, tuple):
        return all(map(same, first, second))
    return first.dtype == second.dtype and first.tobytes() == second.tobytes()


@pytest.mark.parametrize("options", [{}, {"reward": "local"}])
def test_it_gives_the_same_numbers_as_gymnasiums_own(options):
    made = gymnasium.make_vec(NAME, num_envs=2, horizon=4, **options)
    assert isinstance(made, JointVectorEnv)
    assert made.metadata["name"] == "handover_v1"
    own = SyncVectorEnv([lambda: JointEnv(TASK, horizon=4, **options)] * 2)
    assert made.single_observation_space == own.single_observation_space
    assert made.single_action_space == own.single_action_space
    assert all(map(same, steps(made, 7), steps(own, 7)))
    made.close()
    own.close()
    assert made.parallel.closed


def test_it_resets_within_the_step_on_request_and_with_workers():
    name, mode = "taskbuilder/Reach-v1", AutoresetMode.SAME_STEP
    made = gymnasium.make_vec(name, num_envs=2, workers=1, horizon=2, autoreset=mode)
    own = SyncVectorEnv([lambda: JointEnv("reach", horizon=2)] * 2, autoreset_mode=mode)
    for envs in (made, own):
        envs.action_space.seed(0)
        envs.reset(seed=0)
        envs.step(envs.action_space.sample())
    ended, expected = (envs.step(envs.action_space.sample()) for envs in (made, own))
    assert same(ended[:4], expected[:4])
    for row in range(2):
        assert same(ended[4]["final_obs"][row], expected[4]["final_obs"][row])
    made.close()
    own.close()


def test_it_shows_each_picture_once():
    options = {"cameras": ("front",), "camera_size": (16, 12), "horizon": 2}
    made = JointVectorEnv(TASK, 2, **options)
    observation, _ = made.reset(seed=0)
    assert observation in made.observation_space
    assert observation["pixels/front"].shape == (2, 12, 16, 3)
    made.close()


def test_robots_can_stay_apart():
    made = JointVectorEnv(TASK, 2, flat=False)
    made.reset(seed=0)
    actions = made.action_space.sample()
    assert set(actions) == {"left", "right"}
    assert made.step(actions)[1].shape == (2,)
    made.close()


def test_actions_of_another_shape_are_refused():
    made = JointVectorEnv("reach", 2)
    made.reset(seed=0)
    with pytest.raises(ActionError):
        made.step(np.zeros((2, 3)))
    made.close()
