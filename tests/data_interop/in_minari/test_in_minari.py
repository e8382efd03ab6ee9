"""Minari loads an exported data set, and makes its environment again."""

from __future__ import annotations

import minari
import numpy as np
import pytest

from taskbuilder import load_dataset

NAME = "taskbuilder/handover/expert-v0"


@pytest.fixture(scope="module")
def exported(export):
    return export("minari")


@pytest.fixture
def loaded(exported, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(exported))
    return minari.load_dataset(NAME)


def test_it_is_listed_with_what_it_says_of_itself(loaded):
    listed = minari.list_local_datasets(compatible_minari_version=True)
    assert list(listed) == [NAME]
    assert listed[NAME]["algorithm_name"] == "expert"
    assert loaded.spec.env_spec.id == "taskbuilder/Handover-v1"


def test_numbers_and_pictures_are_those_that_were_recorded(recorded, loaded):
    episodes = load_dataset(recorded)
    assert loaded.total_episodes == len(episodes)
    assert loaded.total_steps == sum(episode.steps for episode in episodes)
    for read, episode in zip(loaded, episodes, strict=True):
        seen = np.concatenate(list(episode.observations.values()), axis=1)
        np.testing.assert_array_equal(read.observations["agent_pos"], seen)
        moved = np.concatenate(list(episode.actions.values()), axis=1)
        np.testing.assert_array_equal(read.actions, moved)
        np.testing.assert_array_equal(read.rewards, episode.team_reward)
        for camera in ("front", "left_wrist"):
            shown = read.observations["pixels"][camera]
            np.testing.assert_array_equal(shown, episode.images(camera))
        assert loaded.observation_space["agent_pos"].contains(read.observations["agent_pos"][0])
        assert loaded.action_space.contains(read.actions[0])
        assert read.truncations.tolist() == [False] * (episode.steps - 1) + [True]
        assert read.infos["succeeded"][-1]
    told = list(loaded.storage.get_episode_metadata(loaded.episode_indices))
    assert [each["seed"] for each in told] == [episode.seed for episode in episodes]
    assert [each["instruction"] for each in told] == [episode.instruction for episode in episodes]
    assert all(each["success"] for each in told)


def test_the_environment_gives_what_was_recorded(loaded):
    read, told = loaded[1], next(iter(loaded.storage.get_episode_metadata([1])))
    env = loaded.recover_environment()
    seen, info = env.reset(seed=told["seed"])
    assert info["instruction"] == told["instruction"]
    assert env.action_space == loaded.action_space
    for row, action in enumerate(read.actions):
        np.testing.assert_array_equal(seen["agent_pos"], read.observations["agent_pos"][row])
        front = read.observations["pixels"]["front"][row]
        np.testing.assert_array_equal(seen["pixels"]["front"], front)
        seen, reward, terminated, truncated, info = env.step(action)
        assert reward == read.rewards[row]
        assert (terminated, truncated) == (read.terminations[row], read.truncations[row])
    assert info["succeeded"]
    env.close()


def test_episodes_are_filtered_sampled_and_split(loaded):
    won = loaded.filter_episodes(lambda episode: bool(episode.infos["succeeded"][-1]))
    assert len(won) == len(loaded)
    loaded.set_seed(0)
    (sampled,) = loaded.sample_episodes(1)
    assert len(sampled) == 50
    first, second = minari.split_dataset(loaded, [3, 1], seed=0)
    assert (len(first), len(second)) == (3, 1)
