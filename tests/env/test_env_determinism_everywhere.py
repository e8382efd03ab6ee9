"""Every task, three seeds, three episodes each: in workers, and restored in mid-episode."""

from __future__ import annotations

import numpy as np
import pytest
from env_tasks import LIBRARY, digest, random_actions

from taskbuilder import make_vec
from taskbuilder.env.parallel import parallel_env

SEEDS = (0, 1, 2)
EPISODES = 3
SAVED_AT = 20


@pytest.mark.slow
@pytest.mark.parametrize("task", LIBRARY)
def test_workers_give_what_one_environment_gives(task):
    vec = make_vec(task, len(SEEDS), 2)
    single = [parallel_env(task) for _ in SEEDS]
    try:
        begun, _ = vec.reset(seed=list(SEEDS))
        alone = [env.reset(seed=seed)[0] for env, seed in zip(single, SEEDS, strict=True)]
        assert _rows(begun) == [digest(seen) for seen in alone]
        horizon = single[0].episode.horizon
        for episode in range(EPISODES):
            plans = [
                random_actions(single[i], 10 * s + episode, horizon) for i, s in enumerate(SEEDS)
            ]
            for step in range(horizon):
                acts = [{a: np.asarray(v, np.float32) for a, v in p[step].items()} for p in plans]
                together = {a: np.stack([act[a] for act in acts]) for a in acts[0]}
                seen, rewards, _, truncated, _ = vec.step(together)
                for i, env in enumerate(single):
                    last, paid, *_ = env.step(acts[i])
                    assert {a: rewards[a][i] for a in paid} == paid
                    if not env.agents:
                        assert truncated[i]
                        last, _ = env.reset()  # the vector begins the next within the step
                    alone[i] = last
                assert _rows(seen) == [digest(one) for one in alone]
    finally:
        vec.close()
        for env in single:
            env.close()


@pytest.mark.slow
@pytest.mark.parametrize("task", LIBRARY)
def test_every_episode_goes_on_the_same_after_a_restore(task):
    env = parallel_env(task)
    for seed in SEEDS:
        for episode in range(EPISODES):
            env.reset(seed=seed if episode == 0 else None)
            plan = random_actions(env, 10 * seed + episode, env.episode.horizon)
            for actions in plan[:SAVED_AT]:
                env.step(actions)
            state = env.save_state()
            first = [digest(*env.step(actions)) for actions in plan[SAVED_AT:]]
            env.load_state(state)
            assert [digest(*env.step(actions)) for actions in plan[SAVED_AT:]] == first
    env.close()


def _rows(observations):
    count = len(next(iter(observations.values())))
    return [digest({a: rows[i] for a, rows in observations.items()}) for i in range(count)]
