"""Write reports with pictures into a folder."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from taskbuilder.description.description import Description
from taskbuilder.errors import FileError
from taskbuilder.files import write_whole
from taskbuilder.jobs import LostError, worker_processes
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task
from taskbuilder.validate.formats.page import Page, index_page, task_page
from taskbuilder.validate.formats.pictures import Pictures, take_pictures
from taskbuilder.validate.report import TaskReport

INDEX = "index.html"

PICTURES_LIMIT_S = 300.0
"""How long the pictures of a task may take."""


def make_page(
    reference: str, report: TaskReport, catalogue: Catalogue, *, apart: bool = True
) -> Page:
    """Gather what a report shows; pictures are taken here, unless no physics was asked for.

    Args:
        reference: What the task was asked for by.
        report: Its validation.
        catalogue: Where it was looked up.
        apart: Load the task and take its pictures in another process; see `validate_task`.
    """
    if not apart:
        return _made(reference, report, catalogue)
    try:
        with worker_processes([{}], limit_s=PICTURES_LIMIT_S) as spread:
            (page,) = spread(_made_apart, [(reference, report, catalogue)])
    except LostError as error:
        lost = f"The process that takes them {error.fault.cause}."
        return Page(report, pictures=Pictures(trouble=lost))
    found: Page = page
    return found


def _made_apart(asked: tuple[str, TaskReport, Catalogue]) -> Page:
    """A page, without the description, which only the process that imported it knows."""
    page = _made(*asked)
    return replace(page, task=page.task and replace(page.task, description=Description))


def _made(reference: str, report: TaskReport, catalogue: Catalogue) -> Page:
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
