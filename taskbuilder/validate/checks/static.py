"""The static family: checks of a task without physics."""

from __future__ import annotations

from collections.abc import Mapping

from taskbuilder.errors import Finding
from taskbuilder.task import Task
from taskbuilder.validate.checks.joint_bounds import check_joint_bounds
from taskbuilder.validate.report import Check, FamilyResult, Result

GROUPS: Mapping[str, tuple[str, str]] = {
    "TB0": ("TB000", "the files can be read"),
    "TB1": ("TB100", "keys, types and units are right"),
    "TB2": ("TB200", "names resolve and the description is sound"),
    "TB3": ("TB300", "robots and joint values fit their URDFs"),
    "TB4": ("TB400", "assets are there and sound"),
}
"""Prefix of a finding's code -> code and name of its check."""


def static_family(task: Task) -> FamilyResult:
    """The result for a task that could be loaded: its warnings, and the number of names."""
    names = task.file.names
    count = len({*names.known("frame"), *names.robots, *names.cameras, *names.known("joint")})
    findings = (*task.warnings, *check_joint_bounds(task))
    checks = _checks(findings)
    if task.file.spec.variations:
        check, alike = _check_variations(task)
        checks, findings = (*checks, check), (*findings, *alike)
    return FamilyResult("static", checks, findings, f"{count} names resolve")


def _check_variations(task: Task) -> Result:
    """No two variations have the same scene."""
    scenes = task.file.scenes
    findings = []
    for number, scene in enumerate(scenes[1:], start=1):
        same = scenes.index(scene)
        if same < number:
            of = f"variation {same}" if same else "the plain task"
            message = f"has the same scene as {of}; change something, or leave it out"
            location = task.file.source.locate(("variations", number - 1))
            findings.append(Finding("TB534", message, f"variations[{number - 1}]", location))
    wrong = len(findings)
    return Check("TB534", "variations differ", not wrong, wrong, 0, "variations"), findings


def static_failure(findings: tuple[Finding, ...]) -> FamilyResult:
    """The result for a task that could not be loaded."""
    errors = sum(finding.severity == "error" for finding in findings)
    summary = f"{errors} error{'s' * (errors != 1)}"
    return FamilyResult("static", _checks(findings), findings, summary)


def _checks(findings: tuple[Finding, ...]) -> tuple[Check, ...]:
    checks = []
    for prefix, (code, name) in GROUPS.items():
        wrong = sum(f.code.startswith(prefix) and f.severity == "error" for f in findings)
        checks.append(Check(code, name, wrong == 0, wrong, 0, "findings"))
    return tuple(checks)
