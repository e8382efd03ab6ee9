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

    Some arrays have ``steps`` rows, one per control step. Others have ``steps`` + 1 rows: one for
    the state after reset, and one for the state after each control step.

    Attributes:
        place: The folder of the episode.
        name: Name of the episode, such as ``handover-000000007``.
    """

    def __init__(self, place: Path) -> None:
        self.place = place
        self.name = place.name

    @cached_property
    def about(self) -> Mapping[str, Any]:
        """Contents of ``episode.json``: seed, variation, policy, instruction, sub-tasks, ..."""
        return layout.read_episode(self.place)

    @cached_property
    def arrays(self) -> Arrays:
        """All arrays by name, such as ``agents/left/joint_target``."""
        return layout.read_episode_arrays(self.place)

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
    def steps(self) -> int:
        """Length of the episode in control steps."""
        return int(self.about["steps"])

    @property
    def subtasks(self) -> Sequence[Mapping[str, Any]]:
        """The expert's stages with their time spans; empty if no expert played."""
        subtasks: Sequence[Mapping[str, Any]] = self.about["subtasks"]
        return subtasks

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
        """
        return self._file(camera, "video")

    def images(self, camera: str) -> Frames:
        """The colour images of a camera: (steps + 1, height, width, 3) uint8.

        Raises:
            UnknownNameError: The camera was not recorded.
            VideoError: The video is damaged.
        """
        return decoded(self.video(camera))

    def depth(self, camera: str) -> NDArray[np.float32]:
        """The depth images of a camera, in metres: (steps + 1, height, width) float32.

        Raises:
            UnknownNameError: The depth images of the camera were not recorded.
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
        folder: Folder of the data set.
        about: Contents of ``dataset.json``: how the data set was collected, its tasks, the names of
            the columns of its arrays, and the versions of the packages that were used.
        contents: Contents of ``index.json``: an entry for every episode of the data set, and an
            entry for every episode that was played but not kept.
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
    """Read a data set, without executing any code from the folder.

    Args:
        folder: Folder of the data set.

    Raises:
        UsageError: The folder is not a data set, or the data set is not complete yet.
        StoreError: The data set is damaged.
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
    """Make the environment in which a data set was recorded, with the same options.

    Args:
        folder: Folder of the data set.
        task: The task, if the data set has several tasks; or the path of the task file, if the task
            is not in the catalogue.
        variation: Number of the variation; by default the first variation that was recorded.
        cameras: Whether agents observe the images of the recorded cameras, with the image size and
            the renderer of the data set.
        renderer: Renderer to use instead of the data set's own; the images then differ from the
            recorded images.
        catalogue: Catalogue in which to look up the task; by default the catalogue of this
            installation.

    Raises:
        UsageError: The folder is not a data set, or the data set has several tasks and ``task`` is
            not given.
        UnknownNameError: The task is not in the catalogue.
        FileError: The task has errors.
        SimulationError: The renderer of the data set does not work on this machine; give another
            as ``renderer``.
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
