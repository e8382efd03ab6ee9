"""`taskbuilder validate`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.cli.output import emit, paint, print_json, print_table, progress, show_finding
from taskbuilder.cli.tasks import asked_tasks, catalogue_of, make_folder
from taskbuilder.errors import display_path
from taskbuilder.jobs import cores
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.validate.formats.blame import why_skipped
from taskbuilder.validate.formats.github import workflow_commands
from taskbuilder.validate.formats.words import closing
from taskbuilder.validate.report import FamilyResult, TaskReport, as_data
from taskbuilder.validate.run import QUICK_SEEDS, SEEDS, validate_task

if TYPE_CHECKING:  # pages need the physics engine, which a static validation never loads
    from taskbuilder.validate.formats.page import Page


def run(arguments: argparse.Namespace) -> int:
    """Validate tasks, and report in the format that was asked for."""
    catalogue = catalogue_of(arguments)
    names = asked_tasks(arguments, catalogue)
    for name in names:
        catalogue.task(name)  # one that is not there is refused before any takes its time
    pages = _Pages(arguments.report, catalogue, several=len(names) > 1)
    reports: list[TaskReport] = []
    seconds = 0.0
    for name in names:
        started = time.perf_counter()
        with redirect_stdout(sys.stderr):  # what a description prints is no part of the result
            report = validate_task(
                name,
                level=arguments.level,
                seeds=QUICK_SEEDS if arguments.quick else arguments.seeds or SEEDS,
                jobs=arguments.jobs or cores(),
                catalogue=catalogue,
                progress=progress,
            )
        seconds += time.perf_counter() - started
        reports.append(report)
        _print_task(report, arguments.format)
        pages.add(name, report)
    _print_end(reports, arguments.format, seconds, pages.finish())
    return 0 if all(report.ok for report in reports) else 1


class _Pages:
    """Pages with pictures, in the folder that was asked for; none where none was.

    Raises:
        UsageError: There can be no such folder.
    """

    def __init__(self, folder: Path | None, catalogue: Catalogue, *, several: bool) -> None:
        self._folder, self._catalogue, self._several = folder, catalogue, several
        self._written: list[tuple[str, Page]] = []
        if folder:
            make_folder(folder)

    def add(self, name: str, report: TaskReport) -> None:
        """Write the page of a task at once: it is there even if a later one is interrupted."""
        if self._folder:
            from taskbuilder.validate.formats.pages import INDEX, make_page, write_page

            taken = [INDEX] * self._several + [file for file, _ in self._written]
            page = make_page(name, report, self._catalogue)
            self._written.append((write_page(self._folder, page, taken).name, page))

    def finish(self) -> str:
        """Write the page that leads to the others; name the one to begin with, or ""."""
        if not self._folder:
            return ""
        from taskbuilder.validate.formats.pages import write_index

        if self._several:
            return display_path(write_index(self._folder, self._written))
        return display_path(self._folder / self._written[0][0])


def _print_task(report: TaskReport, form: str) -> None:
    """What can be said as soon as a task is done."""
    if form == "text":
        print(paint(report.headline, "bold"))
        print()
        why = why_skipped(report)
        skipped = [[name, paint("skip", "yellow"), why, ""] for name in report.skipped]
        print_table([*map(_row, report.families), *skipped], indent="  ")
        print()
        for finding in report.findings:
            print(show_finding(finding))
        if report.findings:
            print()
    elif form == "github":
        for command in workflow_commands(report):
            emit(command)
    sys.stdout.flush()


def _row(family: FamilyResult) -> list[str]:
    mark = paint("ok  ", "green") if family.ok else paint("FAIL", "red")
    return [family.name, mark, family.summary, f"{family.seconds:.1f} s"]


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
    elif form == "junit":
        from taskbuilder.validate.formats.junit import junit_xml

        emit(junit_xml(reports))
    if named:
        print(named, file=sys.stderr)
