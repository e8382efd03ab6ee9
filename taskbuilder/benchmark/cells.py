"""The work of a benchmark: what the cells of a task share, and the cells, each in its own folder.

Everything is written whole or not at all, so that a benchmark that was killed goes on where it was:
what is there is not done again, a training run is resumed, and what failed is tried again.
"""

from __future__ import annotations

import shlex
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

from taskbuilder.benchmark.demonstrators import demonstrator
from taskbuilder.benchmark.records import (
    CELL,
    TASKS,
    About,
    BaselineRecord,
    CellRecord,
    Seconds,
    TaskRecord,
    cell_folder,
    read,
    shared_folder,
    task_file,
    write,
)
from taskbuilder.benchmark.tracks import Track
from taskbuilder.cluster import library_digest
from taskbuilder.data.collection import collect
from taskbuilder.env.options import EnvOptions
from taskbuilder.errors import TaskbuilderError, UsageError, display_path
from taskbuilder.evaluation.assessment import evaluate
from taskbuilder.evaluation.summary import EvaluationSummary
from taskbuilder.expert.script.player import has_expert
from taskbuilder.learn import run_folders, runs
from taskbuilder.machine import processor, versions
from taskbuilder.policies.grammar import PolicyLike, parse_policy
from taskbuilder.policies.runs import RUN_FILE
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.values import Model
from taskbuilder.task import Task, load_task

RUN, TRACE = "run", "error.txt"
"""In the folder of a cell: the training run, and where the error arose that ended it."""

_TOLD_EVERY_S = 5.0  # of CPU time, between notes of how much there was


@dataclass(frozen=True)
class Work:
    """What every piece of work of a benchmark needs; other processes can be told.

    Attributes:
        about: The suite, the track and the method.
        folder: Folder of the benchmark.
        shared: Folder of what methods share.
        catalogue: Where tasks are looked up.
        policy: The policy of the method, if it is no text.
    """

    about: About
    folder: Path
    shared: Path
    catalogue: Catalogue
    policy: Any = None


class Cell(NamedTuple):
    """A task and a seed."""

    task: str
    seed: int


# --- what cells share


def share(work: Work, task: str) -> TaskRecord:
    """Collect the demonstrations of a task and play its baselines, unless they are there.

    Raises:
        UsageError: What is there is of another track, or damaged.
        OSError: Something cannot be written.
    """
    about = work.about
    file = task_file(work.shared, task)
    record = TaskRecord(task=task, track=about.track.label)
    if file.exists():
        record = read(file, TaskRecord).model_copy(update={"reason": ""})
    if record.track != about.track.label:
        raise UsageError(
            f"{display_path(work.shared)} is shared by methods on the track {record.track}, and "
            f"this is {about.track.label}; name another folder to share"
        )
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        loaded = load_task(task, catalogue=work.catalogue)
        _check(about, loaded)
        if about.method.algorithm and not record.demonstrations:
            record = record.model_copy(update=_collected(work, task, loaded))
        if not record.baselines:
            record = record.model_copy(update={"baselines": _baselines(work, loaded)})
    except TaskbuilderError as error:
        record = record.model_copy(update={"reason": str(error)})
    write(file, record)
    own = task_file(work.folder / TASKS, task)
    own.parent.mkdir(exist_ok=True)
    write(own, record)
    return record


def _check(about: About, task: Task) -> None:
    """Refuse a task that the track cannot have.

    Raises:
        UsageError: So it is.
    """
    track, scene = about.track, task.file.spec.scene
    if track.demonstrations and not has_expert(task):
        raise UsageError(
            f"{task.name} has no expert, and the track {track.name} needs its demonstrations"
        )
    if len(scene.cameras) < track.cameras:
        raise UsageError(
            f"{task.name} has {len(scene.cameras)} cameras, and the track {track.name} needs "
            f"{track.cameras}"
        )
    wanted, last = max(about.suite.train + about.suite.test), len(task.file.scenes) - 1
    if wanted > last:
        raise UsageError(
            f"{task.name} has no variation {wanted}, which the suite {about.suite.name} needs; its "
            f"last is {last}"
        )


def _cameras(track: Track, task: Task) -> tuple[str, ...]:
    return tuple(task.file.spec.scene.cameras)[: track.cameras]


def _collected(work: Work, task: str, loaded: Task) -> dict[str, Any]:
    """Collect demonstrations; their number, and the CPU time that they took."""
    about, track = work.about, work.about.track
    if track.demonstrations is None:
        return {}
    folder = shared_folder(work.shared, task)
    clock = Clock(folder.with_name(f".{folder.name}.cpu.json"))
    options: EnvOptions = {**track.options}
    if track.cameras:
        options["cameras"] = _cameras(track, loaded)
        options["camera_size"] = track.camera_size
    expert = demonstrator(loaded, track.demonstrations, about.suite.train[0], work.catalogue)
    dataset = collect(
        loaded,
        folder,
        policy=expert,
        episodes=track.demonstrations.episodes,
        variations=about.suite.train,
        first_seed=track.demonstrations.first_seed,
        jobs=1,
        report=clock.note,
        catalogue=work.catalogue,
        **options,
    )
    return {"demonstrations": len(dataset), "demonstrator": expert, "cpu_s": clock.stop()}


def _baselines(work: Work, task: Task) -> dict[str, BaselineRecord]:
    """What the expert and random actions achieve in the first episodes of the evaluation."""
    track, variation = work.about.track, work.about.suite.test[0]
    found: dict[str, BaselineRecord] = {}
    for name in ("expert", "random") if has_expert(task) else ("random",):
        result = _evaluated(work, name, task, variation, track.baseline_episodes)
        found[name] = BaselineRecord(
            episodes=result.episodes,
            successes_at_end=result.successes_at_end,
            mean_return=result.mean_return,
        )
    return found


# --- cells


def run_cell(work: Work, cell: Cell) -> CellRecord:
    """Train and evaluate, or go on, unless that has been done; whatever fails is recorded.

    Raises:
        UsageError: The record of the cell is damaged.
        OSError: The record cannot be written.
    """
    folder = cell_folder(work.folder, *cell)
    file = folder / CELL
    if file.exists() and (there := read(file, CellRecord)).status == "done":
        return there
    folder.mkdir(parents=True, exist_ok=True)
    (folder / TRACE).unlink(missing_ok=True)
    known: dict[str, Any] = {
        "task": cell.task,
        "seed": cell.seed,
        "command": command_of(work.about, cell),
        "library": library_digest(),
        "versions": versions(),
        "processor": processor(),
    }
    shared = read(task_file(work.folder / TASKS, cell.task), TaskRecord)
    if shared.reason:
        record = CellRecord(**known, status="impossible", reason=shared.reason)
    else:
        try:
            record = CellRecord(**known, **_measured(work, cell, folder))
        except TaskbuilderError as error:
            record = CellRecord(**known, status="failed", reason=str(error))
        except Exception as error:  # of an algorithm or a policy of anybody's
            (folder / TRACE).write_text("".join(traceback.format_exception(error)))
            reason = f"{type(error).__name__}: {error}"
            record = CellRecord(**known, status="failed", reason=reason)
    write(file, record)
    return record


def lost(work: Work, cell: Cell, reason: str) -> CellRecord:
    """Record that a cell took the process with it that worked on it."""
    folder = cell_folder(work.folder, *cell)
    folder.mkdir(parents=True, exist_ok=True)
    record = CellRecord(task=cell.task, seed=cell.seed, status="failed", reason=reason)
    write(folder / CELL, record)
    return record


def command_of(about: About, cell: Cell | None = None) -> str:
    """The command that repeats a cell alone, or the whole benchmark; "" if there is none."""
    track, method = about.track, about.method
    if not (track.is_official or track.smoke):
        return ""
    words = ["taskbuilder", "benchmark", about.suite.name, "--track", track.name]
    if method.policy:
        words += ["--policy", method.policy]
    else:
        words += ["--algorithm", method.algorithm]
    words += ["--preset", method.preset] if method.preset else []
    words += ["--set", *method.settings] if method.settings else []
    if method.algorithm or "{seed}" in method.policy:
        words += ["--seeds", *map(str, [cell.seed] if cell else about.seeds)]
    words += ["--only", cell.task] if cell else []
    words += ["--smoke"] if track.smoke else []
    return shlex.join([*words, "--out", "repeated"])


def _measured(work: Work, cell: Cell, folder: Path) -> dict[str, Any]:
    """The figures of a cell."""
    about = work.about
    task = load_task(cell.task, catalogue=work.catalogue)
    train_cpu_s = 0.0
    policy: PolicyLike
    if about.method.algorithm:
        train_cpu_s = _train(work, cell, task, folder)
        policy = str(folder / RUN)
    else:
        policy = policy_of(work, cell)
    clock = Clock()
    player = parse_policy(policy)
    repeatable = player.is_word or player.file is not None
    results: list[EvaluationSummary] = []
    certificates: list[str] = []
    for variation in about.suite.test:
        name = f"certificate-{variation}.json"
        file = folder / name if repeatable else None
        results.append(_evaluated(work, policy, task, variation, about.track.episodes, file))
        certificates += [name] if repeatable else []
    episodes = [episode for result in results for episode in result.rollouts]
    safe = [e for e in episodes if (e.peak_robot_force or 0.0) <= about.track.safe_force]
    return {
        "episodes": len(episodes),
        "successes": sum(e.success for e in episodes),
        "successes_at_end": sum(e.success_at_end for e in episodes),
        "safe_successes": sum(e.success_at_end for e in safe),
        "mean_return": fmean(e.team_return for e in episodes),
        "peak_robot_force": max(e.peak_robot_force or 0.0 for e in episodes),
        "train_cpu_s": train_cpu_s,
        "evaluate_cpu_s": clock.stop(),
        "certificates": tuple(certificates),
    }


def policy_of(work: Work, cell: Cell) -> PolicyLike:
    """The policy of a method that has policies."""
    if work.policy is not None:
        own: PolicyLike = work.policy
        return own
    text = work.about.method.policy.replace("{task}", cell.task)
    return text.replace("{seed}", str(cell.seed))


def _evaluated(
    work: Work,
    policy: PolicyLike,
    task: Task,
    variation: int,
    episodes: int,
    certificate: Path | None = None,
) -> EvaluationSummary:
    return evaluate(
        policy,
        episodes,
        task=task,
        first_seed=work.about.track.first_seed,
        certificate=certificate,
        jobs=1,
        catalogue=work.catalogue,
        variation=variation,
    )


def _train(work: Work, cell: Cell, task: Task, folder: Path) -> float:
    """Train, or go on; the CPU time that it took, in seconds."""
    clock, run = Clock(folder / "cpu.json"), folder / RUN
    if (run / RUN_FILE).exists():
        found = runs.find(run, work.catalogue)
        with run_folders.locked(run, new=False):
            runs.go_on(run, found, clock.note)
        return clock.stop()
    track, method = work.about.track, work.about.method
    budget = track.training
    given: dict[str, Any] = {
        "algorithm": method.algorithm,
        "preset": method.preset or None,
        "seed": cell.seed,
        "steps": budget.steps,
        "evaluate_every": budget.evaluate_every,
        "checkpoint_every": budget.evaluate_every,
        "evaluate_episodes": budget.evaluate_episodes,
        "film_every": 0,
    }
    if track.demonstrations:
        given["data"] = shared_folder(work.shared, cell.task)
        given["cameras"] = _cameras(track, task) or None
    else:
        given |= {**track.options, "variation": work.about.suite.train[0]}
    planned = runs.set_up(task, method.settings, catalogue=work.catalogue, **given)
    with run_folders.locked(run, new=True):
        command = command_of(work.about, cell)
        planned = runs.create(run, planned, command=command, catalogue=work.catalogue)
        runs.go_on(run, planned, clock.note)
    return clock.stop()


# --- CPU time


class _Spent(Model):
    cpu_s: Seconds


class Clock:
    """Adds up the CPU time of a piece of work over all processes that have worked on it.

    Args:
        file: Where it is noted now and then, for whoever goes on if this process is killed; without
            it, only this process counts.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._before = read(file, _Spent).cpu_s if file and file.exists() else 0.0
        self._since = self._noted = time.process_time()

    def note(self, _: object = None) -> None:
        """Note how much there has been, if that is more than a little since the last note."""
        if time.process_time() - self._noted > _TOLD_EVERY_S:
            self._noted = time.process_time()
            self.stop()

    def stop(self) -> float:
        """Note and return the CPU time so far, in seconds."""
        total = self._before + time.process_time() - self._since
        if self._file:
            write(self._file, _Spent(cpu_s=total))
        return total


Report = Callable[[CellRecord], None]
"""Called with the record of every cell."""
