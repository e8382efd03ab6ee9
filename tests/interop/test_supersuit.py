from __future__ import annotations

import numpy as np
import pytest
import supersuit
from stable_baselines3 import PPO

import taskbuilder


def test_rows_of_a_vector_have_a_world_each():
    env = taskbuilder.parallel_env("handover")
    rows = supersuit.concat_vec_envs_v1(supersuit.pettingzoo_env_to_vec_env_v1(env), 2)
    rows.reset(seed=3)
    first, second = (row.par_env for row in rows.vec_envs)
    assert first.episode.world.client is not second.episode.world.client
    before = first.state()
    second.step({agent: np.ones(second.action_space(agent).shape) for agent in second.agents})
    assert np.array_equal(first.state(), before)
    assert not np.array_equal(second.state(), before)
    rows.close()


@pytest.mark.parametrize("task", ["handover", "gather_cubes"])
@pytest.mark.parametrize("processes", [0, 2])
def test_stable_baselines_learns_in_processes_of_its_rows(task, processes):
    env = taskbuilder.parallel_env(task, horizon=4, observe="scene")
    rows = supersuit.concat_vec_envs_v1(
        supersuit.pettingzoo_env_to_vec_env_v1(env),
        2,
        num_cpus=processes,
        base_class="stable_baselines3",
    )
    first = rows.reset()
    half = len(first) // 2
    assert not np.array_equal(first[:half], first[half:])  # each row has episodes of its own
    PPO("MlpPolicy", rows, n_steps=8, batch_size=8, n_epochs=1).learn(8 * len(first))
    for _ in range(4):
        *_, infos = rows.step(np.zeros((len(first), *rows.action_space.shape), np.float32))
        if "terminal_observation" in infos[0]:
            break
    else:
        pytest.fail("no episode ended")
    rows.close()
    env.close()
