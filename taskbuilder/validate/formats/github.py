"""Reports as workflow commands, which GitHub shows beside the lines that they speak of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from taskbuilder.errors import Finding, display_path
from taskbuilder.validate.formats.cases import cases_of
from taskbuilder.validate.formats.words import printable
from taskbuilder.validate.report import TaskReport


def workflow_commands(report: TaskReport) -> Iterator[str]:
    """A command for each finding, and for each check that failed without one."""
    for finding in report.findings:
        yield _of_finding(finding, report.task)
    for case in cases_of(report):
        if not case.ok and not any(finding.severity == "error" for finding in case.findings):
            message = f"{report.task}: {case.name}: {case.figure}"
            yield _command("error", (("title", case.code),), message)


def _of_finding(finding: Finding, task: str) -> str:
    place = finding.location
    properties: list[tuple[str, str]] = []
    if place:
        properties.append(("file", display_path(place.file)))
        properties += [("line", str(place.line))] if place.line else []
        properties += [("col", str(place.column))] if place.line and place.column else []
    properties.append(("title", finding.code))
    subjects = ("" if place else task, finding.path, finding.message)
    return _command(finding.severity, properties, ": ".join(filter(None, subjects)))


def _command(name: str, properties: Iterable[tuple[str, str]], message: str) -> str:
    listed = ",".join(f"{key}={_escaped(value, ':,')}" for key, value in properties)
    return f"::{name} {listed}::{_escaped(message)}"


def _escaped(text: str, also: str = "") -> str:
    """The text with what would end a command, or a property of it, as per cent and two digits."""
    text = printable(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    for character in also:
        text = text.replace(character, f"%{ord(character):02X}")
    return text
