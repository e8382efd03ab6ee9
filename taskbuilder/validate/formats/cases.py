"""Which findings belong to which check."""

from __future__ import annotations

from dataclasses import dataclass

from taskbuilder.errors import Finding
from taskbuilder.validate.formats.words import figure, listed
from taskbuilder.validate.report import Check, FamilyResult, TaskReport


@dataclass(frozen=True)
class Case:
    """A check with what was found wrong by it.

    Attributes:
        family: The family that it belongs to.
        code: Its code; "" for a family that was not run.
        name: What was looked at.
        ok: Whether nothing is wrong; warnings do not count.
        findings: What was found.
        figure: What was measured, and its limit, in words.
        seconds: Its share of the family's time.
        skipped: Why nothing was looked at, or None.
        trace: Traceback of an error that ended the family, or "".
    """

    family: str
    code: str
    name: str
    ok: bool
    findings: tuple[Finding, ...]
    figure: str
    seconds: float
    skipped: str | None = None
    trace: str = ""


def why_skipped(report: TaskReport) -> str:
    """Why families of a report were not run."""
    failed = [family.name for family in report.families if not family.ok]
    return f"not run, as {listed(failed)} failed"


def cases_of(report: TaskReport) -> list[Case]:
    """Every check of a report with its findings, each of which is somewhere."""
    cases = [case for family in report.families for case in _cases(family)]
    why = why_skipped(report)
    return cases + [Case(name, "", name, True, (), "", 0.0, why) for name in report.skipped]


def _cases(family: FamilyResult) -> list[Case]:
    owned: dict[Check, list[Finding]] = {check: [] for check in family.checks}
    loose: dict[str, list[Finding]] = {}
    for finding in family.findings:
        check = _owner(finding, family.checks)
        (owned[check] if check else loose.setdefault(finding.code, [])).append(finding)
    share = family.seconds / max(len(owned) + len(loose), 1)
    cases = [
        _case(family, check.code, check.name, check.ok, found, figure(check), share)
        for check, found in owned.items()
    ]
    for code, found in loose.items():
        cases.append(_case(family, code, found[0].message, True, found, "", share))
    return cases


def _case(
    family: FamilyResult,
    code: str,
    name: str,
    ok: bool,
    findings: list[Finding],
    measured: str,
    seconds: float,
) -> Case:
    sound = ok and not any(finding.severity == "error" for finding in findings)
    trace = "" if sound else family.trace
    return Case(family.name, code, name, sound, tuple(findings), measured, seconds, trace=trace)


def _owner(finding: Finding, checks: tuple[Check, ...]) -> Check | None:
    """The check of a finding's code, or that which gathers the codes of its group."""
    for code in (finding.code, f"{finding.code[:3]}00"):
        for check in checks:
            if check.code == code:
                return check
    return None
