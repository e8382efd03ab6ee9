"""Noise on actions, and random commands to grippers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taskbuilder.learn.algorithms.maddpg import MaddpgSettings
from taskbuilder.learn.exploration import LONGEST_COMMAND, Exploration

QUIET = MaddpgSettings(noise=0.0, final_noise=0.0, gripper_epsilon=0.02)
GRIPPERS = (1, 3)


def explored(exploration, steps, envs=1, seed=0, *, policy=-0.5):
    """The actions of a policy that always does the same, made exploratory: (steps, envs, 4)."""
    rng, taken = np.random.default_rng(seed), []
    for _ in range(steps):
        actions = np.full((envs, 4), policy, dtype=np.float32)
        exploration.explore_(actions, rng, 0.0)
        taken.append(actions)
    return np.array(taken)


def runs(values):
    """The lengths of the stretches of True, in the columns of (steps, n) bool."""
    none = np.zeros((1, values.shape[1]), dtype=np.bool_)
    edges = np.diff(np.concatenate([none, values, none]).astype(int), axis=0).T
    return np.nonzero(edges == -1)[1] - np.nonzero(edges == 1)[1]


def test_the_noise_falls_until_its_share_of_the_training():
    settings = MaddpgSettings(noise=0.25, final_noise=0.1, noise_until=0.4)
    noise = [Exploration((), settings).noise(done) for done in (0.0, 0.2, 0.4, 1.0)]
    assert noise == pytest.approx([0.25, 0.175, 0.1, 0.1])


def test_commands_to_grippers_alone_are_now_and_then_random_and_then_last():
    taken = explored(Exploration(GRIPPERS, replace(QUIET, least_noise=1.0)), 1_000, envs=100)
    assert (taken[:, :, [0, 2]] == -0.5).all()
    for gripper in GRIPPERS:
        own = taken[:, :, gripper]
        random = own != -0.5
        assert set(own[random]) == {-1.0, 1.0}
        assert random.mean() == pytest.approx(0.02 * 5.5 / (1.0 + 0.02 * 4.5), rel=0.1)
        lengths = runs(random)
        assert lengths.min() == 1
        assert lengths.mean() == pytest.approx((1 + LONGEST_COMMAND) / 2, rel=0.15)
        assert (own[random] > 0.0).mean() == pytest.approx(0.5, abs=0.05)
    both = (taken[:, :, GRIPPERS] != -0.5).all(2)
    assert both.mean() < 0.02  # each gripper by itself


def test_a_random_command_stays_the_same_while_it_lasts():
    rare = Exploration(GRIPPERS, replace(QUIET, gripper_epsilon=0.001))
    taken = explored(rare, 1_000, envs=100)[:, :, 1]
    assert runs(taken != -0.5).max() <= LONGEST_COMMAND
    assert not (np.abs(np.diff(taken, axis=0)) == 2.0).any()


def test_they_are_rarer_where_there_is_less_noise():
    exploration = Exploration(GRIPPERS, replace(QUIET, least_noise=0.1))
    random = (explored(exploration, 1_000, envs=99)[:, :, GRIPPERS] != -0.5).mean((0, 2))
    few, some, most = (part.mean() for part in np.split(random, 3))
    assert 0.0 < few < 0.6 * some < 0.5 * most


@pytest.mark.parametrize(
    ("grippers", "settings"), [((), QUIET), (GRIPPERS, replace(QUIET, gripper_epsilon=0.0))]
)
def test_without_grippers_or_chance_actions_stay_as_they_are(grippers, settings):
    exploration = Exploration(grippers, settings)
    assert (explored(exploration, 500) == -0.5).all()
    assert not exploration.arrays()


def test_what_is_loaded_goes_on_with_the_commands_in_progress():
    one = Exploration(GRIPPERS, replace(QUIET, gripper_epsilon=0.5))
    explored(one, 20, envs=3)
    other = Exploration(GRIPPERS, replace(QUIET, gripper_epsilon=0.5))
    other.load(one.arrays())
    assert (one.arrays()["gripper_steps_left"] > 0).any()
    assert (explored(one, 50, 3, seed=1) == explored(other, 50, 3, seed=1)).all()


def test_what_is_loaded_must_be_whole():
    with pytest.raises(KeyError):
        Exploration(GRIPPERS, QUIET).load({})
