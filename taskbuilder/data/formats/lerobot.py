"""LeRobot v3: Parquet tables, and MP4 videos or PNG pictures, with several episodes in a file.

A frame holds what was observed before a control step, and the action of that step. The state after
the last step is therefore in the data set itself alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.data.dataset import Dataset, RecordedEpisode
from taskbuilder.data.environment import carried_task
from taskbuilder.data.formats.lerobot_env import ENV_FILE, env_text
from taskbuilder.data.formats.lerobot_tables import (
    LANGUAGE,
    episode_table,
    frame_table,
    indexed_table,
    require_parquet,
    write_table,
)
from taskbuilder.data.formats.statistics import (
    LEAST_STD,
    Stats,
    combined,
    floored,
    image_stats,
    stats_of,
)
from taskbuilder.data.formats.subtasks import subtask_begins, subtask_labels, subtask_numbers
from taskbuilder.data.videos import VideoSize, joined, png
from taskbuilder.files import write_whole

DATA_MB, VIDEO_MB, CHUNK = 100, 200, 1000
"""Sizes at which a new file begins, and files in a folder."""

DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"

IMAGE_STATS_EVERY = 10
"""Statistics of pictures are of every tenth frame."""

LANGUAGE_PERSISTENT = "language_persistent"
"""The column in which LeRobot 0.6 and later look for sub-tasks."""

Features = dict[str, dict[str, Any]]


def write_lerobot(
    dataset: Dataset,
    folder: Path,
    *,
    pictures: bool = False,
    language: bool = True,
    warn: Callable[[str], None] = lambda _: None,
) -> None:
    """Write the episodes of one task as a LeRobot data set.

    Args:
        dataset: Episodes of one task.
        folder: An empty folder.
        pictures: Keep pictures as PNG in the tables instead of videos.
        language: Whether sub-tasks are written as language, too.
        warn: Called with what users should know about the export.

    Raises:
        UsageError: A package is not installed.
        StoreError: The data set is damaged.
        OSError: It cannot be written.
    """
    require_parquet()
    (task,) = dataset.about["tasks"].values()
    features = features_of(task, pictures=pictures, language=language)
    _Writer(dataset, folder, features, pictures=pictures, warn=warn).write()


def _idle_words(names: Sequence[str]) -> str:
    return (
        f"{', '.join(names)}: hardly varies in this data set; its standard deviation in "
        f"meta/stats.json is set to {LEAST_STD:g}, so that policies do not amplify noise"
    )


class _Writer:
    def __init__(
        self,
        dataset: Dataset,
        folder: Path,
        features: Features,
        *,
        pictures: bool,
        warn: Callable[[str], None],
    ) -> None:
        self._dataset, self._folder, self._pictures = dataset, folder, pictures
        self._warn = warn
        (name,) = dataset.about["tasks"]
        self._carried = carried_task(dataset.about, dataset.folder, name)
        (self._task,) = dataset.about["tasks"].values()
        self._features = features
        self._columns = {n: f for n, f in self._features.items() if f["dtype"] != "video"}
        self._texts: dict[str, int] = {}
        self._subtasks = subtask_labels(self._task)
        self._frames = 0
        self._data = _Files(DATA_MB)
        self._tables: list[Any] = []
        self._videos = {name: _Files(VIDEO_MB) for name in self._task["cameras"]}
        self._reels: dict[str, list[tuple[bytes, VideoSize]]] = {
            name: [] for name in self._task["cameras"]
        }

    def write(self) -> None:
        rows, every = [], []
        for number, episode in enumerate(self._dataset):
            row, stats = self._add(number, episode)
            every.append(stats)
            for feature, values in stats.items():
                row |= {f"stats/{feature}/{name}": value for name, value in values.items()}
            rows.append(row)
        self._flush_data()
        for camera in self._videos:
            self._flush_video(camera)
        meta = self._folder / "meta"
        write_table(meta / "episodes/chunk-000/file-000.parquet", [episode_table(rows)])
        write_table(meta / "tasks.parquet", [indexed_table([*self._texts], "task", "task_index")])
        subtasks = indexed_table(self._subtasks, "subtask", "subtask_index")
        write_table(meta / "subtasks.parquet", [subtasks])
        total = {name: combined([stats[name] for stats in every]) for name in every[0]}
        for feature in ("observation.state", "action"):
            total[feature], idle = floored(total[feature])
            if idle:
                self._warn(_idle_words([self._features[feature]["names"][n] for n in idle]))
        self._write_json("stats.json", {n: _listed(stats) for n, stats in total.items()})
        self._write_json("info.json", self._info())
        write_whole(self._folder / ENV_FILE, env_text(self._dataset.about, self._carried).encode())

    def _write_json(self, name: str, data: Any) -> None:
        write_whole(self._folder / "meta" / name, (json.dumps(data, indent=4) + "\n").encode())

    def _info(self) -> dict[str, Any]:
        count, videos = len(self._dataset), self._videos and not self._pictures
        return {
            "codebase_version": "v3.0",
            "robot_type": "_".join(r["model"] for r in self._task["robots"].values()),
            "total_episodes": count,
            "total_frames": self._frames,
            "total_tasks": len(self._texts),
            "chunks_size": CHUNK,
            "data_files_size_in_mb": DATA_MB,
            "video_files_size_in_mb": VIDEO_MB,
            "fps": self._task["control_hz"],
            "splits": {"train": f"0:{count}"},
            "data_path": DATA_PATH,
            "video_path": VIDEO_PATH if videos else None,
            "features": self._features,
        }

    def _add(
        self, number: int, episode: RecordedEpisode
    ) -> tuple[dict[str, Any], dict[str, Stats]]:
        """Add an episode; returns its row and its statistics."""
        steps = episode.steps
        text = self._texts.setdefault(episode.instruction, len(self._texts))
        indices = np.arange(steps)
        columns = {
            **numbers_of(episode),
            "subtask_index": subtask_numbers(episode, self._subtasks),
            "timestamp": (indices / self._task["control_hz"]).astype(np.float32),
            "frame_index": indices,
            "episode_index": np.full(steps, number),
            "index": self._frames + indices,
            "task_index": np.full(steps, text),
        }
        stats = {name: stats_of(_rows(values)) for name, values in columns.items()}
        if LANGUAGE_PERSISTENT in self._columns:
            rows = language_of(episode, columns["timestamp"])
            columns[LANGUAGE_PERSISTENT] = [rows] * steps
        row: dict[str, Any] = {
            "episode_index": number,
            "tasks": [episode.instruction],
            "length": steps,
        }
        for camera in self._videos:
            key = camera_key(camera)
            columns[key] = []
            stats[key] = image_stats(self._sampled(episode, camera, columns[key]))
            if not self._pictures:
                row |= self._add_video(camera, episode, steps)
        table = frame_table(self._columns, columns)
        if self._data.is_full(table.nbytes):
            self._flush_data()
        self._tables.append(table)
        row |= {f"data/{name}": value for name, value in self._data.add(table.nbytes).items()}
        row |= {"dataset_from_index": self._frames, "dataset_to_index": self._frames + steps}
        row |= {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        self._frames += steps
        return row, stats

    def _sampled(
        self, episode: RecordedEpisode, camera: str, files: list[bytes]
    ) -> Iterator[NDArray[np.uint8]]:
        """Every tenth image of an episode but the last; each becomes a PNG file where asked."""
        for number, image in enumerate(episode.each_image(camera)):
            if number == episode.steps:
                continue  # the images are decoded to the end, which checks the rest of the video
            if self._pictures:
                files.append(png(image))
            if number % IMAGE_STATS_EVERY == 0:
                yield image

    def _add_video(self, camera: str, episode: RecordedEpisode, steps: int) -> dict[str, Any]:
        content = episode.video(camera)
        files, fps = self._videos[camera], self._task["control_hz"]
        if files.is_full(len(content)):
            self._flush_video(camera)
        begin = files.frames
        place = files.add(len(content), steps)
        self._reels[camera].append((content, episode.video_size(camera)))
        spans = {"from_timestamp": begin / fps, "to_timestamp": (begin + steps) / fps}
        key = f"videos/{camera_key(camera)}"
        return {f"{key}/{name}": value for name, value in {**place, **spans}.items()}

    def _flush_data(self) -> None:
        write_table(self._folder / DATA_PATH.format(**self._data.place), self._tables)
        self._tables.clear()
        self._data.next()

    def _flush_video(self, camera: str) -> None:
        if not self._reels[camera]:
            return
        place = self._videos[camera].place
        path = self._folder / VIDEO_PATH.format(video_key=camera_key(camera), **place)
        path.parent.mkdir(parents=True, exist_ok=True)
        content = joined(self._reels[camera], self._task["control_hz"], without_last=True)
        write_whole(path, content)
        self._reels[camera].clear()
        self._videos[camera].next()


class _Files:
    """Which file of a kind episodes go to.

    Attributes:
        frames: Frames of the current file so far.
    """

    def __init__(self, most_mb: int) -> None:
        self._most = most_mb << 20
        self._number = self._bytes = self.frames = 0

    @property
    def place(self) -> dict[str, int]:
        return {"chunk_index": self._number // CHUNK, "file_index": self._number % CHUNK}

    def is_full(self, size: int) -> bool:
        return self._bytes > 0 and self._bytes + size > self._most

    def add(self, size: int, frames: int = 0) -> dict[str, int]:
        self._bytes += size
        self.frames += frames
        return self.place

    def next(self) -> None:
        self._number += 1
        self._bytes = self.frames = 0


# --- what there is


def camera_key(camera: str) -> str:
    """The feature of a camera."""
    return f"observation.images.{camera}"


def features_of(
    task: Mapping[str, Any], *, pictures: bool = False, language: bool = True
) -> Features:
    """The features of a task, in the order of the columns.

    Policies of LeRobot take what begins with ``observation`` or ``action``. Everything else is
    for other uses: each robot's own numbers, the state for critics, joint targets, terms.

    Args:
        task: What the data set says of the task.
        pictures: Keep pictures as PNG instead of videos.
        language: Whether sub-tasks are written as language, too.
    """
    robots: Mapping[str, Any] = task["robots"]
    state = [name for agent in robots for name in joint_state_names(task, agent)]
    action = [name for robot in robots.values() for name in robot["action_names"]]
    features: Features = {
        "observation.state": _vector(state),
        "action": _vector(action),
        "joint_target": _vector(state),
        "state": _vector(task["state_names"]),
    }
    for agent, robot in robots.items():
        features[f"{agent}.observation"] = _vector(robot["observation_names"])
        features[f"{agent}.action"] = _vector(robot["action_names"])
        features[f"{agent}.reward"] = _scalar("float32")
    features |= {f"reward.{_key(label)}": _scalar("float32") for label in task["terms"]}
    features |= {"next.reward": _scalar("float32")}
    features |= {"next.done": _scalar("bool"), "next.success": _scalar("bool")}
    for camera, about in task["cameras"].items():
        features[camera_key(camera)] = _camera(about, task["control_hz"], pictures=pictures)
    features["subtask_index"] = _scalar("int64")
    features["timestamp"] = _scalar("float32")
    for name in ("frame_index", "episode_index", "index", "task_index"):
        features[name] = _scalar("int64")
    if language and task["expert"]:
        features[LANGUAGE_PERSISTENT] = _scalar(LANGUAGE)
    return features


def _key(label: str) -> str:
    return label.replace("/", ".")  # LeRobot allows no slash in the name of a feature


def joint_state_names(task: Mapping[str, Any], agent: str) -> list[str]:
    """Names of a robot's joint positions and its gripper: ``left.joint_1``, ..."""
    return [*task["robots"][agent]["joint_names"], f"{agent}.gripper"]


def _vector(names: Sequence[str]) -> dict[str, Any]:
    return {"dtype": "float32", "shape": [len(names)], "names": list(names)}


def _scalar(dtype: str) -> dict[str, Any]:
    return {"dtype": dtype, "shape": [1], "names": None}


def _camera(about: Mapping[str, Any], fps: int, *, pictures: bool) -> dict[str, Any]:
    height, width = about["height"], about["width"]
    names = ["height", "width", "channels"]
    feature = {"dtype": "image", "shape": [height, width, 3], "names": names}
    if pictures:
        return feature
    info = {
        "video.height": height,
        "video.width": width,
        "video.codec": "h264",
        "video.pix_fmt": "gbrp",
        "video.is_depth_map": False,
        "video.fps": fps,
        "video.channels": 3,
        "has_audio": False,
    }
    return {**feature, "dtype": "video", "info": info}


def numbers_of(episode: RecordedEpisode) -> dict[str, Any]:
    """The numbers of an episode by feature: (steps,) or (steps, numbers)."""
    steps, agents, arrays = episode.steps, episode.agents, episode.arrays

    def joint(positions: str, gripper: str) -> Any:
        parts = [
            part
            for agent in agents
            for part in (
                arrays[f"agents/{agent}/{positions}"][:steps],
                arrays[f"agents/{agent}/{gripper}"][:steps, None],
            )
        ]
        return np.concatenate(parts, axis=1)

    done = np.zeros(steps, dtype=np.bool_)
    done[-1:] = True
    return {
        "observation.state": joint("joint_position", "gripper"),
        "action": np.concatenate(list(episode.actions.values()), axis=1),
        "joint_target": joint("joint_target", "gripper_target"),
        "state": episode.state[:steps],
        **{f"{a}.observation": seen[:steps] for a, seen in episode.observations.items()},
        **{f"{a}.action": action for a, action in episode.actions.items()},
        **{f"{a}.reward": reward for a, reward in episode.rewards.items()},
        **{
            f"reward.{_key(name.removeprefix('terms/'))}": values
            for name, values in arrays.items()
            if name.startswith("terms/")
        },
        "next.reward": episode.team_reward,
        "next.done": done,
        "next.success": arrays["success"][1:],
    }


def language_of(episode: RecordedEpisode, timestamps: Any) -> list[dict[str, Any]]:
    """The sub-tasks of an episode, each from the frame in which it begins to the next one."""
    row = {"role": "assistant", "style": "subtask", "camera": None, "tool_calls": None}
    return [
        {**row, "content": label, "timestamp": timestamps[step]}
        for step, label in subtask_begins(episode)
    ]


def _rows(values: Any) -> Any:
    return values[:, None] if values.ndim == 1 else values


def _listed(stats: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value.tolist() for name, value in stats.items()}
