"""Collecting what is wrong with one file, so that all of it is told at once."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.assets.markup import Element
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import FileError, Finding, Location, Severity


class Report:
    """The findings of one file so far. ``subject`` is such as ``joint elbow``."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._findings: list[Finding] = []

    def error(self, code: str, element: Element, subject: str, message: str) -> None:
        """Notes something that forbids the file."""
        self._note(code, element, subject, message, "error")

    def warning(self, code: str, element: Element, subject: str, message: str) -> None:
        """Notes something that a person should look at."""
        self._note(code, element, subject, message, "warning")

    def asset(self, error: AssetError, element: Element, subject: str) -> None:
        """Notes that a file named by an element cannot be used."""
        self._findings.append(error.finding(subject, self._place(element)))

    def warnings(self) -> tuple[Finding, ...]:
        """The warnings, if nothing forbids the file.

        Raises:
            FileError: Something does; it carries the warnings too.
        """
        if any(finding.severity == "error" for finding in self._findings):
            raise FileError(self._findings)
        return tuple(self._findings)

    def _note(
        self, code: str, element: Element, subject: str, message: str, severity: Severity
    ) -> None:
        place = self._place(element)
        self._findings.append(Finding(code, message, subject, place, severity))

    def _place(self, element: Element) -> Location:
        return Location(self._file, element.line, element.column)
