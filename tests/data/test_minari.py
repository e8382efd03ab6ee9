"""The format of Minari, read by h5py and made by Gymnasium as the library itself does."""

from __future__ import annotations

import json
import sys
from contextlib import closing
from pathlib import Path

import gymnasium
import h5py
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import ExportOptions, export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.errors import UsageError
from taskbuilder.policies.mixture import read_share

pytestmark = pytest.mark.filterwarnings("ignore:depth images are left out")


@pytest.fixture(scope="module")
def exported(pictured: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The data of three episodes of handover with two cameras, in a folder that Minari looks in."""
    out = tmp_path_factory.mktemp("minari") / "out"
    export_dataset(load_dataset(pictured), "minari", out)
    return out / "taskbuilder" / "handover" / "mixed-v0" / "data"


def about(folder):
    return json.loads((folder / "metadata.json").read_text())


def made_again(folder, **options):
    """The environment, as Minari makes it again."""
    return gymnasium.make(EnvSpec.from_json(about(folder)["env_spec"]), **options)


def test_every_number_is_that_of_the_episode(exported, pictured):
    with h5py.File(exported / "main_data.hdf5") as file:
        episodes = load_dataset(pictured)
        assert list(file) == ["episode_0", "episode_1", "episode_2"]
        for number, episode in enumerate(episodes):
            group = file[f"episode_{number}"]
            steps = episode.steps
            told = {key: group.attrs[key] for key in ("id", "seed", "success", "total_steps")}
            assert told == {"id": number, "seed": episode.seed, "success": True, "total_steps": 50}
            assert group.attrs["instruction"] == episode.instruction
            assert group.attrs["policy"] == episode.policy
            joined = np.concatenate(list(episode.observations.values()), axis=1)
            assert np.array_equal(group["observations/agent_pos"][()], joined)
            joined = np.concatenate(list(episode.actions.values()), axis=1)
            assert np.array_equal(group["actions"][()], joined)
            assert np.array_equal(group["rewards"][()], episode.team_reward)
            assert not group["terminations"][()].any()
            assert group["truncations"][()].tolist() == [False] * (steps - 1) + [True]
            for camera in episode.cameras:
                shown = group[f"observations/pixels/{camera}"][()]
                assert np.array_equal(shown, episode.images(camera))
            infos = group["infos"]
            assert {len(rows) for rows in infos.values()} == {steps + 1}
            assert np.array_equal(infos["state"][()], episode.state)
            own = episode.rewards["left"]
            assert np.array_equal(infos["local_reward.left"][()], [0.0, *own])
            labels = about(exported)["taskbuilder"]["subtasks"]
            played = [labels[n] for n in dict.fromkeys(infos["subtask"][1:].tolist())]
            assert played == [part["label"] for part in episode.subtasks]


def test_the_metadata_says_whose_the_columns_are(exported, pictured):
    told, task = about(exported), load_dataset(pictured).about["tasks"]["handover"]
    assert (told["total_episodes"], told["total_steps"]) == (3, 150)
    assert told["dataset_id"] == "taskbuilder/handover/mixed-v0"
    assert told["algorithm_name"] == "expert, noisy:0.05"
    assert "author" not in told
    own = told["taskbuilder"]
    begin, end = own["agents"]["right"]["action"]
    assert own["action_names"][begin:end] == task["robots"]["right"]["action_names"]
    begin, end = own["agents"]["right"]["observation"]
    names = [f"right/{name}" for name in task["robots"]["right"]["observation_names"]]
    assert own["observation_names"][begin:end] == names
    space = json.loads(told["observation_space"])["subspaces"]
    assert space["agent_pos"]["shape"] == [len(own["observation_names"])]
    assert space["pixels"]["subspaces"]["front"]["shape"] == [32, 48, 3]


def test_the_environment_that_is_made_again_gives_what_was_recorded(exported, pictured):
    episode = load_dataset(pictured)[1]
    with closing(made_again(exported)) as env, h5py.File(exported / "main_data.hdf5") as file:
        assert env.spec.id == "taskbuilder/Handover-v1"
        group = file["episode_1"]
        seen, info = env.reset(seed=int(group.attrs["seed"]))
        assert info["instruction"] == episode.instruction
        for row, action in enumerate(group["actions"][()]):
            _same(group, row, seen, info)
            seen, reward, terminated, truncated, info = env.step(action)
            assert reward == group["rewards"][row] == info["team_reward"]
            assert terminated == group["terminations"][row]
            assert truncated == group["truncations"][row]
            terms = {key: value for key, value in info.items() if key.startswith("reward/")}
            assert terms
            for key, value in terms.items():
                assert value == group[f"infos/{key.replace('/', '.')}"][row + 1]
        _same(group, episode.steps, seen, info)


def _same(group, row, seen, info):
    """What the environment gives is a row of an episode."""
    assert np.array_equal(seen["agent_pos"], group["observations/agent_pos"][row])
    for camera, image in seen["pixels"].items():
        assert np.array_equal(image, group[f"observations/pixels/{camera}"][row])
    for key in ("succeeded", "stage", "progress"):
        assert info[key] == group[f"infos/{key}"][row]
    for key, value in info.items():
        if key.startswith("condition/"):
            assert value == group[f"infos/{key.replace('/', '.')}"][row]


def test_without_cameras_an_observation_is_one_array(mixed, tmp_path):
    out = export_dataset(load_dataset(mixed), "minari", tmp_path / "out")
    folder = out / "reach" / "taskbuilder" / "reach" / "mixed-v0" / "data"
    spec = json.loads(about(folder)["env_spec"])
    assert spec["kwargs"] == {"task": "reach", "variation": "random"}
    with (
        h5py.File(folder / "main_data.hdf5") as file,
        closing(made_again(folder, variation=0)) as env,
    ):
        seen, _ = env.reset(seed=int(file["episode_0"].attrs["seed"]))
        assert file["episode_0"].attrs["variation"] == 0
        assert np.array_equal(seen, file["episode_0/observations"][0])
        assert env.action_space.shape == file["episode_0/actions"].shape[1:]


def test_options_of_the_environment_are_kept_and_a_cut_recording_is_truncated(tmp_path):
    options = {"horizon": 40, "rotation": "matrix", "disturbances": {"mass": 0.5}}
    plan = CollectPlan(("pick_place",), 1, options=options, until_success=0)
    collect(plan, tmp_path / "data")
    out = export_dataset(load_dataset(tmp_path / "data"), "minari", tmp_path / "out")
    folder = out / "taskbuilder" / "pick_place" / "expert-v0" / "data"
    with h5py.File(folder / "main_data.hdf5") as file, closing(made_again(folder)) as env:
        group = file["episode_0"]
        assert env.spec.max_episode_steps == 40 > len(group["actions"])
        assert group["truncations"][-1]
        assert not group["terminations"][-1]
        seen, _ = env.reset(seed=int(group.attrs["seed"]))
        for row, action in enumerate(group["actions"][()]):
            assert np.array_equal(seen, group["observations"][row])
            seen, *_ = env.step(action)
        assert np.array_equal(seen, group["observations"][-1])


def test_of_a_task_of_ones_own_it_is_said_how_to_make_its_environment(good, tmp_path):
    plan = CollectPlan((str(good),), 1, policies=(read_share("random"),), keep_failures=True)
    collect(plan, tmp_path / "data")
    told: list[str] = []
    options = ExportOptions(warn=told.append)
    out = export_dataset(load_dataset(tmp_path / "data"), "minari", tmp_path / "out", options)
    (line,) = told
    assert 'recover_environment(task="PATH/good.yaml")' in line
    with closing(made_again(next(out.rglob("data")), task=str(good))) as env:
        assert env.spec.id == "taskbuilder/Task-v0"


def test_without_h5py_it_is_said_what_to_install(pictured, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(UsageError, match=r'pip install "taskbuilder\[data\]"'):
        export_dataset(load_dataset(pictured), "minari", tmp_path / "out")
