"""A data set to which episodes are added one by one, as people show them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import Any

from taskbuilder.data import layout
from taskbuilder.data.collecting import (
    CollectingError,
    begin_folder,
    disk_words,
    finish_folder,
    write_tasks,
)
from taskbuilder.data.machines import machine_of_episode
from taskbuilder.data.plan import Attempt, CollectPlan, check_plan, describe
from taskbuilder.data.playing import AttemptResult
from taskbuilder.data.recording import EpisodeData
from taskbuilder.task import Task


class GrowingDataset:
    """A data set that is finished after every episode, so that nothing is lost.

    Args:
        plan: What is recorded; of a single task.
        folder: Where to; it must be new, empty, or a data set of the same plan.
        task: The task.

    Attributes:
        plan: The same.
        folder: The same.

    Raises:
        UsageError: The folder holds something else, or another process records into it.
        CollectingError: Nothing can be written there.
    """

    def __init__(self, plan: CollectPlan, folder: Path, task: Task) -> None:
        check_plan(plan, [task])
        self.plan, self.folder, self._task = plan, folder, task
        self._stack = ExitStack()
        self._about: Mapping[str, Any] = describe(plan, [task])
        self._machine = machine_of_episode(plan.machine())
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._stack.enter_context(layout.locked(folder))
            begin_folder(folder, self._about)
            write_tasks(folder, [task])
        except OSError as error:
            self.close()
            raise CollectingError(disk_words(error, folder)) from error
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Let other processes write into the folder."""
        self._stack.close()

    @property
    def episodes(self) -> int:
        """Number of episodes."""
        return len(self._names())

    def free_seed(self, first: int) -> int:
        """The first seed from one on that no episode has."""
        return next(seed for seed in count(first) if not self._place(seed).exists())

    def add(self, data: EpisodeData) -> str:
        """Add an episode, and return its name.

        Raises:
            CollectingError: It cannot be written.
        """
        name = self._name(data.about["seed"])
        about = {"machine": self._machine, **data.about}
        whole = EpisodeData(about, data.arrays, data.images, data.depths)
        try:
            # Until the new manifest is written, the data set counts as unfinished, not as damaged.
            (self.folder / layout.MANIFEST).unlink(missing_ok=True)
            layout.write_episode(self.folder, name, layout.episode_files(name, whole))
            kept = [AttemptResult(each, True, "") for each in self._names()]
            finish_folder(self.folder, self._about, kept)
        except OSError as error:
            raise CollectingError(disk_words(error, self.folder)) from error
        return name

    def _name(self, seed: int) -> str:
        return Attempt(self.plan.tasks[0], self._task.name, seed, 0, "").name

    def _place(self, seed: int) -> Path:
        return self.folder / layout.EPISODES / self._name(seed)

    def _names(self) -> list[str]:
        folder = self.folder / layout.EPISODES
        names = sorted(file.name for file in folder.iterdir()) if folder.is_dir() else []
        return [name for name in names if layout.is_whole(self.folder, name)]
