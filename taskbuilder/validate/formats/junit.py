"""Reports as JUnit XML: a suite for each task, a case for each check."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from taskbuilder.errors import Finding
from taskbuilder.geometry import total
from taskbuilder.validate.formats.cases import Case, cases_of
from taskbuilder.validate.formats.words import printable
from taskbuilder.validate.report import TaskReport


def junit_xml(reports: Iterable[TaskReport]) -> str:
    """The reports as CI systems read them.

    There is nothing in it that Jenkins' schema of 2019 (junit-10) does not have. Classes are named
    after task and family: GitLab knows cases by class and name alone, and drops those that it has
    already seen. A family's time is shared by its checks. A family that an unexpected error ended
    is a case with an ``error`` in place of a ``failure``, which has the traceback.
    """
    top = ElementTree.Element("testsuites", name="taskbuilder validate")
    reports = list(reports)
    cases = [case for report in reports for case in _add_suite(top, report)]
    _count(top, cases)
    top.set("time", _seconds(total(report.seconds for report in reports)))
    ElementTree.indent(top)
    text = ElementTree.tostring(top, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}'


def _add_suite(top: ElementTree.Element, report: TaskReport) -> list[Case]:
    suite = ElementTree.SubElement(top, "testsuite", name=printable(report.task))
    cases = cases_of(report)
    _count(suite, cases)
    suite.set("time", _seconds(report.seconds))
    suite.set("skipped", str(sum(case.skipped is not None for case in cases)))
    for case in cases:
        _add_case(suite, report, case)
    return cases


def _count(suite: ElementTree.Element, cases: Sequence[Case]) -> None:
    suite.set("tests", str(len(cases)))
    suite.set("failures", str(sum(not case.ok and not case.trace for case in cases)))
    suite.set("errors", str(sum(bool(case.trace) for case in cases)))


def _add_case(suite: ElementTree.Element, report: TaskReport, case: Case) -> None:
    made = ElementTree.SubElement(
        suite,
        "testcase",
        classname=printable(f"{report.task}.{case.family}"),
        name=printable(f"{case.code} {case.name}".strip()),
        time=_seconds(case.seconds),
    )
    if case.skipped is not None:
        ElementTree.SubElement(made, "skipped", message=printable(case.skipped))
    errors = [finding for finding in case.findings if finding.severity == "error"]
    if not case.ok:
        message = errors[0].message if errors else case.figure
        kind = "error" if case.trace else "failure"
        failure = ElementTree.SubElement(made, kind, message=printable(message), type=case.code)
        failure.text = printable(case.trace) or _listed(errors) or printable(case.figure)
    warnings = [finding for finding in case.findings if finding.severity == "warning"]
    if warnings:
        ElementTree.SubElement(made, "system-out").text = _listed(warnings)


def _listed(findings: Iterable[Finding]) -> str:
    return printable("\n".join(map(str, findings)))


def _seconds(seconds: float) -> str:
    return f"{seconds:.3f}"
