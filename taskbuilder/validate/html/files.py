"""Write pages into a folder."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

from taskbuilder.files import write_whole
from taskbuilder.validate.html.page import Page
from taskbuilder.validate.html.templates import index_page, task_page

INDEX = "index.html"


def write_page(folder: Path, page: Page, taken: Collection[str] = ()) -> Path:
    """Write the page of a task as ``TASK.html``.

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
