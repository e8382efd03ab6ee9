"""Tasks as LeRobot's evaluation plays them: batches, final infos and texts where it looks."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv

import taskbuilder.gym  # registers the environments
from taskbuilder.env.lerobot import LeRobotEnv, make_env
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UnknownNameError, UsageError

gymnasium.register_envs(taskbuilder.gym)

SMALL = {"tasks": ["handover"], "cameras": ["front"], "camera_size": [48, 32], "horizon": 3}


def rolled_out(envs):
    """What LeRobot reads in an evaluation of one batch: as its own rollout does."""
    (suite,) = envs
    (number,) = envs[suite]
    vector = envs[suite][number]
    try:
        observation, _ = vector.reset(seed=[5, 6])
        told = hasattr(vector.envs[0], "task_description") and vector.call("task_description")
        lengths = vector.call("_max_episode_steps")
        picture = vector.call("render")[0]
        actions = np.full((2, 10), 0.1, dtype=np.float32)
        done = np.zeros(2, dtype=bool)
        for _ in range(lengths[0]):
            assert not done.any()
            _, reward, terminated, truncated, info = vector.step(actions)
            done |= terminated | truncated
        rate = vector.unwrapped.metadata["render_fps"]
        return observation, told, lengths, picture, reward, done, info["final_info"], rate
    finally:
        vector.close()


@pytest.fixture(scope="module")
def in_turn():
    return rolled_out(make_env(2, **SMALL))


def test_a_batch_has_what_lerobot_reads(in_turn):
    observation, told, lengths, picture, reward, done, final, rate = in_turn
    assert observation["agent_pos"].shape == (2, 14)
    assert observation["agent_pos"].dtype == np.float32
    assert observation["pixels"]["front"].shape == (2, 32, 48, 3)
    assert observation["pixels"]["front"].dtype == np.uint8
    assert len(told) == 2
    assert all("stick" in text for text in told)
    assert lengths == (3, 3)
    assert picture.ndim == 3
    assert reward.shape == (2,)
    assert done.all()
    assert final["is_success"].tolist() == [False, False]
    assert rate == 10


def test_processes_play_the_same(in_turn):
    apart = rolled_out(make_env(2, True, **SMALL))
    for here, there in zip(in_turn[:6], apart[:6], strict=True):
        if isinstance(here, dict):
            np.testing.assert_array_equal(there["agent_pos"], here["agent_pos"])
            np.testing.assert_array_equal(there["pixels"]["front"], here["pixels"]["front"])
        else:
            np.testing.assert_array_equal(there, here)


def test_environments_are_by_suite_and_number_of_the_task():
    for apart, kind in ((False, SyncVectorEnv), (True, AsyncVectorEnv)):
        made = make_env(n_envs=1, use_async_envs=apart, cfg=None, tasks=("reach", "pick_place"))
        assert list(made) == ["taskbuilder"]
        assert list(made["taskbuilder"]) == [0, 1]
        for vector, name in zip(made["taskbuilder"].values(), ("reach", "pick_place"), strict=True):
            assert isinstance(vector, kind)
            assert vector.call("task") == (name,)
            vector.close()


def test_gymnasium_makes_it_without_wrappers():
    env = gymnasium.make("taskbuilder/LeRobot-v0", task="reach")
    assert type(env) is LeRobotEnv
    env.reset(seed=1)
    assert isinstance(env.task_description, str)
    env.close()


def test_it_keeps_gymnasiums_contract():
    env = LeRobotEnv("reach", horizon=5)
    check_env(env, skip_render_check=True)
    env.close()


def test_agent_pos_is_of_joints_and_grippers():
    env = LeRobotEnv("handover")
    seen, _ = env.reset(seed=3)
    names = [*(f"left.joint_{n}" for n in range(1, 7)), "left.gripper"]
    assert list(env.state_names[:7]) == names
    plain = parallel_env("handover")
    plain.reset(seed=3)
    left = plain.episode.world.robots["left"]
    expected = np.array([*left.arm_state()[0], left.opening()], dtype=np.float32)
    np.testing.assert_array_equal(seen["agent_pos"][:7], expected)
    assert list(seen) == ["agent_pos"]
    env.close()
    plain.close()


@pytest.mark.parametrize(
    ("words", "error", "said"),
    [
        ({"n_envs": 0}, UsageError, "n_envs is 0; at least 1"),
        ({"tasks": "handover"}, UsageError, r'tasks is a list of names or paths, such as \["hand'),
        ({"tasks": ()}, UsageError, "tasks is a list"),
        ({"tasks": ["handovr"]}, UnknownNameError, 'did you mean "handover"'),
        ({"flat": False}, UsageError, "flat=False is not for LeRobot"),
        ({"normalize": False}, UsageError, "normalize=False is not for LeRobot"),
        ({"cameras": ["frnt"]}, UsageError, 'did you mean "front"'),
    ],
)
def test_mistakes_are_explained(words, error, said):
    with pytest.raises(error, match=said):
        make_env(**words)
