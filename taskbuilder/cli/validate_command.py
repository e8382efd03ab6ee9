"""`taskbuilder validate`."""

from __future__ import annotations

import argparse
import sys
import time

from taskbuilder.cli.output import paint, print_json, print_table, progress, show_finding
from taskbuilder.cli.tasks import asked_tasks, catalogue_of
from taskbuilder.errors import in_reading_order
from taskbuilder.validate.report import TaskReport, as_data
from taskbuilder.validate.run import QUICK_SEEDS, SEEDS, validate_task


def run(arguments: argparse.Namespace) -> int:
    """Validate tasks, and report as a table or as JSON."""
    catalogue = catalogue_of(arguments)
    seeds = QUICK_SEEDS if arguments.quick else arguments.seeds or SEEDS
    entries = [(name, catalogue.task(name)) for name in asked_tasks(arguments, catalogue)]
    started = time.perf_counter()
    reports = []
    for name, _ in entries:
        report = validate_task(
            name, level=arguments.level, seeds=seeds, catalogue=catalogue, progress=progress
        )
        reports.append(report)
        if arguments.format == "text":
            _print_report(report)
            sys.stdout.flush()
    if arguments.format == "json":
        print_json(as_data(reports))
    elif arguments.format == "text":
        _print_verdict(reports, time.perf_counter() - started)
    return 0 if all(report.ok for report in reports) else 1


def _print_report(report: TaskReport) -> None:
    print(paint(report.headline, "bold"))
    rows = []
    for family in report.families:
        mark = paint("ok  ", "green") if family.ok else paint("FAIL", "red")
        rows.append([family.name, mark, family.summary, f"{family.seconds:.1f} s"])
    print()
    print_table(rows, indent="  ")
    print()
    for finding in in_reading_order(report.findings):
        print(show_finding(finding))
    if report.findings:
        print()


def _print_verdict(reports: list[TaskReport], seconds: float) -> None:
    failed = [report.task for report in reports if not report.ok]
    if not failed:
        print(f"{paint('ok', 'green')} in {seconds:.1f} s")
        return
    errors = sum(f.severity == "error" for report in reports for f in report.findings)
    counted = f"{errors} error{'s' * (errors != 1)}"
    print(f"{paint('failed', 'red')}: {', '.join(failed)}: {counted} in {seconds:.1f} s")
