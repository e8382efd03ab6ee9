from __future__ import annotations

import numpy as np
import supersuit

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
