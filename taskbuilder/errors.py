"""Findings (what is wrong with a file, and where) and the errors that carry them.

A finding is data: checks return them, reports print them. An error is what Python code that
uses the library sees; the ones a user can cause carry the findings that explain them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Self

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Location:
    """A place in a file. Lines and columns count from 1; 0 stands for the whole file or line."""

    file: Path
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        name = display_path(self.file)
        if not self.line:
            return name
        return f"{name}:{self.line}:{self.column}" if self.column else f"{name}:{self.line}"


@dataclass(frozen=True)
class Fix:
    """A correction that needs no decision: other text in place of what was written.

    Attributes:
        location: Where the text begins, in front of its quotation marks if it has any.
        old: The text, without quotation marks.
        new: The text that is right.
    """

    location: Location
    old: str
    new: str

    def as_data(self) -> dict[str, str | int]:
        """The fix as plain data."""
        place = self.location
        return {
            "file": display_path(place.file),
            "line": place.line,
            "column": place.column,
            "old": self.old,
            "new": self.new,
        }


@dataclass(frozen=True)
class Finding:
    """A problem, with its location and a suggested correction.

    Attributes:
        code: Stable code such as ``TB102``; the documentation has an entry for each code.
        message: What is wrong and, after a semicolon, how to correct it.
        path: Dotted path of the key in the file (``scene.robots.left.model``), or "" for none.
        location: File, line and column, or None for a finding that belongs to no file.
        severity: Whether the finding is an error or a warning.
        excerpt: Source line to show below the finding, or "".
        fix: The correction, if it can be made without a decision; `taskbuilder fix` makes it.
    """

    code: str
    message: str
    path: str = ""
    location: Location | None = None
    severity: Severity = "error"
    excerpt: str = ""
    fix: Fix | None = None

    def __str__(self) -> str:
        where = f"{self.location}: " if self.location else ""
        subject = f"{self.path}: " if self.path else ""
        line = f"{where}{self.severity}[{self.code}] {subject}{self.message}"
        return f"{line}\n    {self.excerpt}" if self.excerpt else line

    def as_data(self) -> dict[str, Any]:
        """The finding as plain data, as ``--format json`` shows it."""
        place = self.location
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            "file": display_path(place.file) if place else None,
            "line": place.line or None if place else None,
            "column": place.column or None if place else None,
            "path": self.path,
            "fix": self.fix.as_data() if self.fix else None,
        }

    def at(self, location: Location | None) -> Finding:
        """The same finding at another location."""
        return replace(self, location=location)


def in_reading_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings sorted by file and line, without repetitions."""
    return tuple(sorted(dict.fromkeys(findings), key=_reading_order))


def _reading_order(finding: Finding) -> tuple[Any, ...]:
    """Those without a location first; paths by their parts, whose order no Python changes."""
    at = finding.location
    place = (at.file.parts, at.line, at.column) if at else ()
    return (place, finding.code, finding.path, finding.message)


def display_path(path: Path) -> str:
    """The path as a person would write it: relative to the working directory when inside it."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)


class TaskbuilderError(Exception):
    """Base class of all errors that taskbuilder raises on purpose."""


class FileError(TaskbuilderError):
    """A task, robot or asset file has errors; ``findings`` lists them.

    Attributes:
        findings: The findings, sorted by file and line; at least one is an error.
    """

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = in_reading_order(findings)
        super().__init__("\n".join(map(str, self.findings)))

    def __reduce__(self) -> tuple[type[Self], tuple[tuple[Finding, ...]]]:
        return type(self), (self.findings,)  # pickle would pass the text, which is no finding


class UnknownNameError(TaskbuilderError):
    """There is no task, robot, file, camera or policy of this name.

    Attributes:
        meant: The name that was probably meant, if one is known to be like it.
    """

    def __init__(self, message: str, meant: str | None = None) -> None:
        super().__init__(message)
        self.meant = meant


class UsageError(TaskbuilderError):
    """A call or command has invalid arguments."""


class SimulationError(TaskbuilderError):
    """The physics engine or the renderer refused a call, or the simulation diverged."""


class ExplosionError(SimulationError):
    """The simulation diverged: its state contains a value that is infinite, NaN or implausible.

    The world can no longer be used; build a new one.
    """


class EngineError(TaskbuilderError):
    """The physics engine cannot be imported: it is missing, or two packages provide it."""


class ExtensionError(TaskbuilderError):
    """A part that another package adds cannot be used; the message names the package."""


class DivergenceError(TaskbuilderError):
    """Learning came to numbers that are not finite."""


class PlacementError(TaskbuilderError):
    """Objects could not be placed without overlap.

    Attributes:
        findings: A finding for each object that could not be placed.
    """

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings = in_reading_order(findings)
        super().__init__("\n".join(map(str, self.findings)))

    def __reduce__(self) -> tuple[type[Self], tuple[tuple[Finding, ...]]]:
        return type(self), (self.findings,)  # pickle would pass the text, which is no finding
