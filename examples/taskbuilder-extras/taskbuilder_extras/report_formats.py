"""A format of validation reports: a table in Markdown, with a row for each family of checks."""

from __future__ import annotations

from collections.abc import Sequence

from taskbuilder.validate.report import TaskReport


def as_markdown(reports: Sequence[TaskReport]) -> str:
    """One text about all tasks."""
    lines = ["| task | family | result | summary |", "|---|---|---|---|"]
    for report in reports:
        for family in report.families:
            result = "passed" if family.ok else "**failed**"
            lines.append(f"| {report.task} | {family.name} | {result} | {family.summary} |")
        lines += [f"| {report.task} | {name} | skipped | |" for name in report.skipped]
    findings = [f"- {finding}" for report in reports for finding in report.findings]
    return "\n".join([*lines, "", *findings])
