"""robomimic: one HDF5 file, with the numbers of each robot, joined ones, and pictures."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.data.dataset import Dataset, RecordedEpisode
from taskbuilder.extras import extra_needed

VALID_EVERY = 10
"""Every tenth episode is for validation; of fewer, the last, as robomimic asks for one."""

_GYM_TYPE = 2  # of robomimic's EnvType

_OBSERVED = ("observation", "joint_position", "joint_velocity", "gripper", "tcp")


def write_robomimic(dataset: Dataset, folder: Path) -> None:
    """Write the episodes of one task as ``TASK.hdf5``.

    Args:
        dataset: Episodes of one task.
        folder: An empty folder.

    Raises:
        UsageError: h5py is not installed.
        StoreError: The data set is damaged.
        OSError: It cannot be written.
    """
    with extra_needed("data", "the format robomimic"):
        import h5py
    ((name, task),) = dataset.about["tasks"].items()
    with h5py.File(folder / f"{name.replace('/', '-')}.hdf5", "w") as file:
        data = file.create_group("data")
        names = []
        total = 0
        for number, episode in enumerate(dataset):
            names.append(f"demo_{number}")
            _write_demo(data.create_group(names[-1]), episode)
            total += episode.steps
        data.attrs["total"] = total
        data.attrs["env_args"] = json.dumps(_env_args(name, task, dataset.about))
        valid = names[VALID_EVERY - 1 :: VALID_EVERY] or names[1:][-1:]
        train = [demo for demo in names if demo not in set(valid)]
        for part, listed in (("train", train), ("valid", valid)):
            if listed:
                file.create_dataset(f"mask/{part}", data=np.array(listed, dtype="S"))


def _env_args(name: str, task: Mapping[str, Any], about: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "env_name": name,
        "env_type": _GYM_TYPE,
        "env_version": about["versions"].get("taskbuilder"),
        "env_kwargs": {"task": name, **about["options"]},
        "action_names": [n for robot in task["robots"].values() for n in robot["action_names"]],
        "robots": dict(task["robots"]),
        "state_names": task["state_names"],
    }


def _write_demo(demo: Any, episode: RecordedEpisode) -> None:
    steps, arrays = episode.steps, episode.arrays
    demo.attrs["num_samples"] = steps
    for key in ("seed", "variation", "policy", "instruction", "success"):
        demo.attrs[key] = episode.about[key]
    demo.attrs["subtasks"] = json.dumps(list(episode.subtasks))
    done = np.zeros(steps, dtype=np.int64)
    done[-1:] = 1
    demo["actions"] = np.concatenate(list(episode.actions.values()), axis=1)
    demo["rewards"] = episode.team_reward
    demo["dones"] = done
    demo["states"] = episode.state[:steps]
    demo["subtask"] = arrays["subtask"]
    for agent in episode.agents:
        for key in ("action", "reward", "joint_target", "gripper_target"):
            demo[f"agents/{agent}/{key}"] = arrays[f"agents/{agent}/{key}"]
    for key, values in _observations(episode).items():
        for group, rows in (("obs", values[:steps]), ("next_obs", values[1:])):
            demo.create_dataset(f"{group}/{key}", data=rows)
    for camera in episode.cameras:
        size = episode.video_size(camera)
        shape = size.height, size.width
        _write_images(demo, f"{camera}_image", episode.each_image(camera), (*shape, 3), steps)
        if episode.about["cameras"][camera].get("depth"):
            depths = (image[..., None] for image in episode.each_depth(camera))
            _write_images(demo, f"{camera}_depth", depths, (*shape, 1), steps)


def _write_images(
    demo: Any, key: str, images: Iterable[NDArray[Any]], shape: tuple[int, ...], steps: int
) -> None:
    """Write the images of steps + 1 states, of which one is held at a time."""
    dtype = np.float32 if shape[-1] == 1 else np.uint8
    chunks = {"shape": (steps, *shape), "dtype": dtype, "chunks": (1, *shape)}
    now, then = (
        demo.create_dataset(f"{group}/{key}", compression="gzip", **chunks)
        for group in ("obs", "next_obs")
    )
    for number, image in enumerate(images):
        if number < steps:
            now[number] = image
        if number:
            then[number - 1] = image


def _observations(episode: RecordedEpisode) -> dict[str, Any]:
    """By key: (steps + 1, n); ``left_tcp`` is a robot's own, and ``joints`` all robots'."""
    datasets: dict[str, Any] = {}
    for agent in episode.agents:
        for what in _OBSERVED:
            values = episode.arrays[f"agents/{agent}/{what}"]
            datasets[f"{agent}_{what}"] = values[:, None] if values.ndim == 1 else values
    parts = [
        datasets[f"{agent}_{what}"]
        for agent in episode.agents
        for what in ("joint_position", "gripper")
    ]
    datasets["joints"] = np.concatenate(parts, axis=1)
    datasets["state"] = episode.state
    for name, values in episode.arrays.items():
        if name.startswith("objects/"):
            datasets[f"{name.split('/')[1]}_pose"] = values
    return datasets
