"""Minari: an HDF5 file of episodes as the joint environment gives them, and its metadata.

The folder is one that Minari looks for data sets in: ``taskbuilder/handover/expert-v0`` is in
``taskbuilder/handover/expert-v0/data``. One agent moves all robots, as in `JointEnv`, which is the
environment that Minari makes again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec

from taskbuilder.data.dataset import Dataset, RecordedEpisode
from taskbuilder.data.environment import played_options
from taskbuilder.data.formats.subtasks import subtask_labels, subtask_numbers
from taskbuilder.env.gym_names import JOINT_ENV, JOINT_VECTOR_ENV, gym_name
from taskbuilder.env.joint_observation import AGENT_POS, PIXELS
from taskbuilder.extras import extra_needed
from taskbuilder.files import write_whole

MINARI_VERSION = "0.5.4"
"""Of the format; later versions of Minari read it, too."""

_FILE = "main_data.hdf5"
_OF_PICTURES = ("cameras", "camera_size", "renderer")


def write_minari(
    dataset: Dataset, folder: Path, *, warn: Callable[[str], None] = lambda _: None
) -> None:
    """Write the episodes of one task as a Minari data set.

    Args:
        dataset: Episodes of one task.
        folder: An empty folder.
        warn: Called with what users should know about the export.

    Raises:
        UsageError: h5py is not installed.
        StoreError: The data set is damaged.
        OSError: It cannot be written.
    """
    with extra_needed("data", "the format minari"):
        import h5py
    ((name, task),) = dataset.about["tasks"].items()
    labels = subtask_labels(task)
    place = folder / dataset_id(name, dataset.contents) / "data"
    place.mkdir(parents=True)
    with h5py.File(place / _FILE, "w") as file:
        for number, episode in enumerate(dataset):
            _write_episode(file.create_group(f"episode_{number}"), number, episode, labels)
    about = _metadata(name, dataset)
    about["dataset_size"] = round((place / _FILE).stat().st_size / 1e6, 1)  # in MB
    write_whole(place / "metadata.json", (json.dumps(about, indent=1) + "\n").encode())
    if task.get("carried"):
        warn(
            f"{name} is a task of your own: give its file to Minari, "
            f'recover_environment(task="PATH/{name}.yaml")'
        )
    if dataset.about["collected"]["depth"]:
        warn("depth images are left out, because the environment does not give them")


def dataset_id(task: str, contents: Mapping[str, Any]) -> str:
    """The name of the data set in Minari, such as ``taskbuilder/handover/expert-v0``.

    Args:
        task: Name of the task.
        contents: The index of the data set.
    """
    played = _policies(contents)
    words = re.sub(r"[^A-Za-z0-9_]+", "-", played[0]).strip("-") if len(played) == 1 else "mixed"
    return f"taskbuilder/{task}/{words or 'unnamed'}-v0"


def _policies(contents: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys(line["policy"] for line in contents["episodes"]))


# --- metadata


def _metadata(name: str, dataset: Dataset) -> dict[str, Any]:
    about, lines = dataset.about, dataset.contents["episodes"]
    task = about["tasks"][name]
    robots: Mapping[str, Any] = task["robots"]
    return {
        "dataset_id": dataset_id(name, dataset.contents),
        "total_episodes": len(lines),
        "total_steps": sum(line["steps"] for line in lines),
        "data_format": "hdf5",
        "jpeg_encoding": False,
        "observation_space": json.dumps(_observation_space(task)),
        "action_space": json.dumps(_action_space(task, about["options"])),
        "env_spec": env_spec(name, about).to_json(),
        "algorithm_name": ", ".join(_policies(dataset.contents)),
        "description": task["summary"],
        "license": about["license"],
        "requirements": ["taskbuilder"],
        "minari_version": MINARI_VERSION,
        "taskbuilder": {
            "version": about["versions"].get("taskbuilder"),
            "task": name,
            "task_version": task.get("task_version", 1),
            "observation_names": _named(robots, "observation_names"),
            "action_names": [name for robot in robots.values() for name in robot["action_names"]],
            "state_names": task["state_names"],
            "subtasks": subtask_labels(task),
            "agents": {agent: _columns(robots, agent) for agent in robots},
        },
    }


def env_spec(name: str, about: Mapping[str, Any]) -> EnvSpec:
    """What Gymnasium makes the environment of a data set of.

    Args:
        name: Name of the task.
        about: What the data set says of itself.
    """
    task, collected = about["tasks"][name], about["collected"]
    options = played_options(about)
    options.pop("reward", None)  # recorded is the team reward
    if collected["cameras"]:
        options["pixels"] = "nested"
    else:
        options = {key: value for key, value in options.items() if key not in _OF_PICTURES}
    of_library = "/" not in name and not task.get("carried")
    return EnvSpec(
        gym_name(name, task.get("task_version", 1)) if of_library else gym_name(),
        entry_point=JOINT_ENV,
        vector_entry_point=JOINT_VECTOR_ENV,
        kwargs={"task": name, **options},
    )


def _named(robots: Mapping[str, Any], key: str) -> list[str]:
    return [f"{agent}/{name}" for agent, robot in robots.items() for name in robot[key]]


def _columns(robots: Mapping[str, Any], agent: str) -> dict[str, Any]:
    """Where the numbers of a robot begin and end in an observation and in an action."""
    before = list(robots)[: list(robots).index(agent)]
    columns = {}
    for what, key in (("observation", "observation_names"), ("action", "action_names")):
        begin = sum(len(robots[other][key]) for other in before)
        columns[what] = [begin, begin + len(robots[agent][key])]
    return columns


def _observation_space(task: Mapping[str, Any]) -> dict[str, Any]:
    size = sum(len(robot["observation_names"]) for robot in task["robots"].values())
    numbers = _box("float32", [size], np.full(size, -np.inf), np.full(size, np.inf))
    if not task["cameras"]:
        return numbers
    pixels = {name: _image_box(camera) for name, camera in task["cameras"].items()}
    return _dict({AGENT_POS: numbers, PIXELS: _dict(pixels)})


def _action_space(task: Mapping[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    robots = task["robots"].values()
    low = np.concatenate([robot["action_low"] for robot in robots])
    high = np.concatenate([robot["action_high"] for robot in robots])
    if options.get("normalize", True):
        low, high = -np.ones(len(low)), np.ones(len(high))
    return _box("float32", [len(low)], low, high)


def _image_box(camera: Mapping[str, Any]) -> dict[str, Any]:
    shape = [camera["height"], camera["width"], 3]
    return _box("uint8", shape, np.zeros(shape, np.uint8), np.full(shape, 255, np.uint8))


def _box(dtype: str, shape: list[int], low: Any, high: Any) -> dict[str, Any]:
    """A box as Minari writes it."""
    bounds = {"low": low.tolist(), "high": high.tolist()}
    return {"type": "Box", "dtype": dtype, "shape": shape, **bounds}


def _dict(spaces: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "Dict", "subspaces": dict(spaces)}


# --- episodes


def _write_episode(
    group: Any, number: int, episode: RecordedEpisode, labels: tuple[str, ...]
) -> None:
    steps, about = episode.steps, episode.about
    group.attrs["id"] = number
    group.attrs["total_steps"] = steps
    for key in ("seed", "variation", "success"):
        group.attrs[key] = about[key]
    for key in ("policy", "instruction"):
        group.attrs[key] = about[key].replace("\0", "")  # which HDF5 cannot have in a text
    last = np.arange(steps) == steps - 1
    group["actions"] = np.concatenate(list(episode.actions.values()), axis=1)
    group["rewards"] = episode.team_reward
    group["terminations"] = last & about.get("terminated", False)
    group["truncations"] = last & ~group["terminations"][()]
    numbers = np.concatenate(list(episode.observations.values()), axis=1)
    if episode.cameras:
        group[f"observations/{AGENT_POS}"] = numbers
    else:
        group["observations"] = numbers
    for camera in episode.cameras:
        size = episode.video_size(camera)
        shape = size.height, size.width, 3
        images = group.create_dataset(
            f"observations/{PIXELS}/{camera}",
            shape=(steps + 1, *shape),
            dtype=np.uint8,
            chunks=(1, *shape),
            compression="gzip",
        )
        for row, image in enumerate(episode.each_image(camera)):
            images[row] = image
    for key, values in infos_of(episode, labels).items():
        group[f"infos/{key}"] = values


def infos_of(episode: RecordedEpisode, labels: tuple[str, ...]) -> dict[str, Any]:
    """The infos of an episode by key, with a row for the reset and one for each control step.

    What there is of control steps alone is 0 in the row of the reset.

    Args:
        episode: An episode.
        labels: The labels of sub-tasks.
    """
    arrays = episode.arrays
    infos = {
        "succeeded": arrays["success"],
        "stage": arrays["stage"],
        "progress": arrays["progress"],
        "state": episode.state,
        "team_reward": _after_reset(episode.team_reward),
        "subtask": _after_reset(subtask_numbers(episode, labels)),
    }
    for agent, rewards in episode.rewards.items():
        infos[f"local_reward.{agent}"] = _after_reset(rewards)
    for name, values in arrays.items():
        kind, _, label = name.partition("/")
        if kind == "conditions":
            infos[_key(f"condition.{label}")] = values
        elif kind == "terms":
            infos[_key(f"reward.{label}")] = _after_reset(values)
    return infos


def _after_reset(values: Any) -> Any:
    return np.concatenate([np.zeros(1, values.dtype), values])


def _key(label: str) -> str:
    return label.replace("/", ".").replace("\0", "")  # a slash begins a group in HDF5
