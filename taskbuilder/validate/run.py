"""Run the families of checks on a task, up to a level."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.description.load import is_interrupt, load_description
from taskbuilder.errors import (
    ExplosionError,
    FileError,
    PlacementError,
    UsageError,
    display_path,
)
from taskbuilder.jobs import LostError, Map, workers
from taskbuilder.processes import owned
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.validate.apart import (
    CHECK,
    IMPORT,
    Kept,
    Level,
    Listener,
    Nobody,
    Orders,
    Owner,
    watch,
)
from taskbuilder.validate.losses import finding_of_loss, lost_family
from taskbuilder.validate.making import Stopwatch
from taskbuilder.validate.report import Check, FamilyResult, Progress, TaskReport
from taskbuilder.validate.static import static_failure, static_family
from taskbuilder.wording import suggestion

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.validate.running import Run

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
    apart: bool = True,
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
        apart: Load and play the task in processes of their own alone, which its description can
            end, crash or hold up without harm. In this one it can be debugged.

    Raises:
        UnknownNameError: There is no such task.
        UsageError: There is no such family.
    """
    catalogue = catalogue or Catalogue.discover()
    wanted = None if only is None else tuple(only)
    orders = Orders(str(reference), level, seeds, catalogue, jobs, wanted)
    watched = Stopwatch()
    if apart:
        report = watch(_validated_apart, orders, progress)
    else:
        report = _validated(orders, Nobody(progress))
    return replace(report, making=watched.making(level, seeds))


def _validated_apart(orders: Orders) -> TaskReport:
    return _validated(orders, Owner())


def _validated(orders: Orders, listener: Listener) -> TaskReport:
    started = time.perf_counter()
    try:
        task = _loaded(orders, listener)
    except FileError as error:
        failure = _timed(static_failure(error.findings), started)
        return TaskReport(orders.reference, orders.reference, (failure,))
    static = _timed(static_family(task), started)
    if orders.level == "static":
        return TaskReport(task.name, headline(task), (static,))
    limit_s = orders.limits.piece(task.file.spec.timing.episode_steps)
    with workers(
        orders.jobs if orders.level == "full" else 1,
        limit_s=limit_s,
        beat=listener.alive,
        prepared="taskbuilder.validate.running",  # while this process does
    ) as spread:
        families = _wanted(orders.level, orders.only)
        return _play(task, orders, static, families, listener, spread, limit_s)


def _loaded(orders: Orders, listener: Listener) -> Task:
    """The task; its description is imported first, so that what it does then can be told."""
    if not owned():
        return load_task(orders.reference, catalogue=orders.catalogue, guarded=True)
    entry = orders.catalogue.task(orders.reference)
    listener.begin(IMPORT, orders.limits.import_s)
    with suppress(FileError):  # what is wrong is found with all the rest
        load_description(entry)
    listener.begin(CHECK, orders.limits.import_s)
    return load_task(orders.reference, catalogue=orders.catalogue)


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
    orders: Orders,
    static: FamilyResult,
    families: tuple[Family, ...],
    listener: Listener,
    spread: Map,
    limit_s: float,
) -> TaskReport:
    """Run the families that need physics."""
    from taskbuilder.validate.running import Run
    from taskbuilder.validate.studio import Source, close_studio

    source = Source(orders.reference, orders.catalogue, next(_RUNS))
    run = Run(task, source, orders.seeds, listener.progress, spread, limit_s, listener.alive)
    report = TaskReport(task.name, headline(task), (static,), run.measures)
    if orders.kept:
        report = orders.kept.report
        run.take_over(orders.kept.state)
    else:
        listener.done(Kept(report, run.state))
    done = {*report.skipped, *(family.name for family in report.families)}
    try:
        for number, family in enumerate(families):
            if family.name in done:
                continue
            rest = tuple(later.name for later in families[number + 1 :])
            listener.begin(family.name, limit_s, rest)
            report = replace(_with(report, run, family), measures=run.measures)
            listener.done(Kept(report, run.state))
    finally:
        close_studio(source)
    return report


FATAL = ("TB314", "TB315")
"""Codes of findings that no other family would get past."""


def _with(report: TaskReport, run: Run, family: Family) -> TaskReport:
    """A report with the result of one more family, or its name if it is not run."""
    fatal = any(finding.code in FATAL for finding in report.findings)
    wrong = {*report.skipped, *(found.name for found in report.families if not found.ok)}
    if fatal or wrong & set(family.after):
        return replace(report, skipped=(*report.skipped, family.name))
    started = time.perf_counter()
    result = _timed(_checked(run, family), started)
    return replace(report, families=(*report.families, result))


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
    except LostError as error:
        return lost_family(family.name, finding_of_loss(error.fault, run.task.file.entry))
    except DescriptionError as error:
        finding = error.finding
    except BaseException as error:
        if is_interrupt(error):
            raise
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
