"""Run the families of checks on a task, up to a level."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

from taskbuilder.errors import FileError, display_path
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.validate.report import FamilyResult, Progress, TaskReport
from taskbuilder.validate.static import static_failure, static_family

Level = Literal["static", "build", "full"]
LEVELS: tuple[Level, ...] = ("static", "build", "full")
SEEDS = 40
QUICK_SEEDS = 5

Family = Callable[[Task, int, Progress, dict[str, float]], FamilyResult]
"""Checks a task over so many seeds; adds what it measures to the last argument."""


def _families(level: Level) -> tuple[Family, ...]:
    """The families that a level adds to the static one, in order."""
    if level == "static":
        return ()
    # Imported only here: these need the physics engine, which a static check never loads.
    from taskbuilder.validate.build import build_family
    from taskbuilder.validate.reset import reset_family

    built: tuple[Family, ...] = (build_family, reset_family)
    proofs: tuple[Family, ...] = ()  # what only level full adds
    return built + (proofs if level == "full" else ())


def validate_task(
    reference: str | Path,
    *,
    level: Level = "full",
    seeds: int = SEEDS,
    catalogue: Catalogue | None = None,
    progress: Progress = lambda seeds, _: seeds,
) -> TaskReport:
    """Try to break a task.

    Args:
        reference: Its name in the catalogue, or the path of its YAML file.
        level: ``static`` (no physics), ``build``, or ``full``.
        seeds: How many episodes to sample where chance is involved.
        catalogue: Where names are looked up; by default that of this installation.
        progress: Wraps the seeds of a family to show progress.

    Raises:
        UnknownNameError: There is no such task.
    """
    catalogue = catalogue or Catalogue.discover()
    started = time.perf_counter()
    try:
        task = load_task(reference, catalogue=catalogue, guarded=True)
    except FileError as error:
        failure = _timed(static_failure(error.findings), started)
        return TaskReport(str(reference), str(reference), (failure,))
    results = [_timed(static_family(task), started)]
    measures: dict[str, float] = {}
    for family in _families(level):
        started = time.perf_counter()
        result = _timed(family(task, seeds, progress, measures), started)
        results.append(result)
        if not result.ok:
            break  # what comes later would report the same again
    return TaskReport(task.name, headline(task), tuple(results), measures)


def headline(task: Task) -> str:
    """A task in one line: name, size, length, file."""
    spec = task.file.spec
    robots, objects = len(spec.scene.robots), len(spec.scene.objects)
    return " · ".join(
        (
            task.name,
            f"{robots} robot{'s' * (robots != 1)}",
            f"{objects} object{'s' * (objects != 1)}",
            f"{spec.timing.episode_steps} steps at {spec.timing.control_hz} Hz",
            display_path(task.file.entry.file),
        )
    )


def _timed(result: FamilyResult, started: float) -> FamilyResult:
    return replace(result, seconds=time.perf_counter() - started)
