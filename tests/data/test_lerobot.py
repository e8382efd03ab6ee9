"""The format of LeRobot v3, read by PyArrow and PyAV as the library itself reads it."""

from __future__ import annotations

import importlib.util
import io
import json
import sys
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import ExportOptions, export_dataset, lerobot
from taskbuilder.data.formats.statistics import LEAST_STD, combined, stats_of
from taskbuilder.data.plan import CollectPlan
from taskbuilder.errors import UsageError
from taskbuilder.policies.mixture import read_share

pytestmark = pytest.mark.filterwarnings("ignore:.*hardly varies")

CAMERAS = ("front", "left_wrist")


@pytest.fixture(scope="module")
def exported(pictured: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("lerobot") / "out"
    return export_dataset(load_dataset(pictured), "lerobot", out)


def info_of(folder):
    return json.loads((folder / "meta/info.json").read_text())


def frames_of(folder):
    files = sorted(folder.glob("data/*/*.parquet"))
    tables = [pq.read_table(file) for file in files]
    return {
        name: np.concatenate([column(table, name) for table in tables])
        for name in tables[0].schema.names
    }


def column(table, name):
    return np.array(table[name].to_pylist())


def episodes_of(folder):
    return pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()


def video_of(folder, row, camera):
    key = f"observation.images.{camera}"
    place = {name: row[f"videos/{key}/{name}"] for name in ("chunk_index", "file_index")}
    with av.open(
        str(folder / info_of(folder)["video_path"].format(video_key=key, **place))
    ) as file:
        return [
            (float(f.pts * f.time_base), f.to_ndarray(format="rgb24")) for f in file.decode(video=0)
        ]


# --- numbers


def test_every_number_is_that_of_the_episode(exported, pictured):
    frames, rows = frames_of(exported), episodes_of(exported)
    for row, episode in zip(rows, load_dataset(pictured), strict=True):
        span = slice(row["dataset_from_index"], row["dataset_to_index"])
        steps = episode.steps
        assert row["length"] == steps == span.stop - span.start
        assert row["tasks"] == [episode.instruction]
        arrays = episode.arrays
        state = [
            part
            for agent in ("left", "right")
            for part in (
                arrays[f"agents/{agent}/joint_position"][:steps],
                arrays[f"agents/{agent}/gripper"][:steps, None],
            )
        ]
        expected = {
            "observation.state": np.concatenate(state, axis=1),
            "action": np.concatenate(list(episode.actions.values()), axis=1),
            "state": episode.state[:steps],
            "left.observation": episode.observations["left"][:steps],
            "right.action": episode.actions["right"],
            "right.reward": episode.rewards["right"],
            "reward.grasp.left": arrays["terms/grasp/left"],
            "next.reward": episode.team_reward,
        }
        for name, values in expected.items():
            assert np.array_equal(frames[name][span], values.astype(np.float32)), name
        assert frames["next.success"][span].tolist() == arrays["success"][1:].tolist()
        assert frames["next.done"][span].tolist() == [False] * (steps - 1) + [True]
        assert frames["frame_index"][span].tolist() == list(range(steps))
        assert np.allclose(frames["timestamp"][span], np.arange(steps) / 10, atol=1e-6)
        assert set(frames["episode_index"][span]) == {row["episode_index"]}
    assert frames["index"].tolist() == list(range(len(frames["index"])))


def test_its_environment_is_that_of_the_data_set(exported, pictured):
    """The recorded actions lead to the recorded states and pictures, as LeRobot's policies see."""
    spec = importlib.util.spec_from_file_location("exported_env", exported / "env.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    episode = load_dataset(pictured)[1]
    recorded = lerobot.numbers_of(episode)
    states = recorded["observation.state"].astype(np.float32)
    ((env,),) = (suite.values() for suite in module.make_env(n_envs=1).values())
    with closing(env):
        seen, _ = env.reset(seed=[episode.seed])
        assert env.call("task_description") == (episode.instruction,)
        for row, action in enumerate(recorded["action"]):
            np.testing.assert_array_equal(seen["agent_pos"][0], states[row])
            seen, _, _, truncated, info = env.step(action[None])
        assert truncated.all()
        assert info["final_info"]["is_success"].tolist() == [True]
    assert list(seen["pixels"]) == list(CAMERAS)
    picture = info["final_obs"][0]["pixels"]["front"].astype(float)
    assert np.array_equal(picture, episode.images("front")[-1])


def test_every_column_is_a_feature_of_its_type_and_shape(exported):
    info = info_of(exported)
    schema = pq.read_schema(exported / "data/chunk-000/file-000.parquet")
    stored = {n: f for n, f in info["features"].items() if f["dtype"] != "video"}
    assert schema.names == list(stored)
    told = json.loads(schema.metadata[b"huggingface"])["info"]["features"]
    assert list(told) == list(stored)
    kinds = {"float32": "float", "int64": "int64", "bool": "bool"}
    assert stored.pop("language_persistent")["dtype"] == "language"
    for name, feature in stored.items():
        (size,) = feature["shape"]
        kind = kinds[feature["dtype"]]
        expected = kind if size == 1 else f"fixed_size_list<element: {kind}>[{size}]"
        assert str(schema.field(name).type) == expected
        assert feature["names"] is None or len(feature["names"]) == size
    assert info["features"]["observation.state"]["names"][:3] == [
        *("left.joint_1", "left.joint_2", "left.joint_3")
    ]
    assert info["features"]["action"]["names"][5] == "right.dx"


def test_the_info_adds_up(exported, pictured):
    info, rows = info_of(exported), episodes_of(exported)
    assert info["codebase_version"] == "v3.0"
    assert info["fps"] == 10
    assert info["total_episodes"] == len(rows) == 3
    assert info["total_frames"] == sum(row["length"] for row in rows)
    assert info["splits"] == {"train": "0:3"}
    assert info["robot_type"] == "ur5e_ur5e"
    assert not any("/" in name for name in info["features"])
    for camera in CAMERAS:
        feature = info["features"][f"observation.images.{camera}"]
        assert (feature["dtype"], feature["shape"]) == ("video", [32, 48, 3])


def texts_of(file, index, number):
    """A table as pandas would read it: its index comes from the metadata."""
    table = pq.read_table(file)
    pandas = json.loads(table.schema.metadata[b"pandas"])
    assert pandas["index_columns"] == [index]
    return dict(zip(table[number].to_pylist(), table[index].to_pylist(), strict=True))


def test_tasks_and_subtasks_are_labelled(exported, pictured):
    tasks = texts_of(exported / "meta/tasks.parquet", "task", "task_index")
    parts = texts_of(exported / "meta/subtasks.parquet", "subtask", "subtask_index")
    assert info_of(exported)["total_tasks"] == len(tasks)
    frames = frames_of(exported)
    start = 0
    for episode in load_dataset(pictured):
        rows = range(start, start + episode.steps)
        assert {tasks[frames["task_index"][row]] for row in rows} == {episode.instruction}
        for part in episode.subtasks:
            for step in range(part["from_step"], part["to_step"]):
                assert parts[frames["subtask_index"][start + step]] == part["label"]
        start += episode.steps
    assert parts[0] == "none"
    assert "done" in parts.values()


def test_every_frame_has_the_sub_tasks_of_its_episode_as_language(exported, pictured):
    """Each is active from its timestamp to that of the next one, as LeRobot resolves it."""
    frames = pq.read_table(exported / "data/chunk-000/file-000.parquet").to_pylist()
    start = 0
    for episode in load_dataset(pictured):
        own = frames[start : start + episode.steps]
        start += episode.steps
        rows = own[0]["language_persistent"]
        assert all(frame["language_persistent"] == rows for frame in own)
        told = [(row["content"], row["timestamp"]) for row in rows]
        begins = [own[part["from_step"]]["timestamp"] for part in episode.subtasks]
        labels = [part["label"] for part in episode.subtasks]
        assert told == list(zip(labels, begins, strict=True))
        assert {(row["role"], row["style"]) for row in rows} == {("assistant", "subtask")}
        assert {(row["camera"], row["tool_calls"]) for row in rows} == {(None, None)}


def test_a_sub_task_that_is_given_up_ends_as_none():
    label = {"stage": 1, "label": "arm: grasp cube"}
    given_up = SimpleNamespace(
        subtasks=[label], arrays={"subtask": np.array([1, 1, 1, 0, 0], dtype=np.int64)}
    )
    rows = lerobot.language_of(given_up, np.arange(5) / 10)
    assert [(row["content"], row["timestamp"]) for row in rows] == [
        ("arm: grasp cube", 0.0),
        ("none", pytest.approx(0.3)),
    ]
    nobody = SimpleNamespace(subtasks=[], arrays={"subtask": np.zeros(5, dtype=np.int64)})
    assert lerobot.language_of(nobody, np.arange(5) / 10) == []


def test_without_an_expert_there_is_no_column_of_language(good, tmp_path):
    plan = CollectPlan((str(good),), 1, policies=(read_share("random"),), keep_failures=True)
    collect(plan, tmp_path / "data")
    out = export_dataset(load_dataset(tmp_path / "data"), "lerobot", tmp_path / "out")
    assert "language_persistent" not in info_of(out)["features"]


def test_language_is_left_out_for_earlier_versions(pictured, tmp_path):
    out = export_dataset(
        load_dataset(pictured), "lerobot", tmp_path / "out", ExportOptions(language=False)
    )
    assert "language_persistent" not in info_of(out)["features"]
    assert "language_persistent" not in frames_of(out)
    assert "subtask_index" in frames_of(out)


# --- pictures


@pytest.mark.parametrize("camera", CAMERAS)
def test_videos_have_a_frame_for_every_step_at_its_time(camera, exported, pictured):
    for row, episode in zip(episodes_of(exported), load_dataset(pictured), strict=True):
        key = f"videos/observation.images.{camera}"
        begin, end = row[f"{key}/from_timestamp"], row[f"{key}/to_timestamp"]
        shown = [
            (t, image) for t, image in video_of(exported, row, camera) if begin <= t + 1e-6 < end
        ]
        assert len(shown) == episode.steps
        times = np.array([t for t, _ in shown]) - begin
        assert np.abs(times - np.arange(episode.steps) / 10).max() < 1e-4  # LeRobot's tolerance
        assert np.array_equal([image for _, image in shown], episode.images(camera)[:-1])


def test_a_frame_is_found_by_its_timestamp(exported, pictured):
    row = episodes_of(exported)[1]
    key = "videos/observation.images.front"
    path = exported / "videos/observation.images.front/chunk-000/file-000.mp4"
    wanted = row[f"{key}/from_timestamp"] + 3.7
    with av.open(str(path)) as file:
        stream = file.streams.video[0]
        file.seek(int(wanted / stream.time_base), stream=stream)
        found = next(f for f in file.decode(stream) if float(f.pts * f.time_base) > wanted - 1e-4)
    image = load_dataset(pictured)[1].images("front")[37]
    assert np.array_equal(found.to_ndarray(format="rgb24"), image)


def test_pictures_instead_of_videos(pictured, tmp_path):
    out = export_dataset(load_dataset(pictured), "lerobot", tmp_path / "out", ExportOptions(True))
    assert info_of(out)["video_path"] is None
    assert info_of(out)["features"]["observation.images.front"]["dtype"] == "image"
    assert not (out / "videos").exists()
    table = pq.read_table(out / "data/chunk-000/file-000.parquet")
    cell = table["observation.images.left_wrist"][60].as_py()
    assert cell["path"] is None
    image = np.asarray(Image.open(io.BytesIO(cell["bytes"])))
    assert np.array_equal(image, load_dataset(pictured)[1].images("left_wrist")[10])


def test_large_data_sets_have_several_files(pictured, tmp_path, monkeypatch):
    monkeypatch.setattr(lerobot, "DATA_MB", 0)
    monkeypatch.setattr(lerobot, "VIDEO_MB", 0)
    monkeypatch.setattr(lerobot, "CHUNK", 2)
    out = export_dataset(load_dataset(pictured), "lerobot", tmp_path / "out")
    names = [f"chunk-00{chunk}/file-00{file}" for chunk, file in ((0, 0), (0, 1), (1, 0))]
    found = sorted(str(file.relative_to(out / "data")) for file in out.glob("data/*/*"))
    assert found == [f"{name}.parquet" for name in names]
    for number, row in enumerate(episodes_of(out)):
        assert (row["data/chunk_index"], row["data/file_index"]) == divmod(number, 2)
        assert row["videos/observation.images.front/from_timestamp"] == 0.0
        assert len(video_of(out, row, "front")) == row["length"]
    assert frames_of(out)["index"].tolist() == list(range(150))


# --- statistics


def test_statistics_are_those_of_the_numbers(exported):
    stats = json.loads((exported / "meta/stats.json").read_text())
    frames = frames_of(exported)
    for name in ("action", "observation.state", "next.reward"):
        values = frames[name].reshape(len(frames["index"]), -1).astype(np.float64)
        assert np.allclose(stats[name]["mean"], values.mean(axis=0))
        least = 0.0 if name == "next.reward" else LEAST_STD
        assert np.allclose(stats[name]["std"], np.maximum(values.std(axis=0), least))
        assert np.allclose(stats[name]["min"], values.min(axis=0))
        assert np.allclose(stats[name]["max"], values.max(axis=0))
        assert stats[name]["count"] == [150]
        assert set(stats[name]) == {
            *("min", "max", "mean", "std", "count"),
            *("q01", "q10", "q50", "q90", "q99"),
        }
    picture = stats["observation.images.front"]
    assert np.shape(picture["mean"]) == (3, 1, 1)
    assert 0.0 <= np.min(picture["min"]) < np.max(picture["max"]) <= 1.0
    row = episodes_of(exported)[0]
    assert np.shape(row["stats/observation.images.front/mean"]) == (3, 1, 1)
    assert len(row["stats/action/q50"]) == 10


def test_statistics_of_parts_add_up():
    values = np.random.default_rng(0).normal(size=(100, 3))
    whole, parts = stats_of(values), combined([stats_of(values[:30]), stats_of(values[30:])])
    for name in ("min", "max", "mean", "std", "count"):
        assert np.allclose(whole[name], parts[name])


def test_without_pyarrow_it_is_said_what_to_install(pictured, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(UsageError, match=r'pip install "taskbuilder\[data\]"'):
        export_dataset(load_dataset(pictured), "lerobot", tmp_path / "out")
    assert not (tmp_path / "out").exists()
