"""The results of a benchmark: read from its folder, summed up by task and over the suite."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.benchmark.records import (
    CELL,
    TASKS,
    About,
    CellRecord,
    TaskRecord,
    cell_folder,
    read,
    read_about,
    task_file,
)
from taskbuilder.benchmark.statistics import (
    SCORES,
    Banded,
    interquartile_mean,
    performance_profile,
)
from taskbuilder.errors import UsageError, display_path
from taskbuilder.intervals import wilson


@dataclass(frozen=True)
class TaskResult:
    """What a method achieves on a task.

    Attributes:
        task: The task.
        cells: The records of its cells, in the order of the seeds; None where there is none yet.
        shared: What the cells share; None if it is not there.
        development: Whether methods may be tuned on the task.
        cpu_limit_s: The track's limit of the CPU time of a training run, in seconds.
    """

    task: str
    cells: tuple[CellRecord | None, ...]
    shared: TaskRecord | None
    development: bool
    cpu_limit_s: float

    @property
    def there(self) -> tuple[CellRecord, ...]:
        """The cells that have been finished."""
        return tuple(cell for cell in self.cells if cell is not None)

    @property
    def impossible(self) -> bool:
        """Whether the track cannot have the task, which no figure of the suite counts."""
        return any(cell.status == "impossible" for cell in self.there)

    @property
    def scores(self) -> tuple[float, ...]:
        """Success at the last step of every finished cell; that of a failed cell is 0."""
        return tuple(map(success_at_end, self.there))

    @property
    def median(self) -> CellRecord | None:
        """The cell of the median seed by success at the last step; the lower of two."""
        ordered = sorted(self.there, key=lambda cell: (success_at_end(cell), cell.seed))
        return ordered[(len(ordered) - 1) // 2] if ordered else None

    @property
    def reason(self) -> str:
        """Why a cell failed or is impossible, or "" if all went well."""
        return next((cell.reason for cell in self.there if cell.status != "done"), "")

    @property
    def over_budget(self) -> bool:
        """Whether a training run took more CPU time than the track allows."""
        return any(cell.train_cpu_s > self.cpu_limit_s for cell in self.there)


def success_at_end(cell: CellRecord) -> float:
    """The fraction of a cell's episodes in which success held at the last step; 0 if it failed."""
    return cell.successes_at_end / cell.episodes if cell.episodes else 0.0


def safe_success(cell: CellRecord) -> float:
    """The fraction of a cell's episodes with safe success; 0 if it failed."""
    return cell.safe_successes / cell.episodes if cell.episodes else 0.0


@dataclass(frozen=True)
class MethodResults:
    """What a method achieves on a suite.

    Attributes:
        folder: The folder of the benchmark.
        name: The method in a few words, different from those beside it.
        about: The suite, the track and the method.
        tasks: The results by task, in the order of the suite.
    """

    folder: Path
    name: str
    about: About
    tasks: tuple[TaskResult, ...]

    @property
    def missing(self) -> int:
        """Number of cells that have not been finished."""
        return sum(len(each.cells) - len(each.there) for each in self.tasks)

    @property
    def problems(self) -> tuple[TaskResult, ...]:
        """The tasks of which a cell failed or is impossible."""
        return tuple(each for each in self.tasks if each.reason)

    def scores(self, *, without_development: bool = False) -> list[tuple[float, ...]]:
        """The scores of the runs of each task that the track can have."""
        return [
            each.scores
            for each in self.tasks
            if not each.impossible and not (without_development and each.development)
        ]

    def interquartile_mean(self, *, without_development: bool = False) -> Banded | None:
        """Of the scores of all cells; None if cells are missing, or there are no such tasks."""
        scores = self.scores(without_development=without_development)
        return interquartile_mean(scores) if scores and not self.missing else None

    def profile(self) -> Banded | None:
        """The performance profile; None if cells are missing, or there are no tasks."""
        scores = self.scores()
        return performance_profile(scores) if scores and not self.missing else None

    @property
    def tuning_runs(self) -> str:
        """The declared number of tuning runs, as tables show it."""
        told = self.about.tuning_runs
        return "not declared" if told is None else str(told)

    @property
    def states(self) -> frozenset[str]:
        """Digests of the states of taskbuilder that made the cells; one, unless it was changed."""
        return frozenset(c.library for each in self.tasks for c in each.there if c.library)


def read_results(folder: Path) -> MethodResults:
    """Read the results of a method, as far as they are there.

    Args:
        folder: The folder of the benchmark.

    Raises:
        UsageError: It holds no benchmark, or a file is damaged or of another version.
        OSError: A file cannot be read.
    """
    about = read_about(folder)
    tasks = []
    for task in about.suite.tasks:
        cells = []
        for seed in about.seeds:
            file = cell_folder(folder, task, seed) / CELL
            cells.append(_cell(file, task, seed) if file.exists() else None)
        file = task_file(folder / TASKS, task)
        tasks.append(
            TaskResult(
                task,
                tuple(cells),
                read(file, TaskRecord) if file.exists() else None,
                task in about.track.development,
                60.0 * about.track.training.cpu_minutes,
            )
        )
    return MethodResults(folder, about.method.label, about, tuple(tasks))


def _cell(file: Path, task: str, seed: int) -> CellRecord:
    """The record of a cell.

    Raises:
        UsageError: It is damaged, or that of another cell.
    """
    cell = read(file, CellRecord)
    if (cell.task, cell.seed) != (task, seed):
        raise UsageError(
            f"{display_path(file)} is of {cell.task}, seed {cell.seed}, and not of {task}, seed "
            f"{seed}; remove it, and run the benchmark again"
        )
    if not cell.safe_successes <= cell.successes_at_end <= cell.successes <= cell.episodes:
        raise UsageError(f"{display_path(file)} is damaged: it has more successes than episodes")
    return cell


def read_several(folders: Sequence[Path]) -> list[MethodResults]:
    """Read the results of several methods, to be shown side by side.

    Raises:
        UsageError: They are of different suites or tracks, or one cannot be read.
        OSError: A file cannot be read.
    """
    read_once = {folder.resolve(): folder for folder in folders}
    several = [read_results(folder) for folder in read_once.values()]
    first = several[0].about
    for other in several[1:]:
        what = (first.suite, first.track) != (other.about.suite, other.about.track)
        if what:
            ours, theirs = (f"{a.suite.name} ({a.track.label})" for a in (first, other.about))
            raise UsageError(
                f"{display_path(several[0].folder)} is of {ours}, and {display_path(other.folder)} "
                f"of {theirs}; only results of the same suite and track are comparable"
                + ("" if ours != theirs else ": their tasks, variations or budgets differ")
            )
    names = [each.name for each in several]
    return [
        each
        if names.count(each.name) == 1
        else MethodResults(
            each.folder, f"{each.name} ({each.folder.resolve().name})", each.about, each.tasks
        )
        for each in several
    ]


# --- as files


def as_data(several: Sequence[MethodResults]) -> dict[str, Any]:
    """The results of methods as plain data."""
    about = several[0].about
    return {
        "kind": "taskbuilder benchmark",
        "suite": about.suite.model_dump(mode="json"),
        "track": about.track.model_dump(mode="json"),
        "comparable": about.track.is_official,
        "methods": [_method(each) for each in several],
    }


def _method(results: MethodResults) -> dict[str, Any]:
    about = results.about
    profile = results.profile()
    return {
        "name": results.name,
        "method": about.method.model_dump(mode="json"),
        "tuning_runs": about.tuning_runs,
        "taskbuilder": about.taskbuilder,
        "seeds": list(about.seeds),
        "missing_cells": results.missing,
        "interquartile_mean": _figure(results.interquartile_mean()),
        "interquartile_mean_without_development_tasks": _figure(
            results.interquartile_mean(without_development=True)
        ),
        "profile": profile and {"scores": SCORES.tolist(), **_figure(profile)},
        "tasks": [_task(each) for each in results.tasks],
    }


def _figure(found: Banded | None) -> Any:
    if found is None:
        return None
    ends = {"low": found.low, "high": found.high}
    return {
        "value": found.value.tolist(),
        **{name: None if end is None else end.tolist() for name, end in ends.items()},
    }


def _task(result: TaskResult) -> dict[str, Any]:
    median, shared = result.median, result.shared
    return {
        "task": result.task,
        "development": result.development,
        "median_seed": median.seed if median else None,
        "success_at_end_rate": success_at_end(median) if median else None,
        "interval_at_end": list(interval(median)) if median and median.episodes else None,
        "safe_success_rate": safe_success(median) if median else None,
        "over_budget": result.over_budget,
        "demonstrator": shared.demonstrator if shared else None,
        "collect_cpu_s": shared.cpu_s if shared else None,
        "baselines": {n: b.model_dump() for n, b in shared.baselines.items()} if shared else {},
        "cells": [cell.model_dump(mode="json") for cell in result.there],
    }


def interval(cell: CellRecord) -> tuple[float, float]:
    """The 95 % Wilson interval of a cell's success at the last step."""
    return wilson(cell.successes_at_end, cell.episodes)


def as_csv(several: Sequence[MethodResults]) -> str:
    """A row for each cell of each method."""
    text = io.StringIO()
    rows = [row for results in several for row in _rows(results)]
    columns = list(rows[0]) if rows else ["method"]
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _rows(results: MethodResults) -> Iterator[Mapping[str, Any]]:
    about = results.about
    for each in results.tasks:
        for cell in each.there:
            low, high = interval(cell) if cell.episodes else ("", "")
            yield {
                "method": results.name,
                "suite": about.suite.name,
                "track": about.track.name,
                "version": about.track.version,
                "comparable": about.track.is_official,
                "tuning_runs": "" if about.tuning_runs is None else about.tuning_runs,
                "task": cell.task,
                "task_version": about.suite.version(cell.task),
                "development": each.development,
                "seed": cell.seed,
                "status": cell.status,
                "episodes": cell.episodes,
                "success_at_end": success_at_end(cell),
                "low": low,
                "high": high,
                "success": cell.successes / cell.episodes if cell.episodes else 0.0,
                "safe_success": safe_success(cell),
                "mean_return": cell.mean_return,
                "peak_robot_force_n": cell.peak_robot_force,
                "collect_cpu_s": each.shared.cpu_s if each.shared else "",
                "train_cpu_s": cell.train_cpu_s,
                "evaluate_cpu_s": cell.evaluate_cpu_s,
                "over_budget": cell.train_cpu_s > each.cpu_limit_s,
                "reason": cell.reason,
            }
