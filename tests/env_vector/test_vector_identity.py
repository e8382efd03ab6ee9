"""What happens depends on seeds and actions alone: not on workers, and as in a single one."""

from __future__ import annotations

import numpy as np
from vector_tasks import digest, random_actions, roll

from taskbuilder.env.parallel import parallel_env


def test_any_number_of_workers_gives_the_same_to_the_bit(vec):
    hashes = set()
    for workers in (0, 1, 2, 3):
        env = vec(3, workers)
        hashes.add(digest(roll(env, random_actions(env, 12), seed=7)))
        env.close()
    assert len(hashes) == 1


def test_each_environment_is_a_single_one_with_its_seed(vec, task_file):
    env = vec(2)
    actions = random_actions(env, 12)
    single = parallel_env(task_file)
    for number in range(2):
        observations, _ = env.reset(seed=5)
        expected, _ = single.reset(seed=5 + number)
        for action in actions:
            for agent in env.agents:
                np.testing.assert_array_equal(observations[agent][number], expected[agent])
            observations, rewards, *_ = env.step(action)
            expected, paid, *_ = single.step({agent: action[agent][number] for agent in env.agents})
            assert {agent: pay[number] for agent, pay in rewards.items()} == paid
            if not single.agents:
                expected, _ = single.reset()
            np.testing.assert_array_equal(env.state()[number], single.state())
    single.close()


def test_seeds_may_be_given_one_by_one_or_left_out(vec):
    env = vec(2)
    together = digest(env.reset(seed=[4, 5]))
    assert digest(env.reset(seed=4)) == together
    following = digest(env.reset())
    assert following != together
    first, _ = env.reset(seed=[4, None])
    env.reset(seed=4)
    again, _ = env.reset(seed=[4, None])
    np.testing.assert_array_equal(first["left"][0], again["left"][0])
    assert not np.array_equal(first["left"][1], again["left"][1])
    env.reset(seed=4)
    assert digest(env.reset()) == following


def test_without_a_seed_no_two_begin_alike(vec):
    observations, _ = vec(3).reset()
    assert len(np.unique(observations["left"], axis=0)) == 3
