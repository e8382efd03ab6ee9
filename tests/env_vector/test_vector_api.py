"""The Gymnasium vector API: spaces, shapes, kinds, wrappers, closing."""

from __future__ import annotations

import gc
from pathlib import Path

import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.wrappers.vector import DictInfoToList
from vector_tasks import random_actions, roll

from taskbuilder.env.vector import make_vec
from taskbuilder.errors import UsageError


def names(folder: str) -> set[str]:
    return {entry.name for entry in Path(folder).iterdir()}


@pytest.mark.parametrize("workers", [0, 2])
def test_it_is_a_gymnasium_vector_env(vec, workers):
    env = vec(3, workers)
    assert isinstance(env, VectorEnv)
    assert env.num_envs == 3
    assert env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert isinstance(env.single_observation_space, spaces.Dict)
    assert env.single_action_space["left"].shape == (7,)
    assert len(env.action_names["left"]) == 7
    assert env.action_names["left"][-1] == "left.gripper"
    observations, infos = env.reset(seed=1)
    assert observations in env.observation_space
    assert infos["step"].tolist() == [0.0] * 3
    observations, rewards, terminations, truncations, infos = env.step(env.action_space.sample())
    assert observations in env.observation_space
    assert set(rewards) == {"left", "right"}
    for flags in (terminations, truncations):
        assert flags.shape == (3,)
        assert flags.dtype == np.bool_
    for numbers in (*rewards.values(), *infos.values()):
        assert numbers.shape == (3,)
        assert numbers.dtype == np.float64
    assert env.state().shape == (3, *env.state_space.shape)
    assert env.state()[1] in env.state_space


def test_infos_have_the_same_keys_at_reset_and_step_but_for_the_instruction(vec):
    env = vec(1)
    _, first = env.reset()
    _, _, _, _, second = env.step(env.action_space.sample())
    assert set(first) == {*second, "instruction", "_instruction"}
    assert "lost" in first


def test_infos_can_be_taken_apart_by_gymnasium(vec):
    env = DictInfoToList(vec(2))
    _, infos = env.reset(seed=0)
    for _ in range(5):
        _, _, _, _, infos = env.step(env.action_space.sample())
    assert [info["final_info"]["step"] for info in infos] == [5.0, 5.0]
    assert set(infos[0]["final_obs"]) == {"left", "right"}


def test_what_is_returned_belongs_to_the_caller(vec):
    env, other = vec(2), vec(2)
    actions = random_actions(env, 4)
    for thing in (env, other):
        thing.reset(seed=3)
    for action in actions:
        observations, rewards, terminations, truncations, infos = env.step(action)
        expected = other.step(action)
        np.testing.assert_array_equal(observations["left"], expected[0]["left"])
        for array in (*observations.values(), *rewards.values(), *infos.values(), env.state()):
            array[:] = -1.0
        terminations[:] = truncations[:] = True


def test_dictionaries_of_channels(vec):
    env = vec(2, 1, flat=False)
    assert set(env.single_observation_space["left"].spaces) == {
        *("self.joints", "ball.pose", "time_left"),
    }
    observations, _ = env.reset(seed=0)
    assert observations in env.observation_space
    observations, *_ = env.step(env.action_space.sample())
    assert observations in env.observation_space
    assert observations["left"]["ball.pose"].shape == (2, 7)


def test_rewards_are_those_of_the_option(vec):
    env = vec(2, reward="local")
    env.reset(seed=0)
    _, rewards, _, _, infos = env.step(random_actions(env, 1)[0])
    assert not np.array_equal(rewards["left"], rewards["right"])
    np.testing.assert_allclose(sum(rewards.values()), infos["team_reward"], rtol=1e-12)


def test_closing_twice_is_fine_and_nothing_works_afterwards(vec):
    env = vec(2, 2)
    env.reset()
    env.close()
    env.close()
    assert env.worker_pids == (-1, -1)
    with pytest.raises(UsageError, match="closed"):
        env.reset()
    with pytest.raises(UsageError, match="closed"):
        env.step({})


def test_neither_descriptors_nor_memory_are_left_behind(task_file):
    def use() -> tuple[set[str], set[str]]:
        env = make_vec(task_file, 2, 1)
        roll(env, random_actions(env, 1))
        env.close()
        del env
        gc.collect()
        return names("/proc/self/fd"), names("/dev/shm")

    first = use()  # opens what is opened once for all
    assert use() == first


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"num_envs": 0}, "num_envs is 0"),
        ({"num_envs": 1, "workers": 2}, "workers is 2; 0 to 1"),
        ({"num_envs": 1, "workers": -1}, "workers is -1"),
        ({"num_envs": 1, "autoreset": "Disabled"}, '"SameStep" or "NextStep"'),
        ({"num_envs": 1, "timeout_s": 0.0}, "timeout_s"),
        ({"num_envs": 1, "retries": -1}, "retries"),
        ({"num_envs": 1, "horizon": 0}, "horizon"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(task_file, arguments, says):
    with pytest.raises(UsageError, match=says):
        make_vec(task_file, **arguments)
