"""`taskbuilder watch`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path

from taskbuilder.cli.output import paint, print_title, show_finding
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.errors import FileError, display_path, in_reading_order
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import read_task
from taskbuilder.schema.used_files import used_files
from taskbuilder.validate.looking import Looker, LookOrder, Seen
from taskbuilder.validate.polling import Polled
from taskbuilder.visual.annotations import check_words

_POLL_S = 0.04
_NAMES = len("picture")


def run(arguments: argparse.Namespace) -> int:
    """Check a task again whenever its files change, until Ctrl-C."""
    catalogue = catalogue_of(arguments)
    entry = catalogue.task(arguments.task)
    show = check_words([word for listed in arguments.show for word in listed.split(",")])
    name = entry.name.replace("/", "-")
    file: Path = arguments.out or Path("renders", f"{name}-watch.png")
    make_folder(file.parent)
    order = LookOrder(
        arguments.task,
        catalogue,
        file.absolute(),
        arguments.camera or "",
        arguments.size,
        arguments.seed,
        show,
    )
    _check_camera(order)
    looker = Looker()
    try:
        _watch(looker, order, entry)
    except KeyboardInterrupt:
        print(f"\nstopped watching {display_path(entry.file)}")
    finally:
        looker.close()
    return 0


def _check_camera(order: LookOrder) -> None:
    """Refuse a camera that the scene lacks, as far as the task can be read.

    Raises:
        UnknownNameError: There is no such camera.
    """
    with suppress(FileError):
        file = read_task(order.catalogue.task(order.task), order.catalogue)
        file.check_cameras([order.camera] if order.camera else [])


def _watch(looker: Looker, order: LookOrder, entry: CatalogueEntry) -> None:
    """Look, wait for a change, and look again."""
    polled = Polled()
    polled.watch(used_files(entry, order.catalogue))
    changed: Sequence[Path] = ()
    first = True
    while True:
        _say_why(entry, changed, len(polled.files), first=first)
        pending: list[Path] = []
        looker.look(order, _Printer().show, partial(_changed, polled, pending))
        # What the files name may have changed with them. What they named before stays watched
        # while a file is broken, so that mending it is noticed.
        polled.watch(used_files(entry, Catalogue(order.catalogue.folders)) | polled.files)
        while not _changed(polled, pending):
            time.sleep(_POLL_S)
        changed, first = tuple(dict.fromkeys(pending)), False


def _changed(polled: Polled, pending: list[Path]) -> bool:
    """Whether anything has changed since the last look began; what has is added to the list."""
    pending += polled.changed()
    return bool(pending)


def _say_why(entry: CatalogueEntry, changed: Iterable[Path], count: int, *, first: bool) -> None:
    if first:
        print(f"watching {display_path(entry.file)} and {count - 1} other files; Ctrl-C ends it")
    else:
        names = ", ".join(display_path(file) for file in changed)
        print(f"\n{time.strftime('%H:%M:%S')} · changed: {names}")
    print(flush=True)


class _Printer:
    """Prints the findings on a task as soon as they are known."""

    def __init__(self) -> None:
        self._started = time.perf_counter()
        self._families = 0
        self._headline = self._pictured = False

    def show(self, seen: Seen) -> None:
        """Print what was not known before."""
        report = seen.report
        if report is not None:
            if not self._headline:
                print_title(report.headline)
                print()
                self._headline = True
            for family in report.families[self._families :]:
                self._row(family.name, family.summary, ok=family.ok)
                for finding in in_reading_order(family.findings):
                    print(show_finding(finding))
            self._families = len(report.families)
        if not self._pictured and (seen.picture or seen.problem):
            self._pictured = True
            said = display_path(seen.picture) if seen.picture else seen.problem
            self._row("picture" if report else "static", said, ok=seen.picture is not None)
        sys.stdout.flush()

    def _row(self, name: str, summary: str, *, ok: bool) -> None:
        mark = paint("ok  ", "green") if ok else paint("FAIL", "red")
        seconds = time.perf_counter() - self._started
        print(f"  {name.ljust(_NAMES)}  {mark}  {summary}  ({seconds:.2f} s)")
