"""Run the families of checks on a task, up to a level."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from taskbuilder.description.load import is_interrupt, load_description
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import Options, ValidationOptions, make_options
from taskbuilder.errors import (
    ExplosionError,
    FileError,
    Location,
    PlacementError,
    TaskbuilderError,
    display_path,
)
from taskbuilder.geometry import total
from taskbuilder.jobs import LostError, Map, workers
from taskbuilder.processes import CHILDREN, owned
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.grasping import grasp_rules
from taskbuilder.schema.proofs import checksum
from taskbuilder.task import Task
from taskbuilder.validate.apart import (
    CHECK,
    IMPORT,
    Kept,
    Level,
    Listener,
    Nobody,
    Owner,
    ValidationConfig,
    watch,
)
from taskbuilder.validate.broken import broken_family
from taskbuilder.validate.checks.static import static_failure, static_family
from taskbuilder.validate.families import OWN_FAMILIES, Family, families_of
from taskbuilder.validate.foreign_checks import foreign_families
from taskbuilder.validate.losses import finding_of_loss, lost_family
from taskbuilder.validate.making import Stopwatch
from taskbuilder.validate.report import Check, FamilyResult, Progress, TaskReport
from taskbuilder.validate.resuming import PartialResult

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.validate.context import Context

SEEDS = 40
QUICK_SEEDS = 5

_RUNS = count()


@takes_options
def validate_task(
    reference: str | Path | Task,
    *,
    level: Level = "full",
    seeds: int = SEEDS,
    catalogue: Catalogue | None = None,
    progress: Progress = lambda seeds, _: seeds,
    jobs: int = 1,
    only: Collection[str] | None = None,
    apart: bool = True,
    keep: bool = False,
    resume: bool = False,
    after_family: Callable[[TaskReport], None] = lambda _: None,
    **options: Unpack[ValidationOptions],
) -> TaskReport:
    """Validate a task.

    Args:
        reference: Name of the task, path of its YAML file, or a loaded task, with the robots and
            the rule of grasping that it was loaded with.
        level: Which checks to run: ``static`` (checks of the files, without physics), ``build``
            (also checks that build and reset the scene), or ``full`` (all checks).
        seeds: Number of seeds per variation.
        catalogue: Catalogue in which to look up names; by default the catalogue of this
            installation.
        progress: Function that wraps an iterable, to display a progress bar. It is called with
            two arguments, the seeds or variations that a family of checks goes through and a label,
            and must return an iterable of the same seeds or variations.
        jobs: Number of processes that play episodes; the results do not depend on this number.
        only: Names of the families of checks to run in addition to the static checks; by default
            all families of the level.
        apart: Whether to load and play the task only in child processes, where a crash or hang does
            no harm. Use False to debug a description in this process. Without a POSIX system,
            there are no such child processes, and the task is played in this one.
        keep: Whether to write the results to the user's cache folder after each family of checks,
            so that a later call with ``resume=True`` can continue from there.
        resume: Whether to continue an interrupted call with the same arguments. If the task file or
            the description has changed since, the validation starts anew.
        after_family: Called with the report so far after each family of checks.
        options: Options of all environments of the task; see `Options`.

    Raises:
        UnknownNameError: There is no such task, or ``robots`` names an unknown model.
        UsageError: ``only`` names an unknown family, or an option does not fit the task.
    """
    if isinstance(reference, Task):
        catalogue = catalogue or reference.file.catalogue
        options["robots"] = {**dict(reference.robots), **dict(options.get("robots", ()))}
        if options.get("grasp", "task") == "task":
            options["grasp"] = reference.grasp
        reference = reference.reference
    catalogue = catalogue or Catalogue.discover()
    wanted = None if only is None else tuple(only)
    if wanted:
        families_of(level, wanted)  # a wrong name is refused before anything takes its time
    config = ValidationConfig(
        str(reference), level, seeds, catalogue, jobs, wanted, options=make_options(**options)
    )
    watched, summed = Stopwatch(), _checksum(config)
    found = _partial(config) if keep or resume else None
    if found and resume:
        config = replace(config, kept=found.load()[0])
    before = total(family.seconds for family in config.kept.report.families) if config.kept else 0.0
    save = found.save if found and keep else _forget

    def save_and_tell(kept: Kept) -> None:
        save(kept)
        after_family(kept.report)

    if apart and CHILDREN:
        report = watch(validate_in_child, config, progress, save_and_tell)
    else:
        report = _validated(config, Nobody(progress, save_and_tell))
    making = watched.making(level, seeds, wanted)
    making = replace(making, checksum=summed, seconds=making.seconds + before)
    return replace(report, making=making)


def partial_result(
    reference: str | Path,
    *,
    level: Level,
    seeds: int,
    catalogue: Catalogue,
    only: Collection[str] | None = None,
    **options: Unpack[ValidationOptions],
) -> PartialResult | None:
    """The file of what an interrupted validation has found; None if its task cannot be read.

    The arguments are those of `validate_task`.
    """
    wanted = None if only is None else tuple(only)
    played = make_options(**options)
    return _partial(
        ValidationConfig(str(reference), level, seeds, catalogue, 1, wanted, options=played)
    )


def _partial(config: ValidationConfig) -> PartialResult | None:
    if config.level == "static":  # which takes no time
        return None
    with suppress(FileError, OSError):  # reported with everything else
        return PartialResult(config)
    return None


def _forget(_: Kept) -> None:
    """Keep no results."""


def _checksum(config: ValidationConfig) -> str:
    """Checksum of the task's two files, before anything else reads them."""
    with suppress(FileError):  # reported with everything else
        return checksum(config.catalogue.task(config.reference))
    return ""


def validate_in_child(config: ValidationConfig) -> TaskReport:
    """Run a validation in this child process, and report its events to the owner."""
    return _validated(config, Owner())


def _validated(config: ValidationConfig, listener: Listener) -> TaskReport:
    started = time.perf_counter()
    try:
        task = _loaded(config, listener)
    except FileError as error:
        failure = _timed(static_failure(error.findings), started)
        return TaskReport(config.reference, config.reference, (failure,))
    except TaskbuilderError:  # a wrong name or argument
        raise
    except Exception as error:  # a defect of taskbuilder; other tasks are validated all the same
        place = Location(config.catalogue.task(config.reference).file, 1, 1)
        failure = _timed(broken_family("static", error, place), started)
        return TaskReport(config.reference, config.reference, (failure,))
    static = (_timed(static_family(task), started), *_foreign_static(task))
    if config.level == "static":
        return TaskReport(task.name, headline(task, config.options), static)
    limit_s = config.limits.piece(task.file.spec.timing.episode_steps)
    with workers(
        config.jobs if config.level == "full" else 1,
        limit_s=limit_s,
        beat=listener.alive,
        prepared="taskbuilder.validate.context",  # while this process does
    ) as spread:
        families = families_of(config.level, config.only)
        return _play(task, config, static, families, listener, spread, limit_s)


def _foreign_static(task: Task) -> Iterator[FamilyResult]:
    """The results of the checks without physics that other packages add."""
    for family in foreign_families(OWN_FAMILIES):
        if family.level != "static":
            continue
        started = time.perf_counter()
        try:
            result = family.check(task)
        except Exception as error:  # the other checks are made all the same
            place = task.file.source.locate(("task",), key=True)
            result = broken_family(family.name, error, place)
        yield _timed(result, started)


def _loaded(config: ValidationConfig, listener: Listener) -> Task:
    """Load the task; its description is imported first, so that its errors can be located."""
    if not owned():
        return config.load(guarded=True)
    entry = config.catalogue.task(config.reference)
    listener.begin(IMPORT, config.limits.import_s)
    with suppress(FileError):  # errors are reported with all others
        load_description(entry)
    listener.begin(CHECK, config.limits.import_s)
    return config.load()


def _play(
    task: Task,
    config: ValidationConfig,
    static: tuple[FamilyResult, ...],
    families: tuple[Family, ...],
    listener: Listener,
    spread: Map,
    limit_s: float,
) -> TaskReport:
    """Run the families that need physics."""
    from taskbuilder.validate.context import Context
    from taskbuilder.validate.env_cache import EnvSource, close_cache

    source = EnvSource(config.reference, config.catalogue, next(_RUNS), config.options)
    context = Context(
        task, source, config.seeds, listener.progress, spread, limit_s, listener.alive
    )
    report = TaskReport(task.name, headline(task, config.options), static, context.measures)
    if config.kept:
        report = config.kept.report
        context.take_over(config.kept.state)
    else:
        listener.done(Kept(report, context.state))
    done = {*report.skipped, *(family.name for family in report.families)}
    try:
        for number, family in enumerate(families):
            if family.name in done:
                continue
            rest = tuple(later.name for later in families[number + 1 :])
            listener.begin(family.name, limit_s, rest)
            report = replace(_with(report, context, family), measures=context.measures)
            listener.done(Kept(report, context.state))
    finally:
        for variation in range(context.variations):
            context.close_world(variation)
        close_cache(source)
    return report


FATAL = ("TB314", "TB315")
"""Codes of findings after which no other family can run."""


HARMLESS = ("TB504",)
"""Codes of checks whose failure leaves the families that come after meaningful."""


def _with(report: TaskReport, context: Context, family: Family) -> TaskReport:
    """Add the result of one more family to a report, or its name if it is skipped."""
    fatal = any(finding.code in FATAL for finding in report.findings)
    wrong = {*report.skipped, *(found.name for found in report.families if _blocks(found))}
    if fatal or wrong & set(family.after):
        return replace(report, skipped=(*report.skipped, family.name))
    started = time.perf_counter()
    result = _timed(_checked(context, family), started)
    return replace(report, families=(*report.families, result))


def _blocks(result: FamilyResult) -> bool:
    """Whether families that come after this one would not be meaningful."""
    codes = {check.code for check in result.checks if not check.ok}
    codes |= {finding.code for finding in result.findings if finding.severity == "error"}
    return not result.ok and not (codes and codes <= {*HARMLESS})


def _checked(context: Context, family: Family) -> FamilyResult:
    """Run a family; an error of the description, or of the check itself, becomes a finding."""
    from taskbuilder.validate.env_cache import DescriptionError
    from taskbuilder.validate.locate import finding_at, finding_of_scene, in_description

    try:
        return family.check(context)
    except PlacementError as error:  # from a seed that the reset family did not come to
        place = error.findings[0]
        finding = finding_at(context.task, "TB305", place.message, place.path, "place")
        check = Check("TB305", "everything finds a place", False, 1, 0, "things")
        return FamilyResult(family.name, (check,), (finding,), "something finds no place")
    except ExplosionError as error:
        finding = finding_of_scene(context.task, "TB307", str(error))
        check = Check("TB307", "the physics stays bounded", False, 1, 0, "episodes")
        return FamilyResult(family.name, (check,), (finding,), "the physics diverged")
    except LostError as error:
        return lost_family(family.name, finding_of_loss(error.fault, context.task.file.entry))
    except DescriptionError as error:
        finding = error.finding
    except BaseException as error:
        if is_interrupt(error):
            raise
        explained = in_description(error, context.task.file.entry)
        if explained is None:
            location = context.task.file.source.locate(("task",), key=True)
            return broken_family(family.name, error, location)
        finding = explained
    check = Check("TB314", "the description can be asked", False, 1, 0, "things")
    return FamilyResult(family.name, (check,), (finding,), "the description fails")


def headline(task: Task, options: Options) -> str:
    """A task in one line: name, size, other robots than the file's, options, length, file."""
    spec = task.file.spec
    robots, objects = len(spec.scene.robots), len(spec.scene.objects)
    return " · ".join(
        (
            task.name,
            f"{robots} robot{'s' * (robots != 1)}",
            *(f"{name}: {model}" for name, model in options.robots),
            *(["grasp attach"] if "attach" in grasp_rules(task.file).values() else []),
            *(f"{name.replace('_', ' ')} {value}" for name, value in _unseen(options).items()),
            f"{objects} object{'s' * (objects != 1)}",
            f"{spec.timing.episode_steps} steps at {spec.timing.control_hz} Hz",
            display_path(task.file.entry.file),
        )
    )


def _unseen(options: Options) -> dict[str, object]:
    """The options that the rest of the headline does not show."""
    shown = ("robots", "grasp", "horizon", "control_hz")
    return {name: value for name, value in options.chosen.items() if name not in shown}


def _timed(result: FamilyResult, started: float) -> FamilyResult:
    return replace(result, seconds=time.perf_counter() - started)
