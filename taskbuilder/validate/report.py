"""What a validation has to say: checks with figures, findings, and the table people read."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from taskbuilder.errors import Finding, in_reading_order

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.expert.ways import Way
    from taskbuilder.rollout.record import Rollout


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
class Probe:
    """What a way of playing a task earns, over many episodes.

    Attributes:
        way: The way.
        returns: Undiscounted return of the team in each episode.
        discounted: The same at a discount of 0.95.
        successes: In how many of the episodes success held at some step.
    """

    way: Way
    returns: tuple[float, ...]
    discounted: tuple[float, ...]
    successes: int


@dataclass(frozen=True)
class FamilyResult:
    """The result of one family of checks.

    Attributes:
        name: The family.
        checks: Every check that was made.
        findings: What was found wrong or doubtful.
        summary: One line for people: the figures that matter.
        seconds: How long it took.
        probes: What ways of playing the task earned.
        rollouts: Episodes worth a picture: one that shows the task, and those that failed.
    """

    name: str
    checks: tuple[Check, ...]
    findings: tuple[Finding, ...]
    summary: str
    seconds: float = 0.0
    probes: tuple[Probe, ...] = ()
    rollouts: tuple[Rollout, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong; warnings do not count."""
        sound = all(check.ok for check in self.checks)
        return sound and not any(finding.severity == "error" for finding in self.findings)


@dataclass(frozen=True)
class Making:
    """How a report was made.

    Attributes:
        level: How far the validation went.
        seeds: How many episodes were sampled where chance is involved; 0 where it is not.
        date: When it began, in UTC, as ``2025-01-31 14:05 UTC``.
        seconds: How long it took, with the loading of all that it needs.
        versions: Of taskbuilder and of what its figures depend on, by name.
        command: What made it, to be typed again; "" where it was asked for from Python.
    """

    level: str
    seeds: int
    date: str
    seconds: float
    versions: Mapping[str, str]
    command: str = ""


@dataclass(frozen=True)
class TaskReport:
    """The validation of one task.

    Attributes:
        task: The task's id, or the path it was asked for by.
        headline: What the task is, in one line.
        families: Results in the order in which they ran.
        measures: Figures by name, such as ``build_s``.
        skipped: Families that were not run, because what another one found would show there again.
        making: How the report was made, if that is known.
    """

    task: str
    headline: str
    families: tuple[FamilyResult, ...]
    measures: Mapping[str, float] = field(default_factory=dict)
    skipped: tuple[str, ...] = ()
    making: Making | None = None

    @property
    def seconds(self) -> float:
        """How long it took; of a report that does not say so, how long its families took."""
        if self.making:
            return self.making.seconds
        return sum(family.seconds for family in self.families)

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
        "probes": [_probe_data(probe) for family in report.families for probe in family.probes],
    }


def _probe_data(probe: Probe) -> dict[str, Any]:
    return {
        "name": str(probe.way),
        "way": probe.way.as_data(),
        "return": _mean(probe.returns),
        "discounted_return": _mean(probe.discounted),
        "successes": probe.successes,
        "episodes": len(probe.returns),
    }


def _mean(returns: Sequence[float]) -> float | None:
    """The mean, or None where it is not finite."""
    mean = sum(returns) / len(returns) if returns else math.nan
    return mean if math.isfinite(mean) else None
