"""Run the families of checks on a task, up to a level."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from taskbuilder.errors import (
    ExplosionError,
    FileError,
    PlacementError,
    UsageError,
    display_path,
)
from taskbuilder.jobs import Map, workers
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.validate.report import Check, FamilyResult, Progress, TaskReport
from taskbuilder.validate.static import static_failure, static_family
from taskbuilder.wording import suggestion

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.validate.running import Run

Level = Literal["static", "build", "full"]
LEVELS: tuple[Level, ...] = ("static", "build", "full")
SEEDS = 40
QUICK_SEEDS = 5

_RUNS = count()


@dataclass(frozen=True)
class Family:
    """A family of checks.

    Attributes:
        name: As reports show it.
        level: The first level that it belongs to.
        check: Makes the checks.
        after: Families that must have found no error for this one to mean anything: what they
            find would show here again.
    """

    name: str
    level: Level
    check: Callable[[Run], FamilyResult]
    after: tuple[str, ...] = ()


def _families() -> tuple[Family, ...]:
    """All families but the static one, in order."""
    # Imported only here: these need the physics engine, which a static check never loads.
    from taskbuilder.validate.build import build_family
    from taskbuilder.validate.contract import contract_family
    from taskbuilder.validate.cost import cost_family
    from taskbuilder.validate.needs import needs_family
    from taskbuilder.validate.pays import pays_family
    from taskbuilder.validate.reach import reach_family
    from taskbuilder.validate.repeat import repeat_family
    from taskbuilder.validate.reset import reset_family
    from taskbuilder.validate.solvable import solvable_family

    return (
        Family("build", "build", build_family),
        Family("reset", "build", reset_family, ("build",)),
        Family("repeat", "full", repeat_family, ("reset",)),
        Family("reach", "full", reach_family, ("reset",)),
        Family("contract", "full", contract_family, ("repeat",)),
        Family("solvable", "full", solvable_family, ("repeat", "reach")),
        Family("needs its robots", "full", needs_family, ("solvable",)),
        Family("pays for success", "full", pays_family, ("solvable",)),
        Family("cost", "full", cost_family, ("repeat",)),
    )


def validate_task(
    reference: str | Path,
    *,
    level: Level = "full",
    seeds: int = SEEDS,
    catalogue: Catalogue | None = None,
    progress: Progress = lambda seeds, _: seeds,
    jobs: int = 1,
    only: Collection[str] | None = None,
) -> TaskReport:
    """Try to break a task.

    Args:
        reference: Its name in the catalogue, or the path of its YAML file.
        level: ``static`` (no physics), ``build``, or ``full``.
        seeds: How many episodes to sample where chance is involved.
        catalogue: Where names are looked up; by default that of this installation.
        progress: Wraps the seeds of a family to show progress.
        jobs: How many processes play episodes; the results do not depend on it.
        only: Names of families: no others are run, not even those whose errors would show in them.

    Raises:
        UnknownNameError: There is no such task.
        UsageError: There is no such family.
    """
    catalogue = catalogue or Catalogue.discover()
    started = time.perf_counter()
    try:
        task = load_task(reference, catalogue=catalogue, guarded=True)
    except FileError as error:
        failure = _timed(static_failure(error.findings), started)
        return TaskReport(str(reference), str(reference), (failure,))
    static = _timed(static_family(task), started)
    if level == "static":
        return TaskReport(task.name, headline(task), (static,))
    with workers(jobs if level == "full" else 1) as spread:
        spread(get_ready, range(jobs))  # they load what they need while this process does
        families = _wanted(level, only)
        return _play(task, str(reference), catalogue, static, families, seeds, progress, spread)


def get_ready(number: int) -> int:
    """Load, in another process, what playing a task takes."""
    import_module("taskbuilder.validate.running")
    return number


def _wanted(level: Level, only: Collection[str] | None) -> tuple[Family, ...]:
    """The families of a level, or some of them.

    Raises:
        UsageError: There is none of a name.
    """
    known = {family.name: family for family in _families() if level in ("full", family.level)}
    for name in only or ():
        if name not in known:
            raise UsageError(f'no family "{name}"; {suggestion(name, known, what="there are")}')
    return tuple(family for name, family in known.items() if only is None or name in only)


def _play(
    task: Task,
    reference: str,
    catalogue: Catalogue,
    static: FamilyResult,
    families: tuple[Family, ...],
    seeds: int,
    progress: Progress,
    spread: Map,
) -> TaskReport:
    """Run the families that need physics."""
    from taskbuilder.validate.running import Run
    from taskbuilder.validate.studio import Source, close_studio

    source = Source(reference, catalogue, next(_RUNS))
    results = [static]
    skipped: list[str] = []
    try:
        run = Run(task, source, seeds, progress, spread)
        for result in _results(run, families):
            results += [result] if isinstance(result, FamilyResult) else []
            skipped += [result] if isinstance(result, str) else []
    finally:
        close_studio(source)
    return TaskReport(task.name, headline(task), tuple(results), run.measures, tuple(skipped))


def _results(run: Run, families: tuple[Family, ...]) -> Iterator[FamilyResult | str]:
    """The result of each family, or the name of one that is not run."""
    troubled: set[str] = set()
    raised = False
    for family in families:
        if raised or troubled & set(family.after):
            troubled.add(family.name)
            yield family.name
            continue
        started = time.perf_counter()
        result = _timed(_checked(run, family), started)
        if not result.ok:
            troubled.add(family.name)
        raised = any(finding.code == "TB314" for finding in result.findings)
        yield result


def _checked(run: Run, family: Family) -> FamilyResult:
    """A family's result; what a description raises meanwhile is a finding of it."""
    from taskbuilder.validate.places import failure_of_description, finding_at, finding_of_scene
    from taskbuilder.validate.studio import DescriptionError

    try:
        return family.check(run)
    except PlacementError as error:  # from a seed that the reset family did not come to
        place = error.findings[0]
        finding = finding_at(run.task, "TB305", place.message, place.path, "place")
        check = Check("TB305", "everything finds a place", False, 1, 0, "things")
        return FamilyResult(family.name, (check,), (finding,), "something finds no place")
    except ExplosionError as error:
        finding = finding_of_scene(run.task, "TB307", str(error))
        check = Check("TB307", "the physics stays bounded", False, 1, 0, "episodes")
        return FamilyResult(family.name, (check,), (finding,), "the physics diverged")
    except DescriptionError as error:
        finding = error.finding
    except (Exception, SystemExit) as error:
        finding = failure_of_description(error, run.task.file.entry)
    check = Check("TB314", "the description can be asked", False, 1, 0, "things")
    return FamilyResult(family.name, (check,), (finding,), "the description fails")


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
