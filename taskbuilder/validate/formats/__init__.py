"""Reports for machines, and the words that all formats share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taskbuilder.validate.report import TaskReport

DOCUMENTS: Mapping[str, str] = {"junit": "junit_xml"}
"""Formats that are one text about all tasks, each a module of this package -> its function."""


def document(form: str, reports: Sequence[TaskReport]) -> str:
    """The reports in one of the formats of `DOCUMENTS`."""
    text: str = getattr(import_module(f"{__name__}.{form}"), DOCUMENTS[form])(reports)
    return text
