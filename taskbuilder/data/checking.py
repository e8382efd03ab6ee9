"""Checking a data set: every file by its digest, and a share of the episodes by replaying them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.arrays import StoreError
from taskbuilder.carried import Trust
from taskbuilder.data import layout
from taskbuilder.data.array_schema import OPERATOR
from taskbuilder.data.dataset import Dataset, RecordedEpisode, load_dataset
from taskbuilder.data.environment import make_from
from taskbuilder.data.machines import (
    PICTURE_PACKAGES,
    machine_changes,
    machine_here,
    machine_of_episode,
)
from taskbuilder.data.recording import NO_CAMERAS, StepRecorder, recorded_arrays
from taskbuilder.digests import differences, digest, digest_of
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import RecordedActions
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.sources import digests_of_library, digests_of_task
from taskbuilder.task import other_version


@dataclass(frozen=True)
class CheckResult:
    """What a check of a data set has found.

    Attributes:
        files: Number of files that were hashed.
        damaged: What is wrong with files: changed, missing or additional ones, by name.
        invalid: What is wrong with files that are as they were written: values, arrays and videos
            that no episode of the task has, by name.
        replayed: Names of the episodes that were played again.
        differs: What differs when they are played again, by name of the episode.
        unplayed: Why episodes could not be played again, or "".
        elsewhere: In what this machine, its versions or the task's files differ from those of the
            data set; where they do, other last digits are no sign of damage.
    """

    files: int
    damaged: tuple[str, ...]
    invalid: tuple[str, ...] = ()
    replayed: tuple[str, ...] = ()
    differs: Mapping[str, str] | None = None
    unplayed: str = ""
    elsewhere: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether all that was asked for was checked, and nothing is wrong with the data set."""
        different = self.differs and not self.elsewhere
        return not (self.damaged or self.invalid or self.unplayed or different)


def check_dataset(
    folder: Path, share: float, *, catalogue: Catalogue | None = None, trust: Trust = False
) -> CheckResult:
    """Check a data set.

    Args:
        folder: Where it is.
        share: Fraction of the episodes to play again, from 0 to 1; at least one if it is not 0.
        catalogue: The catalogue that its tasks are looked up in.
        trust: Whether to run tasks that come with the data set; see `make_from`.

    Raises:
        UsageError: The folder is no data set.
    """
    try:
        layout.read_about(folder)
        damaged = tuple(_damaged(folder))
    except StoreError as error:
        return CheckResult(0, (f"{layout.ABOUT} ({error})",))
    files = len(layout.files_of(folder)) + 1
    if damaged:
        return CheckResult(files, damaged)
    try:
        dataset = load_dataset(folder)
        invalid = tuple(_invalid(dataset))
    except StoreError as error:
        invalid = (str(error),)
    if invalid or not share:
        return CheckResult(files, (), invalid)
    chosen = _chosen(dataset, share)
    differs: dict[str, str] = {}
    elsewhere = [*_elsewhere(dataset.about), *_on_nodes(dataset.about, chosen)]
    try:
        with closing(_Replayer(dataset, catalogue, trust)) as replayer:
            elsewhere += replayer.changed_files()
            for episode in chosen:
                if difference := replayer.difference(episode):
                    differs[episode.name] = difference
    except TaskbuilderError as error:
        return CheckResult(files, (), (), unplayed=str(error), elsewhere=tuple(elsewhere))
    names = tuple(episode.name for episode in chosen)
    return CheckResult(files, (), (), names, differs, elsewhere=tuple(elsewhere))


def _damaged(folder: Path) -> Iterator[str]:
    """What is wrong with the files of a data set, by name."""
    if not layout.is_finished(folder):
        raise UsageError(
            f"{folder} is not finished; run the command again that began to collect it"
        )
    try:
        manifest = layout.read_manifest(folder)
    except StoreError:
        yield f"{layout.MANIFEST} is damaged"
        return
    files: Mapping[str, str] = manifest["files"]
    same = layout.digest_file(folder, layout.MANIFEST) == digest(
        layout.json_bytes(layout.sealed(files))
    )
    if manifest.get("seal") != digest_of(files) or not same:
        yield f"{layout.MANIFEST} was changed"
    there = layout.files_of(folder)
    for name in sorted({*there, *files}):
        if name not in files:
            yield f"{name} is new"
        elif name not in there:
            yield f"{name} is gone"
        elif change := _changed(folder, name, files[name]):
            yield f"{name} {change}"


def _changed(folder: Path, name: str, recorded: str) -> str:
    """What is wrong with a file, or ""."""
    try:
        return "" if layout.digest_file(folder, name) == recorded else "was changed"
    except StoreError as error:
        return f"cannot be read ({error})"


def _invalid(dataset: Dataset) -> Iterator[str]:
    """What is wrong with episodes whose files are as they were written."""
    for episode in dataset:
        try:
            _ = episode.arrays
            for camera, about in episode.about["cameras"].items():
                episode.check_video(camera)
                if about.get("depth"):
                    episode.check_video(camera, depth=True)
        except TaskbuilderError as error:
            yield str(error)


def _chosen(dataset: Dataset, share: float) -> list[RecordedEpisode]:
    """Episodes at even distances."""
    count = min(len(dataset), max(1, round(share * len(dataset))))
    places = np.linspace(0, len(dataset) - 1, count).round().astype(int)
    return [dataset[int(place)] for place in places]


def _elsewhere(about: Mapping[str, Any]) -> Iterator[str]:
    """In what this machine differs from that of the data set."""
    for what, then, now in machine_changes(about, machine_here(pictures=False)):
        if what.removeprefix("versions: ") not in PICTURE_PACKAGES:
            yield f"{what} is {now} here and was {then}"
    if about.get("library") != digest_of(digests_of_library()):
        yield "taskbuilder's own files are others"


def _on_nodes(about: Mapping[str, Any], episodes: Sequence[RecordedEpisode]) -> Iterator[str]:
    """Episodes that were played by another kind of machine than that of the data set."""
    own = machine_of_episode(about)
    for episode in episodes:
        machine = episode.about.get("machine", own)
        if machine != own:
            yield f"{episode.name} was played by another machine ({machine.get('processor')})"


class _Replayer:
    """Plays recorded episodes again."""

    def __init__(self, dataset: Dataset, catalogue: Catalogue | None, trust: Trust) -> None:
        self._dataset, self._catalogue, self._trust = dataset, catalogue, trust
        self._stack = ExitStack()
        self._envs: dict[tuple[str, int], TaskEnv] = {}

    def close(self) -> None:
        self._stack.close()

    def changed_files(self) -> Sequence[str]:
        """Files of the tasks that are not those that the data set was collected with."""
        changes = []
        for name, about in self._dataset.about["tasks"].items():
            task = self._env(name, 0).task
            if other := other_version(about, task):
                changes.append(f"task {name}: version {other}")
            here = digests_of_task(task)
            changes += [f"task {name}: {file}" for file in differences(about["files"], here)]
        return changes

    def difference(self, episode: RecordedEpisode) -> str:
        """What differs if an episode is played again, or ""."""
        env = self._env(episode.task, episode.variation)
        steps = StepRecorder(NO_CAMERAS)
        played = play(
            env, RecordedActions(episode.actions), episode.seed, observations=True, watch=steps
        )
        again = recorded_arrays(played, steps)
        for name, array in episode.arrays.items():
            if name == "subtask" or name.startswith("cameras/") or name.endswith(f"/{OPERATOR}"):
                continue  # none of them follows from the actions
            if name not in again or again[name].shape != array.shape:
                return f"{name} has another length"
            if again[name].tobytes() != array.tobytes():
                apart = np.abs(again[name].astype(float) - array.astype(float))
                rows = apart.reshape(len(apart), -1).max(axis=1)
                first = int(np.argmax(rows > 0))
                return f"{name} from row {first} on, by at most {rows.max():.2g}"
        return ""

    def _env(self, task: str, variation: int) -> TaskEnv:
        key = task, variation
        if key not in self._envs:
            made = make_from(
                self._dataset.folder,
                task=task,
                variation=variation,
                cameras=False,
                catalogue=self._catalogue,
                trust=self._trust,
            )
            self._envs[key] = self._stack.enter_context(closing(made))
        return self._envs[key]
