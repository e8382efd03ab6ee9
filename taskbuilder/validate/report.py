"""The report of a validation: checks with figures, and findings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from taskbuilder.errors import Finding, in_reading_order
from taskbuilder.geometry import total

if TYPE_CHECKING:  # a static validation loads no physics
    from taskbuilder.expert.baselines import Baseline
    from taskbuilder.rollout.record import Rollout


@dataclass(frozen=True)
class Check:
    """One check.

    Attributes:
        code: Stable code; findings of the check have the same one.
        name: What the check is about, in words.
        ok: Whether it passed.
        value: The measured figure; None if there is no finite one.
        limit: Maximum or minimum of the figure; None if there is no limit.
        unit: Unit of both.
    """

    code: str
    name: str
    ok: bool
    value: float | None
    limit: float | None = None
    unit: str = ""


FIGURES = 7
"""Significant figures of the returns of single episodes in ``--format json``."""

Result = tuple[Check, list[Finding]]
"""The result of one check."""

Progress = Callable[[Iterable[int], str], Iterable[int]]
"""Wraps an iterable of seeds to display progress, with a label."""


@dataclass(frozen=True)
class Probe:
    """The returns of a probe, or of the expert, over many episodes.

    Attributes:
        baseline: Who played: ``expert``, ``stall after stage 2``, ``without left``, ``random``.
        returns: Undiscounted return of the team in each episode.
        discounted: The same at a discount of 0.95.
        successes: Number of episodes in which success held at some step.
        seeds: Seed of each episode.
        succeeded: Whether success held at some step of each episode.
        decided_after: Number of seeds after which the comparison with the expert was decided; None
            for the expert, and for a probe that is not compared.
    """

    baseline: Baseline
    returns: tuple[float, ...]
    discounted: tuple[float, ...]
    successes: int
    seeds: tuple[int, ...] = ()
    succeeded: tuple[bool, ...] = ()
    decided_after: int | None = None


NO_EXPERT = "TB533"
"""The code of the warning that nothing shows that the task can be done."""


@dataclass(frozen=True)
class FamilyResult:
    """The result of one family of checks.

    Attributes:
        name: The family.
        checks: All checks.
        findings: Errors and warnings.
        summary: The main figures in one line.
        seconds: Duration in seconds.
        probes: The returns of the expert and the probes.
        rollouts: Episodes to show: a successful one, and those that failed.
        trace: Traceback of an unexpected error that ended the family, or "".
    """

    name: str
    checks: tuple[Check, ...]
    findings: tuple[Finding, ...]
    summary: str
    seconds: float = 0.0
    probes: tuple[Probe, ...] = ()
    rollouts: tuple[Rollout, ...] = ()
    trace: str = ""

    @property
    def ok(self) -> bool:
        """Whether there are no errors; warnings do not count."""
        sound = all(check.ok for check in self.checks)
        return sound and not any(finding.severity == "error" for finding in self.findings)

    @property
    def has_expert(self) -> bool:
        """Whether it did not lack an expert that can be played."""
        return all(finding.code != NO_EXPERT for finding in self.findings)


@dataclass(frozen=True)
class Making:
    """The metadata of a report.

    Attributes:
        level: Level of the validation.
        seeds: Number of seeds per variation; 0 if none were used.
        date: Start time in UTC, such as ``2025-01-31 14:05 UTC``.
        seconds: Duration in seconds, including loading.
        versions: Versions of taskbuilder and the packages that its figures depend on.
        command: The command; "" if the validation was called from Python.
        only: The families that were asked for; None for all families of the level.
        checksum: Checksum of the task file and its description; "" if there is no task file.
    """

    level: str
    seeds: int
    date: str
    seconds: float
    versions: Mapping[str, str]
    command: str = ""
    only: tuple[str, ...] | None = None
    checksum: str = ""


@dataclass(frozen=True)
class TaskReport:
    """The report on one task.

    Attributes:
        task: Id of the task, or its path.
        headline: The task in one line.
        families: Results of the families, in the order in which they ran.
        measures: Figures by name, such as ``build_s``.
        skipped: Families that were not run because one that they build on failed.
        making: Metadata of the report, if known.
    """

    task: str
    headline: str
    families: tuple[FamilyResult, ...]
    measures: Mapping[str, float] = field(default_factory=dict)
    skipped: tuple[str, ...] = ()
    making: Making | None = None

    @property
    def seconds(self) -> float:
        """Duration in seconds; without metadata, the sum over the families."""
        if self.making:
            return self.making.seconds
        return total(family.seconds for family in self.families)

    @property
    def ok(self) -> bool:
        """Whether all families that ran passed."""
        return all(family.ok for family in self.families)

    @property
    def has_expert(self) -> bool:
        """Whether no family lacked an expert, so that passing them proves the task."""
        return all(family.has_expert for family in self.families)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All findings, in reading order."""
        return in_reading_order(finding for family in self.families for finding in family.findings)


def as_data(reports: Iterable[TaskReport], *, complete: bool = True) -> dict[str, Any]:
    """The reports as plain data for ``--format json``, with a stable structure.

    Args:
        reports: The reports.
        complete: Whether these are all reports that were asked for.
    """
    from taskbuilder import __version__

    listed = list(reports)
    return {
        "version": __version__,
        "ok": complete and all(report.ok for report in listed),
        "complete": complete,
        "tasks": [_task_data(report) for report in listed],
    }


def _task_data(report: TaskReport) -> dict[str, Any]:
    return {
        "task": report.task,
        "ok": report.ok,
        "making": asdict(report.making) if report.making else None,
        "findings": [finding.as_data() for finding in report.findings],
        "families": [
            {
                "name": family.name,
                "ok": family.ok,
                "summary": family.summary,
                "seconds": round(family.seconds, 3),
            }
            for family in report.families
        ],
        "skipped": list(report.skipped),
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
        "tracebacks": {family.name: family.trace for family in report.families if family.trace},
        "probes": [_probe_data(probe) for family in report.families for probe in family.probes],
    }


def _probe_data(probe: Probe) -> dict[str, Any]:
    return {
        "name": str(probe.baseline),
        "way": probe.baseline.as_data(),
        "return": _mean(probe.returns),
        "discounted_return": _mean(probe.discounted),
        "successes": probe.successes,
        "episodes": len(probe.returns),
        "decided_after": probe.decided_after,
        "by_seed": {
            "seed": list(probe.seeds),
            "return": [_figures(value) for value in probe.returns],
            "discounted_return": [_figures(value) for value in probe.discounted],
            "succeeded": [int(succeeded) for succeeded in probe.succeeded],
        },
    }


def _figures(value: float) -> float | None:
    """A return with as many figures as its comparison needs; None if it is not finite."""
    return float(f"{value:.{FIGURES}g}") if math.isfinite(value) else None


def _mean(returns: Sequence[float]) -> float | None:
    """The mean, or None if it is not finite."""
    mean = total(returns) / len(returns) if returns else math.nan
    return mean if math.isfinite(mean) else None
