"""What a validation has to say: checks with figures, findings, and the table people read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from taskbuilder.errors import Finding, in_reading_order


@dataclass(frozen=True)
class Check:
    """One thing that was looked at.

    Attributes:
        code: Stable code; findings of the check carry the same one.
        name: What was looked at, in words.
        ok: Whether it is as it should be.
        value: The figure that was measured; None where nothing finite could be.
        limit: What the figure may be at most, or must be at least; None where there is no limit.
        unit: Unit of both.
    """

    code: str
    name: str
    ok: bool
    value: float | None
    limit: float | None = None
    unit: str = ""


Result = tuple[Check, list[Finding]]
"""What one check comes back with."""

Progress = Callable[[Iterable[int], str], Iterable[int]]
"""Wraps an iterable of seeds to show how far it is; gets a label."""


@dataclass(frozen=True)
class FamilyResult:
    """The result of one family of checks.

    Attributes:
        name: The family.
        checks: Every check that was made.
        findings: What was found wrong or doubtful.
        summary: One line for people: the figures that matter.
        seconds: How long it took.
    """

    name: str
    checks: tuple[Check, ...]
    findings: tuple[Finding, ...]
    summary: str
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong; warnings do not count."""
        sound = all(check.ok for check in self.checks)
        return sound and not any(finding.severity == "error" for finding in self.findings)


@dataclass(frozen=True)
class TaskReport:
    """The validation of one task.

    Attributes:
        task: The task's id, or the path it was asked for by.
        headline: What the task is, in one line.
        families: Results in the order in which they ran; a family that fails ends the run.
        measures: Figures by name, such as ``build_s``.
    """

    task: str
    headline: str
    families: tuple[FamilyResult, ...]
    measures: Mapping[str, float] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether every family that ran found the task right."""
        return all(family.ok for family in self.families)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Every finding, in reading order."""
        return in_reading_order(finding for family in self.families for finding in family.findings)


def as_data(reports: Iterable[TaskReport]) -> dict[str, Any]:
    """The reports as the plain data of ``--format json``; its shape is stable."""
    from taskbuilder import __version__

    listed = list(reports)
    return {
        "version": __version__,
        "ok": all(report.ok for report in listed),
        "tasks": [_task_data(report) for report in listed],
    }


def _task_data(report: TaskReport) -> dict[str, Any]:
    return {
        "task": report.task,
        "ok": report.ok,
        "findings": [finding.as_data() for finding in report.findings],
        "checks": [
            {
                "code": check.code,
                "family": family.name,
                "name": check.name,
                "ok": check.ok,
                "value": check.value,
                "limit": check.limit,
                "unit": check.unit,
            }
            for family in report.families
            for check in family.checks
        ],
        "measures": dict(report.measures),
    }
