"""The format of robomimic, read by h5py as the library itself reads it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import export_dataset
from taskbuilder.errors import UsageError


@pytest.fixture(scope="module")
def exported(pictured: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("robomimic") / "out"
    return export_dataset(load_dataset(pictured), "robomimic", out) / "handover.hdf5"


def test_every_number_is_that_of_the_episode(exported, pictured):
    with h5py.File(exported) as file:
        data = file["data"]
        assert data.attrs["total"] == 150
        for number, episode in enumerate(load_dataset(pictured)):
            demo = data[f"demo_{number}"]
            steps = episode.steps
            assert demo.attrs["num_samples"] == steps
            joined = np.concatenate(list(episode.actions.values()), axis=1)
            assert np.array_equal(demo["actions"][()], joined)
            assert np.array_equal(demo["rewards"][()], episode.team_reward)
            assert np.array_equal(demo["states"][()], episode.state[:-1])
            assert demo["dones"][()].tolist() == [0] * (steps - 1) + [1]
            own = episode.observations["left"]
            assert np.array_equal(demo["obs/left_observation"][()], own[:-1])
            assert np.array_equal(demo["next_obs/left_observation"][()], own[1:])
            position = episode.of_agents("joint_position")["right"]
            assert np.array_equal(demo["obs/right_joint_position"][()], position[:-1])
            assert demo["obs/joints"].shape == (steps, 14)
            images = episode.images("front")
            assert np.array_equal(demo["obs/front_image"][()], images[:-1])
            assert np.array_equal(demo["next_obs/front_image"][-1], images[-1])
            assert demo["obs/front_image"].dtype == np.uint8
            depth = episode.depth("left_wrist")[:-1, :, :, None]
            assert np.array_equal(demo["obs/left_wrist_depth"][()], depth)
            reward = episode.rewards["left"]
            assert np.array_equal(demo["agents/left/reward"][()], reward)
            assert json.loads(demo.attrs["subtasks"]) == list(episode.subtasks)


def test_what_the_loader_asks_for_is_there(exported):
    with h5py.File(exported) as file:
        args = json.loads(file["data"].attrs["env_args"])
        assert (args["env_name"], args["env_kwargs"]["task"]) == ("handover", "handover")
        assert isinstance(args["env_type"], int)
        keys = {key: set(file[f"data/{key}/obs"]) for key in file["data"]}
        assert len({frozenset(found) for found in keys.values()}) == 1
        for demo in file["data"].values():
            rows = demo.attrs["num_samples"]
            assert {len(values) for values in demo["obs"].values()} == {rows}
            assert {values.ndim > 1 for values in demo["obs"].values()} == {True}
            assert set(demo["next_obs"]) == set(demo["obs"])
        masked = [name.decode() for part in ("train", "valid") for name in file["mask"][part]]
        assert masked == list(file["data"])


def test_every_tenth_episode_is_for_validation(pictured, tmp_path, monkeypatch):
    monkeypatch.setattr("taskbuilder.data.formats.robomimic.VALID_EVERY", 2)
    out = export_dataset(load_dataset(pictured), "robomimic", tmp_path / "out")
    with h5py.File(out / "handover.hdf5") as file:
        masks = {part: [n.decode() for n in names] for part, names in file["mask"].items()}
    assert masks == {"train": ["demo_0", "demo_2"], "valid": ["demo_1"]}


def test_without_h5py_it_is_said_what_to_install(pictured, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(UsageError, match=r'pip install "taskbuilder\[data\]"'):
        export_dataset(load_dataset(pictured), "robomimic", tmp_path / "out")
