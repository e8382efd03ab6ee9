"""Reading data sets: episodes with their arrays and images.

    dataset = load_dataset("data/handover")
    for episode in dataset:
        episode.observations["left"], episode.actions["left"], episode.rewards["left"]

A data set may come from anybody. Reading executes nothing of it: the files are JSON, arrays and
videos, and each is checked against what the data set says of it before it is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from taskbuilder.arrays import Arrays
from taskbuilder.data import layout
from taskbuilder.data.array_schema import (
    OPERATOR,
    check_arrays,
    expected_arrays,
    largest_file,
)
from taskbuilder.data.records import check_episode
from taskbuilder.data.videos import (
    Frames,
    VideoError,
    VideoSize,
    check_header,
    depths_of,
    images_of,
    stacked,
)
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.wording import suggestion


class RecordedEpisode:
    """An episode of a data set; its files are read and checked when they are first used.

    Some arrays have ``steps`` rows, one per control step. Others have ``steps`` + 1 rows: one for
    the state after reset, and one for the state after each control step.

    Attributes:
        place: The folder of the episode.
        name: Name of the episode, such as ``handover-000000007``.
    """

    def __init__(self, folder: Path, line: Mapping[str, Any], about: Mapping[str, Any]) -> None:
        self._folder, self._line, self._about = folder, line, about
        self.name = str(line["name"])
        self.place = folder / layout.EPISODES / self.name

    @cached_property
    def about(self) -> Mapping[str, Any]:
        """Contents of ``episode.json``: seed, variation, policy, instruction, sub-tasks, ...

        Raises:
            StoreError: The file is damaged.
        """
        about = layout.read_episode(self._folder, self.name)
        check_episode(about, self._line, self._of_task, display_path(self.place / layout.EPISODE))
        return about

    @cached_property
    def arrays(self) -> Arrays:
        """All arrays by name, such as ``agents/left/joint_target``.

        Raises:
            StoreError: The file is damaged, or an array is missing, has another shape or type than
                it must have, or has numbers that are not finite.
        """
        normalized = bool(self._about["options"].get("normalize", True))
        expected = expected_arrays(self._of_task, self.about, normalized=normalized)
        largest = largest_file(expected, self.steps)
        arrays = layout.read_episode_arrays(self._folder, self.name, largest)
        check_arrays(arrays, expected, self.steps, display_path(self.place / layout.ARRAYS))
        return arrays

    @property
    def _of_task(self) -> Mapping[str, Any]:
        about: Mapping[str, Any] = self._about["tasks"][self._line["task"]]
        return about

    def __repr__(self) -> str:
        how = "success" if self.success else "no success"
        return f"<RecordedEpisode {self.task}, seed {self.seed}: {self.steps} steps, {how}>"

    @property
    def task(self) -> str:
        """The name of the task."""
        return str(self.about["task"])

    @property
    def seed(self) -> int:
        """Seed passed to `reset`."""
        return int(self.about["seed"])

    @property
    def variation(self) -> int:
        """Number of the variation that was played."""
        return int(self.about["variation"])

    @property
    def policy(self) -> str:
        """The policy that played, such as ``expert``."""
        return str(self.about["policy"])

    @property
    def instruction(self) -> str:
        """The instruction, with placeholders such as ``{stick.color}`` filled in."""
        return str(self.about["instruction"])

    @property
    def success(self) -> bool:
        """Whether the episode succeeded."""
        return bool(self.about["success"])

    @property
    def first_success(self) -> int | None:
        """The first control step with success; None if there is none, or none is recorded."""
        step = self.about.get("first_success")
        return step if isinstance(step, int) else None

    @property
    def steps(self) -> int:
        """Length of the episode in control steps."""
        return int(self.about["steps"])

    @property
    def subtasks(self) -> Sequence[Mapping[str, Any]]:
        """The expert's stages with their time spans; empty if no expert played."""
        subtasks: Sequence[Mapping[str, Any]] = self.about["subtasks"]
        return subtasks

    @property
    def operators(self) -> tuple[str, ...]:
        """The people who steered robots, in the order in which they began."""
        return tuple(self.about.get("operators", ()))

    @property
    def steered_by(self) -> dict[str, NDArray[np.int64]]:
        """Whose each control step was, by agent: (steps,) each; empty if nobody steered.

        A number from 1 counts `operators`. 0 is the policy, and -1 nobody: the robot held still
        because its person had left.
        """
        return self.of_agents(OPERATOR)

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of the robots."""
        return tuple(self.of_agents("action"))

    def of_agents(self, what: str) -> dict[str, NDArray[Any]]:
        """The arrays of one kind, as a dictionary keyed by agent.

        Args:
            what: Kind of array: ``observation``, ``action``, ``reward``, ``joint_position``,
                ``joint_velocity``, ``joint_target``, ``gripper``, ``gripper_target`` or ``tcp``.
        """
        return {
            name.split("/")[1]: array
            for name, array in self.arrays.items()
            if name.startswith("agents/") and name.split("/")[2] == what
        }

    @property
    def observations(self) -> dict[str, NDArray[np.float32]]:
        """Observations by agent: (steps + 1, n) float32 each."""
        return self.of_agents("observation")

    @property
    def actions(self) -> dict[str, NDArray[np.float32]]:
        """Actions by agent, as passed to `TaskEnv.step`: (steps, n) float32 each."""
        return self.of_agents("action")

    @property
    def rewards(self) -> dict[str, NDArray[np.float64]]:
        """Local rewards by agent: (steps,) each."""
        return self.of_agents("reward")

    @property
    def state(self) -> NDArray[np.float32]:
        """States for centralised critics: (steps + 1, n) float32."""
        return self.arrays["state"]

    @property
    def team_reward(self) -> NDArray[np.float64]:
        """Team reward in each control step, which is the sum of all reward terms: (steps,)."""
        return self.arrays["reward"]

    @property
    def cameras(self) -> tuple[str, ...]:
        """The names of the recorded cameras."""
        return tuple(self.about["cameras"])

    def video(self, camera: str) -> bytes:
        """The contents of the MP4 file of a camera.

        Raises:
            UnknownNameError: The camera was not recorded.
            StoreError: It cannot be read, or is too large.
        """
        return self._file(camera, "video")

    def video_size(self, camera: str) -> VideoSize:
        """Width, height and number of the images of a camera.

        Raises:
            UnknownNameError: The camera was not recorded.
        """
        self._check_recorded(camera, "video")
        about = self.about["cameras"][camera]
        return VideoSize(about["width"], about["height"], about["frames"])

    def images(self, camera: str) -> Frames:
        """The colour images of a camera: (steps + 1, height, width, 3) uint8.

        Raises:
            UnknownNameError: The camera was not recorded.
            VideoError: The video is damaged, or is not of the recorded size and length; or its
                images take more than 1 GiB.
        """
        images, size = self.each_image(camera), self.video_size(camera)
        with self._video_file(camera, "video"):
            return stacked(images, size)

    def each_image(self, camera: str) -> Iterator[Frames]:
        """The colour images of a camera, decoded one after the other: (height, width, 3) uint8.

        Raises:
            UnknownNameError: The camera was not recorded.
            VideoError: The video is damaged, or is not of the recorded size and length.
        """
        content = self.video(camera)
        with self._video_file(camera, "video"):
            yield from images_of(content, self.video_size(camera))

    def depth(self, camera: str) -> NDArray[np.float32]:
        """The depth images of a camera, in metres: (steps + 1, height, width) float32.

        Raises:
            UnknownNameError: The depth images of the camera were not recorded.
            VideoError: The video is damaged, or is not of the recorded size and length; or its
                images take more than 1 GiB.
        """
        depths, size = self.each_depth(camera), self.video_size(camera)
        with self._video_file(camera, "depth"):
            return stacked(depths, size)

    def each_depth(self, camera: str) -> Iterator[NDArray[np.float32]]:
        """The depth images of a camera, in metres, one after the other: (height, width) float32.

        Raises:
            UnknownNameError: The depth images of the camera were not recorded.
            VideoError: The video is damaged, or is not of the recorded size and length.
        """
        content = self._file(camera, "depth")
        with self._video_file(camera, "depth"):
            yield from depths_of(content, self.video_size(camera))

    def check_video(self, camera: str, *, depth: bool = False) -> None:
        """Check what the header of a camera's video says; no image is decoded.

        Raises:
            UnknownNameError: The camera, or its depth, was not recorded.
            VideoError: The video is damaged, or is not of the recorded size and length.
        """
        what = "depth" if depth else "video"
        content = self._file(camera, what)
        with self._video_file(camera, what):
            check_header(content, self.video_size(camera), depth=depth)

    def _file(self, camera: str, what: str) -> bytes:
        self._check_recorded(camera, what)
        name = f"{layout.EPISODES}/{self.name}/{self.about['cameras'][camera][what]}"
        return layout.read_file(self._folder, name, self.video_size(camera).largest_file)

    def _check_recorded(self, camera: str, what: str) -> None:
        recorded = [name for name, files in self.about["cameras"].items() if files.get(what)]
        if camera not in recorded:
            help_ = suggestion(camera, recorded, what="it has")
            raise UnknownNameError(f'{self.name} has no {what} of "{camera}"; {help_}')

    @contextmanager
    def _video_file(self, camera: str, what: str) -> Iterator[None]:
        """Have errors name the file of a video."""
        try:
            yield
        except VideoError as error:
            where = display_path(self.place / self.about["cameras"][camera][what])
            if str(error).startswith(where):
                raise
            raise VideoError(f"{where}: {error}") from None


class Dataset(Sequence[RecordedEpisode]):
    """The episodes of a data set, in order.

    Attributes:
        folder: Folder of the data set.
        about: Contents of ``dataset.json``: how the data set was collected, its tasks, the names of
            the columns of its arrays, and the versions of the packages that were used.
        contents: Contents of ``index.json``: an entry for every episode of the data set, and an
            entry for every episode that was played but not kept.
    """

    def __init__(self, folder: Path, about: Mapping[str, Any], contents: Mapping[str, Any]) -> None:
        self.folder = folder
        self.about = about
        self.contents = contents
        self._lines = tuple(contents["episodes"])

    def __repr__(self) -> str:
        count, tasks = len(self), ", ".join(self.tasks)
        where = display_path(self.folder)
        return f"<Dataset {where}: {count} episode{'s' * (count != 1)} of {tasks}>"

    @property
    def tasks(self) -> tuple[str, ...]:
        """The names of the tasks in the data set."""
        return tuple(self.about["tasks"])

    def of_task(self, task: str) -> Dataset:
        """The episodes of one task.

        Raises:
            UnknownNameError: The data set has no episodes of this task.
        """
        if task not in self.about["tasks"]:
            help_ = suggestion(task, self.tasks, what="it has")
            raise UnknownNameError(f'{display_path(self.folder)} has no task "{task}"; {help_}')
        lines = [line for line in self._lines if line["task"] == task]
        about = {**self.about, "tasks": {task: self.about["tasks"][task]}}
        return Dataset(self.folder, about, {**self.contents, "episodes": lines})

    def with_steps(self) -> Dataset:
        """The episodes that have at least one control step."""
        lines = [line for line in self._lines if line["steps"]]
        return Dataset(self.folder, self.about, {**self.contents, "episodes": lines})

    def __len__(self) -> int:
        return len(self._lines)

    @overload
    def __getitem__(self, index: int) -> RecordedEpisode: ...

    @overload
    def __getitem__(self, index: slice) -> list[RecordedEpisode]: ...

    def __getitem__(self, index: int | slice) -> RecordedEpisode | list[RecordedEpisode]:
        if isinstance(index, slice):
            return [self._episode(line) for line in self._lines[index]]
        return self._episode(self._lines[index])

    def __iter__(self) -> Iterator[RecordedEpisode]:
        return map(self._episode, self._lines)

    def _episode(self, line: Mapping[str, Any]) -> RecordedEpisode:
        return RecordedEpisode(self.folder, line, self.about)


def load_dataset(folder: str | Path) -> Dataset:
    """Read a data set, without executing any code from the folder.

    Args:
        folder: Folder of the data set.

    Raises:
        UsageError: The folder is not a data set, or the data set is not complete yet.
        StoreError: The data set is damaged.
    """
    place = Path(folder)
    about = layout.read_about(place)
    if not layout.is_finished(place):
        where = display_path(place)
        raise UsageError(f"{where} is not finished; run the command again that began to collect it")
    return Dataset(place, about, layout.read_index(place, about))
