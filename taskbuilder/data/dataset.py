"""Reading data sets: episodes with their arrays, and the environment that they came from.

    dataset = load_dataset("data/handover")
    for episode in dataset:
        episode.observations["left"], episode.actions["left"], episode.rewards["left"]

Reading executes nothing: the files are JSON, arrays and videos. `make_from` imports the task, which
it looks up by its name in the catalogue.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from taskbuilder.arrays import Arrays, StoreError
from taskbuilder.data import layout
from taskbuilder.data.videos import Frames, decoded, decoded_depth
from taskbuilder.env.options import Options, Renderer, make_options
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.wording import suggestion


class RecordedEpisode:
    """An episode of a data set; its arrays are read when they are first used.

    Arrays have a row for every control step, or for every state: after reset and after each
    control step, so one more.

    Attributes:
        place: The folder of the episode.
        name: Its name.
    """

    def __init__(self, place: Path) -> None:
        self.place = place
        self.name = place.name

    @cached_property
    def about(self) -> Mapping[str, Any]:
        """Everything but the numbers: seed, variation, policy, instruction, sub-tasks, why, ..."""
        return layout.read_episode(self.place)

    @cached_property
    def arrays(self) -> Arrays:
        """All arrays by name, such as ``agents/left/joint_target``."""
        return layout.read_episode_arrays(self.place)

    @property
    def task(self) -> str:
        """The id of the task."""
        return str(self.about["task"])

    @property
    def seed(self) -> int:
        """Seed of the reset."""
        return int(self.about["seed"])

    @property
    def variation(self) -> int:
        """The variation that was played."""
        return int(self.about["variation"])

    @property
    def policy(self) -> str:
        """Who played."""
        return str(self.about["policy"])

    @property
    def instruction(self) -> str:
        """The instruction, filled in."""
        return str(self.about["instruction"])

    @property
    def success(self) -> bool:
        """Whether the episode succeeded."""
        return bool(self.about["success"])

    @property
    def steps(self) -> int:
        """Length in control steps."""
        return int(self.about["steps"])

    @property
    def subtasks(self) -> Sequence[Mapping[str, Any]]:
        """The expert's stages with their time spans; empty if no expert played."""
        subtasks: Sequence[Mapping[str, Any]] = self.about["subtasks"]
        return subtasks

    @property
    def agents(self) -> tuple[str, ...]:
        """The robots."""
        return tuple(self.of_agents("action"))

    def of_agents(self, what: str) -> dict[str, NDArray[Any]]:
        """An array of every agent, by agent.

        Args:
            what: ``observation``, ``action``, ``reward``, ``joint_position``, ``joint_velocity``,
                ``joint_target``, ``gripper``, ``gripper_target`` or ``tcp``.
        """
        return {
            name.split("/")[1]: array
            for name, array in self.arrays.items()
            if name.startswith("agents/") and name.split("/")[2] == what
        }

    @property
    def observations(self) -> dict[str, NDArray[np.float32]]:
        """By agent: (steps + 1, n) float32."""
        return self.of_agents("observation")

    @property
    def actions(self) -> dict[str, NDArray[np.float32]]:
        """By agent: (steps, n) float32, as the environment takes them."""
        return self.of_agents("action")

    @property
    def rewards(self) -> dict[str, NDArray[np.float64]]:
        """By agent: (steps,) its own terms and an equal share of the common ones."""
        return self.of_agents("reward")

    @property
    def state(self) -> NDArray[np.float32]:
        """(steps + 1, n) float32, for centralised critics."""
        return self.arrays["state"]

    @property
    def team_reward(self) -> NDArray[np.float64]:
        """(steps,) the sum of all terms."""
        return self.arrays["reward"]

    @property
    def cameras(self) -> tuple[str, ...]:
        """The recorded cameras."""
        return tuple(self.about["cameras"])

    def video(self, camera: str) -> bytes:
        """The MP4 file of a camera.

        Raises:
            UnknownNameError: It was not recorded.
        """
        return self._file(camera, "video")

    def images(self, camera: str) -> Frames:
        """The colour images of a camera: (steps + 1, height, width, 3) uint8.

        Raises:
            UnknownNameError: It was not recorded.
            VideoError: The video is damaged.
        """
        return decoded(self.video(camera))

    def depth(self, camera: str) -> NDArray[np.float32]:
        """The depth images of a camera, in metres: (steps + 1, height, width) float32.

        Raises:
            UnknownNameError: It was not recorded.
            VideoError: The video is damaged.
        """
        return decoded_depth(self._file(camera, "depth"))

    def _file(self, camera: str, what: str) -> bytes:
        known = {name: files for name, files in self.about["cameras"].items() if what in files}
        if camera not in known:
            help_ = suggestion(camera, known, what="it has")
            raise UnknownNameError(f'{self.name} has no {what} of "{camera}"; {help_}')
        name = str(known[camera][what])
        if Path(name).name != name:  # a file of another folder
            raise StoreError(f"{display_path(self.place)} is damaged: {name} is no file of it")
        return (self.place / name).read_bytes()


class Dataset(Sequence[RecordedEpisode]):
    """The episodes of a data set, in order.

    Attributes:
        folder: Where it is.
        about: What it says of itself: how it was collected, tasks, names of numbers, versions.
        contents: A line for every episode, and the attempts that were not kept.
    """

    def __init__(
        self,
        folder: Path,
        about: Mapping[str, Any],
        contents: Mapping[str, Any],
        names: Sequence[str],
    ) -> None:
        self.folder = folder
        self.about = about
        self.contents = contents
        self._names = tuple(names)

    @property
    def tasks(self) -> tuple[str, ...]:
        """The ids of its tasks."""
        return tuple(self.about["tasks"])

    def of_task(self, task: str) -> Dataset:
        """The episodes of one task.

        Raises:
            UnknownNameError: There are none.
        """
        if task not in self.about["tasks"]:
            help_ = suggestion(task, self.tasks, what="it has")
            raise UnknownNameError(f'{display_path(self.folder)} has no task "{task}"; {help_}')
        lines = [line for line in self.contents["episodes"] if line["task"] == task]
        about = {**self.about, "tasks": {task: self.about["tasks"][task]}}
        names = [line["name"] for line in lines]
        return Dataset(self.folder, about, {**self.contents, "episodes": lines}, names)

    def __len__(self) -> int:
        return len(self._names)

    @overload
    def __getitem__(self, index: int) -> RecordedEpisode: ...

    @overload
    def __getitem__(self, index: slice) -> list[RecordedEpisode]: ...

    def __getitem__(self, index: int | slice) -> RecordedEpisode | list[RecordedEpisode]:
        if isinstance(index, slice):
            return [self._episode(name) for name in self._names[index]]
        return self._episode(self._names[index])

    def __iter__(self) -> Iterator[RecordedEpisode]:
        return map(self._episode, self._names)

    def _episode(self, name: str) -> RecordedEpisode:
        return RecordedEpisode(self.folder / layout.EPISODES / name)


def load_dataset(folder: str | Path) -> Dataset:
    """Read a data set. Nothing that comes with it is executed.

    Args:
        folder: Where it is.

    Raises:
        UsageError: The folder is no data set, or collecting has not come to its end.
        StoreError: It is damaged.
    """
    place = Path(folder)
    about = layout.read_about(place)
    where = display_path(place)
    if not layout.is_finished(place):
        raise UsageError(f"{where} is not finished; run the command again that began to collect it")
    try:
        index = layout.read_json(place / layout.INDEX)
        names = [str(line["name"]) for line in index["episodes"]]
    except (KeyError, TypeError, FileNotFoundError) as error:
        raise StoreError(f"{where} is damaged: its {layout.INDEX} lacks {error}") from None
    if any(Path(name).name != name for name in names):
        raise StoreError(f"{where} is damaged: an episode lies in another folder")
    return Dataset(place, about, index, names)


def make_from(
    folder: str | Path,
    *,
    task: str | Path | Task | None = None,
    variation: int | None = None,
    cameras: bool = True,
    renderer: Renderer | None = None,
    catalogue: Catalogue | None = None,
) -> TaskEnv:
    """Make the environment that a data set came from, with the same options.

    Args:
        folder: The data set.
        task: Which of its tasks, if it has several; or the file of the task, if it is not in the
            catalogue.
        variation: The variation; by default the first that was collected.
        cameras: Whether agents observe the recorded cameras, in the recorded size and drawn by
            the recorded renderer.
        renderer: Another renderer than the recorded one; its pictures differ.
        catalogue: The catalogue that the task is looked up in; by default that of this
            installation.

    Raises:
        UsageError: The folder is no data set, or it has several tasks and none is named.
        UnknownNameError: The task is not in the catalogue.
        FileError: The task has errors.
        SimulationError: The renderer is not installed here; name another to use it instead.
    """
    about = layout.read_about(Path(folder))
    loaded = _task_of(about, Path(folder), task, catalogue)
    options = options_of_dataset(about, cameras=cameras)
    if renderer is not None:
        options["renderer"] = renderer
    if variation is None:
        played = about["collected"]["variations"]
        variation = 0 if played == "all" else played[0]
    return TaskEnv(loaded, make_options(**{**options, "variation": variation}))


def options_of_dataset(about: Mapping[str, Any], *, cameras: bool) -> dict[str, Any]:
    """The options of the environment of a data set, besides the variation.

    Args:
        about: What the data set says of itself.
        cameras: Whether agents observe the recorded cameras.
    """
    known = set(Options.__dataclass_fields__)
    options = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in about["options"].items()
        if name in known
    }
    collected = about["collected"]
    if cameras and collected["cameras"]:
        options["cameras"] = tuple(collected["cameras"])
        options["camera_size"] = tuple(collected["size"]) if collected["size"] else None
        options["renderer"] = about["renderer"]
    return options


def _task_of(
    about: Mapping[str, Any],
    folder: Path,
    task: str | Path | Task | None,
    catalogue: Catalogue | None,
) -> Task:
    """The task of a data set; its name alone leads nowhere but to the catalogue."""
    names = list(about["tasks"])
    if isinstance(task, Task):
        return task
    if task is None and len(names) > 1:
        raise UsageError(f"{display_path(folder)} has several tasks; name one: {', '.join(names)}")
    catalogue = catalogue or Catalogue.discover()
    if task is not None and str(task) not in names:
        return load_task(task, catalogue=catalogue)
    name = str(task) if task is not None else names[0]
    return load_task(catalogue.named_task(name).file, catalogue=catalogue)
