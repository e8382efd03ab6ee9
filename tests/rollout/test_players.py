"""Policies beside the expert: random actions, holding still, and any function."""

from __future__ import annotations

import numpy as np
import pytest

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout import HoldStill, RandomActions, play, replay


@pytest.fixture(params=[True, False], ids=["normalized", "physical"])
def env(request):
    made = parallel_env("pick_push_place", horizon=8, normalize=request.param)
    yield made
    made.close()


def test_random_actions_are_spread_within_their_bounds(env):
    episode = play(env, RandomActions(), 0)
    for agent, actions in episode.actions.items():
        space = env.action_space(agent)
        assert actions.dtype == np.float32
        assert actions.shape == (8, *space.shape)
        assert (actions >= space.low - 1e-6).all()
        assert (actions <= space.high + 1e-6).all()
        assert np.ptp(actions / space.high) > 1.2


def test_the_seed_decides_what_is_drawn(env):
    first, again, other = (play(env, RandomActions(), seed) for seed in (1, 1, 2))
    assert np.array_equal(first.actions["left"], again.actions["left"])
    assert not np.array_equal(first.actions["left"], other.actions["left"])
    assert not np.array_equal(first.actions["left"], first.actions["right"])


def test_doing_nothing_leaves_everything_where_it_is(env):
    joints = []

    def note(played):
        robots = played.episode.world.robots.values()
        joints.append([robot.arm_state()[0] for robot in robots])

    episode = play(env, HoldStill(), 0, watch=note)
    assert episode.steps == 8
    assert len(joints) == 9
    assert abs(np.array(joints) - joints[0]).max() < 1e-3


def test_a_function_acts_by_what_is_seen_at_each_step(env):
    seen = []

    def act(observations):
        seen.append({agent: values.copy() for agent, values in observations.items()})
        # Something that follows from what is seen, in finer numbers than are kept.
        return {
            agent: np.resize(np.tanh(values.astype(np.float64)), env.action_space(agent).shape)
            for agent, values in observations.items()
        }

    episode = play(env, act, 3)
    assert len(seen) == episode.steps == 8
    shown, _ = env.reset(seed=3)
    for step, expected in enumerate(seen):
        for agent, values in shown.items():
            assert np.array_equal(values, expected[agent])
            assert episode.actions[agent].dtype == np.float32
        shown, *_ = env.step({agent: told[step] for agent, told in episode.actions.items()})


@pytest.mark.parametrize("policy", [RandomActions(), HoldStill()])
def test_what_was_played_can_be_played_again(policy, env):
    episode = play(env, policy, 3)
    rewards = []
    again = replay(env, episode, lambda played: rewards.append(played.team_reward()))
    assert rewards[1:] == episode.rewards.tolist()
    assert again.equals(episode)


def test_an_environment_that_draws_its_variation_has_no_expert_but_its_episodes_say_which(tmp_path):
    env = parallel_env("handover", variation="random", horizon=2)
    with pytest.raises(UsageError, match="an expert plans for one variation"):
        Expert(env)
    drawn = {play(env, HoldStill(), seed).variation for seed in range(12)}
    env.close()
    assert drawn == {0, 1, 2}
