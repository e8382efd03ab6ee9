"""The files of a benchmark's folder: what it is about, and what came of every cell.

```text
benchmark.json                      the suite, the track and the method
tasks/TASK.json                     what the demonstrations cost, what the baselines achieve
cells/TASK-SEED/run/                a training run
cells/TASK-SEED/certificate-K.json  the evaluation in test variation K
cells/TASK-SEED/cell.json           what came of the cell; its last file
results.csv, results.json, benchmark.png, README.md
shared/TASK/                        the demonstrations of a task; several methods can share them
shared/TASK.json                    what this task's file in tasks/ says
```
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from taskbuilder._version import __version__
from taskbuilder.benchmark.tracks import Track
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.schema.values import Model, Text
from taskbuilder.untrusted import parse_json, read_plain
from taskbuilder.wording import excerpt

ABOUT, CELL, LOCK = "benchmark.json", "cell.json", ".lock"
SHARED, TASKS, CELLS = "shared", "tasks", "cells"

FORMAT: Literal[1] = 1
"""Version of these files."""

LARGEST = 4 << 20
"""Maximum size of one of these files in bytes."""

Number = Annotated[int, Field(ge=0)]
Seconds = Annotated[float, Field(ge=0.0)]
Label = Annotated[str, Field(max_length=300)]


class Method(Model):
    """What is measured: an algorithm that trains policies, or policies that exist.

    Attributes:
        algorithm: Name of the algorithm; "" for policies that exist.
        preset: Preset of its settings; "" for the default.
        settings: Settings that differ from the preset, such as ``noise=0.1``.
        policy: Policies that exist, as text; ``{task}`` and ``{seed}`` stand for those of a cell.
    """

    algorithm: Label = ""
    preset: Label = ""
    settings: tuple[Label, ...] = ()
    policy: Label = ""

    @property
    def label(self) -> str:
        """The method in a few words."""
        return " ".join(
            [self.policy or self.algorithm, *filter(None, [self.preset]), *self.settings]
        )


class SuiteTasks(Model):
    """A suite as it was when a benchmark began.

    Attributes:
        name: Name of the suite.
        tasks: Names of its tasks.
        versions: The version of each task; from before there were any, they are 1.
        train: Numbers of the variations to train in.
        test: Numbers of the variations to evaluate in.
    """

    name: Label
    tasks: tuple[Label, ...] = Field(min_length=1)
    train: tuple[Number, ...] = Field(min_length=1)
    test: tuple[Number, ...] = Field(min_length=1)
    versions: tuple[Number, ...] = ()

    def version(self, task: str) -> int:
        """The version of a task."""
        return dict(zip(self.tasks, self.versions, strict=False)).get(task, 1)

    @property
    def labels(self) -> str:
        """The tasks with their versions, such as ``handover, reach (version 2)``."""
        numbers = ((task, self.version(task)) for task in self.tasks)
        return ", ".join(f"{name} (version {n})" if n > 1 else name for name, n in numbers)


class About(Model):
    """What a folder holds the results of.

    Attributes:
        format: Version of the files.
        taskbuilder: Version of taskbuilder.
        suite: The tasks.
        track: The track.
        method: What is measured.
        seeds: Training seeds, in order.
        tuning_runs: Training runs that were spent on choosing the settings; None if not declared.
        command: The command that began it.
    """

    format: Literal[1] = FORMAT
    taskbuilder: Label = __version__
    suite: SuiteTasks
    track: Track
    method: Method
    seeds: tuple[Number, ...] = Field(min_length=1)
    tuning_runs: Number | None = None
    command: Annotated[str, Field(max_length=20_000)] = ""


class BaselineRecord(Model):
    """What a baseline achieves in the first episodes of the evaluation.

    Attributes:
        episodes: Number of episodes.
        successes_at_end: Episodes in which success held at the last control step.
        mean_return: Mean team return.
    """

    episodes: Number
    successes_at_end: Number
    mean_return: float


class TaskRecord(Model):
    """What all cells of a task share.

    Attributes:
        task: The task.
        track: Label of the track.
        reason: Why the track cannot have this task; "" if it can.
        demonstrations: Number of episodes to learn from.
        demonstrator: Who played them, such as ``noisy:0.1@0.25``.
        cpu_s: CPU time of collecting them, in seconds.
        baselines: What the expert and random actions achieve, by name.
    """

    task: Label
    track: Label
    reason: Annotated[str, Field(max_length=20_000)] = ""
    demonstrations: Number = 0
    demonstrator: Label = ""
    cpu_s: Seconds = 0.0
    baselines: Mapping[str, BaselineRecord] = Field(default_factory=dict)


Status = Literal["done", "failed", "impossible"]


class CellRecord(Model):
    """What came of a cell: a task and a seed.

    Attributes:
        task: The task.
        seed: Training seed.
        status: ``done``; ``failed`` if the method cannot do the task, which counts as no success;
            or ``impossible`` if the track cannot have the task, which leaves it out.
        reason: Why it failed or is impossible.
        episodes: Episodes of the evaluation, over all test variations.
        successes: Episodes that succeeded at some control step.
        successes_at_end: Episodes in which success held at the last control step.
        safe_successes: Of these, episodes in which no contact between robots exceeded the track's
            force at any time.
        mean_return: Mean team return.
        peak_robot_force: Largest force between two robots, in newtons.
        train_cpu_s: CPU time of the training, its evaluations included, in seconds.
        evaluate_cpu_s: CPU time of the evaluation, in seconds.
        certificates: Names of the certificates in the folder of the cell.
        command: The command that repeats this cell alone.
        library: Digest of all files of taskbuilder and its tasks.
        versions: Versions of the packages, by name.
        processor: The processor.
    """

    task: Label
    seed: Number
    status: Status = "done"
    reason: Annotated[str, Field(max_length=20_000)] = ""
    episodes: Number = 0
    successes: Number = 0
    successes_at_end: Number = 0
    safe_successes: Number = 0
    mean_return: float = 0.0
    peak_robot_force: float = 0.0
    train_cpu_s: Seconds = 0.0
    evaluate_cpu_s: Seconds = 0.0
    certificates: tuple[Text, ...] = ()
    command: Annotated[str, Field(max_length=20_000)] = ""
    library: Label = ""
    versions: Mapping[str, str] = Field(default_factory=dict)
    processor: Mapping[str, str] = Field(default_factory=dict)


Record = TypeVar("Record", bound=Model)


def read(file: Path, kind: type[Record]) -> Record:
    """Read one of these files, without trusting its contents.

    Raises:
        UsageError: It is damaged.
        OSError: It cannot be read.
    """
    try:
        return kind.model_validate_json(read_plain(file, LARGEST))
    except ValueError as error:
        raise UsageError(f"{display_path(file)} is damaged: {_first(error)}") from None


def _first(error: ValueError) -> str:
    """What is wrong first, in a line."""
    lines = [line.strip() for line in str(error).splitlines()[1:3]]
    return excerpt(": ".join(lines) or str(error))


def write(file: Path, record: Model) -> None:
    """Write one of these files, whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(file, (record.model_dump_json(indent=1) + "\n").encode(), sync=True)


def read_about(folder: Path) -> About:
    """What a folder holds the results of.

    Raises:
        UsageError: It holds no benchmark, its file is damaged, or it is of another version.
        OSError: It cannot be read.
    """
    file, where = folder / ABOUT, display_path(folder)
    if not file.is_file():
        raise UsageError(
            f"{where} holds no benchmark; taskbuilder benchmark SUITE --track T --algorithm A "
            f"--out {where} makes one"
        )
    version = _version_in(file)
    if version != __version__:
        raise UsageError(
            f"{where} was made by taskbuilder {version}, and this is {__version__}; results of "
            "different versions are not comparable: use that version, or another folder"
        )
    return read(file, About)


def _version_in(file: Path) -> str:
    """The version of taskbuilder that wrote a file; this one, if the file does not say.

    Raises:
        UsageError: The file is damaged.
    """
    try:
        data = parse_json(read_plain(file, LARGEST))
    except ValueError as error:
        raise UsageError(f"{display_path(file)} is damaged: {excerpt(error)}") from None
    return excerpt(data.get("taskbuilder", __version__)) if isinstance(data, dict) else __version__


def begin(folder: Path, about: About) -> About:
    """Write what a folder holds the results of, or go on with the same.

    Returns:
        The same with the seeds of both; the tuning runs that are declared now go before those
        declared earlier.

    Raises:
        UsageError: The folder holds something else, and what differs.
        OSError: It cannot be read or written.
    """
    where = display_path(folder)
    if (folder / ABOUT).exists():
        there = read_about(folder)
        differs = list(_differences(there, about))
        if differs:
            raise UsageError(
                f"{where} holds another benchmark; name another folder\n"
                + "\n".join(f"  {line}" for line in differs)
            )
        seeds = tuple(dict.fromkeys([*there.seeds, *about.seeds]))
        declared = there.tuning_runs if about.tuning_runs is None else about.tuning_runs
        about = there.model_copy(update={"seeds": seeds, "tuning_runs": declared})
    elif strange := sorted(f.name for f in folder.iterdir() if f.name not in (SHARED, LOCK)):
        raise UsageError(
            f"{where} holds other files ({', '.join(strange[:3])}); name a new or empty folder"
        )
    write(folder / ABOUT, about)
    return about


def _differences(there: About, here: About) -> list[str]:
    """In what two benchmarks differ, in words."""
    pairs: Mapping[str, tuple[Any, Any]] = {
        "suite": (there.suite.name, here.suite.name),
        "tasks": (there.suite.labels, here.suite.labels),
        "train variations": (there.suite.train, here.suite.train),
        "test variations": (there.suite.test, here.suite.test),
        "track": (there.track.label, here.track.label),
        "method": (there.method.label, here.method.label),
    }
    found = [f"{name}: {was} there, {now} now" for name, (was, now) in pairs.items() if was != now]
    if not found and there.track != here.track:
        changed = [
            n for n in Track.model_fields if getattr(there.track, n) != getattr(here.track, n)
        ]
        found = [f"track: its {', '.join(changed)} differ"]
    if not found and there.method != here.method:
        found = ["method: the same words in another place"]
    return found


def cell_folder(folder: Path, task: str, seed: int) -> Path:
    """The folder of a cell; a slash in the name of a task is a hyphen."""
    return folder / CELLS / f"{task.replace('/', '-')}-{seed}"


def shared_folder(shared: Path, task: str) -> Path:
    """The folder of the demonstrations of a task."""
    return shared / task.replace("/", "-")


def task_file(folder: Path, task: str) -> Path:
    """In a folder, the record of what all cells of a task share."""
    return folder / f"{task.replace('/', '-')}.json"
