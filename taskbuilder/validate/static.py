"""The static family: what can be said of a task without physics."""

from __future__ import annotations

from collections.abc import Mapping

from taskbuilder.errors import Finding
from taskbuilder.task import Task
from taskbuilder.validate.report import Check, FamilyResult

GROUPS: Mapping[str, tuple[str, str]] = {
    "TB0": ("TB000", "the files can be read"),
    "TB1": ("TB100", "keys, types and units are right"),
    "TB2": ("TB200", "names resolve and the description is sound"),
    "TB3": ("TB300", "robots and joint values fit their URDFs"),
    "TB4": ("TB400", "assets are there and sound"),
}
"""First letters of a finding's code -> code and name of the check that it belongs to."""


def static_family(task: Task) -> FamilyResult:
    """The result for a task that loaded: its warnings, and how much was resolved."""
    names = task.file.names
    count = len({*names.known("frame"), *names.robots, *names.cameras, *names.known("joint")})
    return FamilyResult("static", _checks(task.warnings), task.warnings, f"{count} names resolve")


def static_failure(findings: tuple[Finding, ...]) -> FamilyResult:
    """The result for a task that did not load."""
    errors = sum(finding.severity == "error" for finding in findings)
    summary = f"{errors} error{'s' * (errors != 1)}"
    return FamilyResult("static", _checks(findings), findings, summary)


def _checks(findings: tuple[Finding, ...]) -> tuple[Check, ...]:
    checks = []
    for prefix, (code, name) in GROUPS.items():
        wrong = sum(f.code.startswith(prefix) and f.severity == "error" for f in findings)
        checks.append(Check(code, name, wrong == 0, wrong, 0, "findings"))
    return tuple(checks)
