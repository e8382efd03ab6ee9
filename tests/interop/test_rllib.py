from __future__ import annotations

import math

import pytest
import ray
import rllib_ppo
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv

import taskbuilder

TASKS = ("collaborative_lift", "handover", "pick_push_place")


@pytest.fixture(scope="module", autouse=True)
def local():
    ray.init(num_cpus=1, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


@pytest.mark.parametrize("task", TASKS)
def test_an_environment_is_reset_and_stepped(task):
    env = ParallelPettingZooEnv(taskbuilder.parallel_env(task))
    observations, _ = env.reset(seed=0)
    assert set(observations) == {"left", "right"}
    for step in range(1, 51):
        step_back = env.step(env.action_space.sample())
        observations, rewards, terminations, truncations, _ = step_back
        assert all(env.observation_space[agent].contains(o) for agent, o in observations.items())
        assert all(map(math.isfinite, rewards.values()))
        assert truncations["__all__"] == (step == 50)
        assert not terminations["__all__"]
    env.close()


def test_ppo_learns_for_an_iteration():
    returns = rllib_ppo.main(iterations=1, batch=200)
    assert len(returns) == 1
    assert math.isfinite(returns[0])
