"""Write reports with pictures into a folder."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

from taskbuilder.errors import FileError
from taskbuilder.files import write_whole
from taskbuilder.spec.catalogue import Catalogue
from taskbuilder.task import load_task
from taskbuilder.validate.formats.page import Page, index_page, task_page
from taskbuilder.validate.formats.pictures import take_pictures
from taskbuilder.validate.report import TaskReport

INDEX = "index.html"


def make_page(reference: str, report: TaskReport, catalogue: Catalogue) -> Page:
    """Gather what a report shows; pictures are taken here, unless no physics was asked for.

    Args:
        reference: What the task was asked for by.
        report: Its validation.
        catalogue: Where it was looked up.
    """
    try:
        task = load_task(reference, catalogue=catalogue)
    except FileError:
        return Page(report)  # its findings say why
    if len(report.families) < 2:
        return Page(report, task)
    return Page(report, task, take_pictures(task, report))


def write_page(folder: Path, page: Page, taken: Collection[str] = ()) -> Path:
    """Write the report of a task as ``TASK.html``.

    Args:
        folder: Where to; it is there.
        page: What to write.
        taken: Names of files that belong to other tasks.

    Returns:
        The file.

    Raises:
        OSError: It cannot be written.
    """
    file = folder / _file_name(page, taken)
    write_whole(file, task_page(page).encode())
    return file


def write_index(folder: Path, pages: Sequence[tuple[str, Page]]) -> Path:
    """Write ``index.html``, which leads to pages by their file names.

    Raises:
        OSError: It cannot be written.
    """
    file = folder / INDEX
    write_whole(file, index_page(pages).encode())
    return file


def _file_name(page: Page, taken: Collection[str]) -> str:
    """After the task; after its file where it does not load, as only its path is known then."""
    name = page.report.task
    stem = name.replace("/", "-") if page.task else Path(name).stem
    stem = re.sub(r"[^\w.-]+", "-", stem).strip(".-") or "task"
    again = (f"{stem}-{count}.html" for count in range(2, len(taken) + 3))
    return next(file for file in (f"{stem}.html", *again) if file not in taken)
