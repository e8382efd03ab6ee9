"""`taskbuilder validate`."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Collection, Generator, Sequence
from contextlib import closing as ending
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from taskbuilder.cli.env_options import asked_options, option_words
from taskbuilder.cli.output import (
    emit,
    paint,
    print_json,
    print_table,
    print_title,
    progress,
    show_finding,
)
from taskbuilder.cli.spreading import check_spread
from taskbuilder.cli.tasks import asked_tasks, catalogue_of, make_folder
from taskbuilder.cluster import cluster
from taskbuilder.env.options import Options, ValidationOptions, make_options
from taskbuilder.errors import FileError, display_path
from taskbuilder.jobs import workers
from taskbuilder.processes import cores
from taskbuilder.quiet import printing_to_stderr
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.validate.apart import Level
from taskbuilder.validate.families import OWN_FAMILIES, families_of
from taskbuilder.validate.formats import document_writer
from taskbuilder.validate.formats.cases import why_skipped
from taskbuilder.validate.formats.github import workflow_commands
from taskbuilder.validate.formats.words import closing
from taskbuilder.validate.remaining import MEASURED, remaining_s
from taskbuilder.validate.report import FamilyResult, TaskReport, as_data
from taskbuilder.validate.runner import (
    QUICK_SEEDS,
    SEEDS,
    partial_result,
    validate_task,
)
from taskbuilder.wording import duration

if TYPE_CHECKING:  # pages need the physics engine, which a static validation never loads
    from taskbuilder.validate.html.page import Page


WORTH_TELLING_S = 20.0
"""The shortest time left, in seconds, that is told."""

MANY = 2
"""Tasks for each process from which on processes validate a task each, not one task together."""


def run(arguments: argparse.Namespace) -> int:
    """Validate tasks, and report in the format that was asked for."""
    catalogue = catalogue_of(arguments)
    names = asked_tasks(arguments, catalogue)
    for name in names:
        with suppress(FileError):  # two of one name; reported with this task
            catalogue.task(name)  # one that is not there is refused before any takes its time
    if arguments.only:
        families_of(arguments.level, arguments.only)
    started = time.perf_counter()
    document_writer(arguments.format)  # a format that cannot be used is refused at once
    pages = _Pages(arguments.report, catalogue, make_options(**asked_options(arguments)))
    reports: list[TaskReport] = []
    try:
        with ending(_validated(names, catalogue, arguments)) as validated:
            for name, found in zip(names, validated, strict=True):
                report = _with_command(found, name, arguments)
                reports.append(report)
                _print_task(report, arguments.format)
                if arguments.debug:
                    _print_traces(report)
                pages.add(name, report)
    except BrokenPipeError:  # nobody reads any more
        raise
    except BaseException:  # what has been measured by now is not given up
        _print_some(reports, arguments.format)
        raise
    for name in names:  # nothing is left to go on with
        if left := partial_result(name, **_arguments(catalogue, arguments)):
            left.remove()
    alone = len(reports) == 1  # then its page shows the same time
    seconds = reports[0].seconds if alone else time.perf_counter() - started
    _print_end(reports, arguments.format, seconds, pages.finish())
    pages.check()
    return 0 if all(report.ok for report in reports) else 1


def _validated(
    names: Sequence[str], catalogue: Catalogue, arguments: argparse.Namespace
) -> Generator[TaskReport, None, None]:
    """The reports, each as soon as it is made."""
    check_spread(arguments)
    options = _arguments(catalogue, arguments)
    if arguments.resume:
        _tell_of_partial(names, options)
    keep = not arguments.ray  # whose machines have no folder in common
    validate = partial(validate_task, **options, keep=keep, resume=arguments.resume)
    if arguments.ray:
        with cluster(arguments.ray) as spread:
            yield from progress(spread(validate, names), "tasks", len(names))
        return
    jobs = arguments.jobs or cores()
    if jobs > 1 and len(names) >= MANY * jobs:
        with workers(jobs) as spread:
            yield from progress(spread(validate, names), "tasks", len(names))
        return
    for name in names:
        tell = _Remaining(name, arguments.only or OWN_FAMILIES, options["seeds"], jobs).tell
        with printing_to_stderr():  # what a description prints is no part of the result
            report = validate(name, jobs=jobs, progress=progress, after_family=tell)
        yield report


@dataclass(frozen=True)
class _Remaining:
    """Says on standard error how long the rest of a proof takes.

    Attributes:
        name: The task, as it was asked for.
        families: Names of the families that are asked for.
        seeds: Number of seeds per variation.
        jobs: Number of processes.
    """

    name: str
    families: Collection[str]
    seeds: int
    jobs: int

    def tell(self, report: TaskReport) -> None:
        """Say it after a family that the rest is estimated by, unless it is soon done."""
        if not report.families or report.families[-1].name not in MEASURED:
            return
        left = remaining_s(report, self.families, self.seeds, self.jobs)
        if left is not None and left >= WORTH_TELLING_S:
            print(f"{self.name}: about {duration(left)} left", file=sys.stderr, flush=True)


class _Arguments(ValidationOptions):
    """The arguments of `validate_task` on which a result depends."""

    level: Level
    seeds: int
    catalogue: Catalogue
    only: list[str] | None


def _arguments(catalogue: Catalogue, arguments: argparse.Namespace) -> _Arguments:
    options = cast("ValidationOptions", asked_options(arguments))
    return {
        **options,
        "level": arguments.level,
        "seeds": QUICK_SEEDS if arguments.quick else arguments.seeds or SEEDS,
        "catalogue": catalogue,
        "only": arguments.only,
    }


def _tell_of_partial(names: Sequence[str], options: _Arguments) -> None:
    """Say on standard error from where each task goes on."""
    for name in names:
        if found := partial_result(name, **options):
            print(f"{name}: {found.load()[1]}", file=sys.stderr, flush=True)


def _with_command(report: TaskReport, name: str, arguments: argparse.Namespace) -> TaskReport:
    """A report that says by which command it can be made again."""
    if report.making is None:
        return report
    words = ["taskbuilder", "validate", name]
    words += ["--level", arguments.level] if arguments.level != "full" else []
    for family in arguments.only or ():
        words += ["--only", family]
    words += ["--quick"] if arguments.quick else []
    words += ["--seeds", str(arguments.seeds)] if arguments.seeds and not arguments.quick else []
    words += option_words(asked_options(arguments))
    for folder in arguments.task_path or ():
        words += ["--task-path", str(folder)]
    return replace(report, making=replace(report.making, command=shlex.join(words)))


class _Pages:
    """Pages with pictures, in the folder that was asked for; none where none was.

    Raises:
        UsageError: There can be no such folder.
    """

    def __init__(self, folder: Path | None, catalogue: Catalogue, options: Options) -> None:
        self._folder, self._catalogue, self._options = folder, catalogue, options
        self._written: list[tuple[str, Page]] = []
        self._error: Exception | None = None
        if folder:
            make_folder(folder)

    def add(self, name: str, report: TaskReport) -> None:
        """Write the page of a task at once: it is there even if a later one is interrupted."""
        if self._folder:
            try:
                self._written.append(self._page(self._folder, name, report))
            except Exception as error:  # raised by `check`, once the results are printed
                self._error = self._error or error

    def _page(self, folder: Path, name: str, report: TaskReport) -> tuple[str, Page]:
        from taskbuilder.validate.html.files import INDEX, write_page
        from taskbuilder.validate.html.page import make_page

        taken = [INDEX, *(file for file, _ in self._written)]
        page = make_page(name, report, self._catalogue, options=self._options)
        return write_page(folder, page, taken).name, page

    def finish(self) -> str:
        """Write the page that leads to the others; name the one to begin with, or ""."""
        if not self._folder or not self._written:
            return ""
        from taskbuilder.validate.html.files import write_index

        (first, _), *others = self._written
        try:
            index = write_index(self._folder, self._written)
        except OSError as error:  # the same
            self._error = self._error or error
            return ""
        return display_path(index if others else self._folder / first)

    def check(self) -> None:
        """Raise the first error that kept a page from being written, if there was one."""
        if self._error:
            raise self._error


def _print_task(report: TaskReport, form: str) -> None:
    """What can be said as soon as a task is done."""
    if form == "text":
        print_title(report.headline)
        print()
        why = why_skipped(report)
        skipped = [[name, paint("skip", "yellow"), "", why] for name in report.skipped]
        print_table([*map(_row, report.families), *skipped], indent="  ", prose=True)
        print()
        for finding in report.findings:
            print(show_finding(finding))
        if report.findings:
            print()
    elif form == "github":
        for command in workflow_commands(report):
            emit(command)
    sys.stdout.flush()


def _print_traces(report: TaskReport) -> None:
    """The tracebacks of families that an unexpected error ended, on standard error."""
    for family in report.families:
        if family.trace:
            print(f"{report.task}: {family.name}:\n{family.trace}\n", file=sys.stderr, flush=True)


def _row(family: FamilyResult) -> list[str]:
    mark = paint("ok  ", "green") if family.ok else paint("FAIL", "red")
    if family.ok and not (family.checks and family.has_expert):
        mark = paint("skip", "yellow")
    return [family.name, mark, f"{family.seconds:5.1f} s", family.summary]


def _print_some(reports: Sequence[TaskReport], form: str) -> None:
    """The reports on the tasks that are done, where the others will not be."""
    if reports and form == "json":
        print_json(as_data(reports, complete=False))
    elif reports and (document := document_writer(form)):
        emit(document(reports))


def _print_end(reports: Sequence[TaskReport], form: str, seconds: float, page: str) -> None:
    """What can be said once all tasks are done; machines get nothing but their format."""
    named = f"pictures and probes: {page}" if page else ""
    if form in ("text", "github"):
        word, rest = closing(reports, seconds)
        colored = paint(word, "green" if word == "ok" else "red")
        emit(" · ".join(filter(None, (f"{colored}{rest}", named))))
        return
    if form == "json":
        print_json(as_data(reports))
    elif document := document_writer(form):
        emit(document(reports))
    if named:
        print(named, file=sys.stderr)
