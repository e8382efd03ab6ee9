"""Reports for machines, and the words that all formats share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from taskbuilder.extensions import REPORT_FORMATS, ForeignPart

if TYPE_CHECKING:
    from taskbuilder.validate.report import TaskReport

DOCUMENTS: Mapping[str, str] = {"junit": "junit_xml"}
"""Formats that are one text about all tasks, each a module of this package -> its function."""

NAMES = ("text", "json", *DOCUMENTS, "github")
"""The library's own formats; installed packages may add others, which are documents."""


Writer = Callable[[Sequence["TaskReport"]], str]
"""Makes one text about all tasks."""


def document_writer(form: str) -> Writer | None:
    """What writes a format that is one text about all tasks; None for the other formats.

    Raises:
        UnknownNameError: There is no such format.
        ExtensionError: It is of another package, and cannot be used.
    """
    part = REPORT_FORMATS.part(form, NAMES)
    if part is not None:
        return _foreign_writer(part)
    if form not in DOCUMENTS:
        return None
    write: Writer = getattr(import_module(f"{__name__}.{form}"), DOCUMENTS[form])
    return write


def load_writer(part: ForeignPart) -> Writer:
    """What writes a format that another package adds.

    Raises:
        ExtensionError: It cannot be used.
    """
    write: Writer = part.load(lambda found: None if callable(found) else "cannot be called")
    return write


def _foreign_writer(part: ForeignPart) -> Writer:
    write = load_writer(part)

    def document(reports: Sequence[TaskReport]) -> str:
        with part.at_work():
            written = write(reports)
        if not isinstance(written, str):
            raise part.error(f"returns {type(written).__name__}, where a text is needed")
        return written

    return document
