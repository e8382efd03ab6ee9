from __future__ import annotations

import gymnasium
import numpy as np
import pytest
import stable_baselines3_ppo
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env

import taskbuilder.gym

gymnasium.register_envs(taskbuilder.gym)
TASKS = ("CollaborativeLift", "Handover", "PickPushPlace")


@pytest.mark.parametrize("task", TASKS)
def test_the_joint_view_passes_its_check(task):
    env = gymnasium.make(f"taskbuilder/{task}-v1")
    check_env(env.unwrapped)
    env.close()


def test_ppo_learns_without_a_stumble():
    model = stable_baselines3_ppo.main(2000)
    assert isinstance(model, PPO)
    assert model.num_timesteps == 2000
    assert np.isfinite([info["r"] for info in model.ep_info_buffer]).all()
    assert len(model.ep_info_buffer) == 40


def test_sac_learns_without_a_stumble():
    env = gymnasium.make("taskbuilder/Handover-v1")
    model = SAC("MlpPolicy", env, learning_starts=100, train_freq=10, seed=0, device="cpu")
    model.learn(2000)
    assert model.num_timesteps == 2000
    env.close()


def test_several_environments_in_one_process_learn_together():
    envs = make_vec_env("taskbuilder/Handover-v1", n_envs=2, seed=0)
    model = PPO("MlpPolicy", envs, n_steps=50, batch_size=50, n_epochs=1, device="cpu")
    model.learn(200)
    envs.close()


def test_a_model_is_the_same_when_learnt_again():
    ends = []
    for _ in range(2):
        env = gymnasium.make("taskbuilder/Handover-v1")
        model = PPO("MlpPolicy", env, n_steps=100, batch_size=50, n_epochs=2, seed=3, device="cpu")
        model.learn(200)
        ends.append([value.numpy().tobytes() for value in model.policy.state_dict().values()])
        env.close()
    assert ends[0] == ends[1]


def test_ppo_learns_from_pictures_and_numbers():
    env = gymnasium.make(
        "taskbuilder/Handover-v1", cameras=("front", "left_wrist"), camera_size=(48, 48)
    )
    check_env(env.unwrapped)
    model = PPO("MultiInputPolicy", env, n_steps=32, batch_size=16, n_epochs=1, device="cpu")
    model.learn(32)
    assert model.num_timesteps == 32
    env.close()
