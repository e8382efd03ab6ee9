"""`taskbuilder fix`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from taskbuilder.cli.output import can_ask, confirmed, paint, show_finding
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.errors import Finding, UsageError, display_path
from taskbuilder.fixes import Correction, correct
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.validate.runner import validate_task

MOST_ROUNDS = 20
"""A correction can bring other findings to light, such as the names in a section once misspelt."""


def run(arguments: argparse.Namespace) -> int:
    """Show corrections of a task's files as a difference, and make them."""
    catalogue = catalogue_of(arguments)
    entry = catalogue.task(arguments.task)
    for _ in range(MOST_ROUNDS):
        findings = validate_task(entry.file, level="static", catalogue=catalogue).findings
        corrections = correct(f.fix for f in findings if f.fix and _is_own(f, entry))
        if not corrections:
            break
        _show(corrections)
        if not _agreed(arguments):
            return 1
        for correction in corrections:
            correction.write()
            print(f"{display_path(correction.file)} is corrected")
    return _tell_of(findings)


def _is_own(finding: Finding, entry: CatalogueEntry) -> bool:
    """Whether a fix is for one of the task's own two files."""
    return finding.fix is not None and finding.fix.location.file in (
        entry.file,
        entry.description_file,
    )


def _show(corrections: Sequence[Correction]) -> None:
    colors = {"+": "green", "-": "red"}
    for correction in corrections:
        for line in correction.diff().splitlines():
            color = colors.get(line[:1]) if line[:3] not in ("+++", "---") else "bold"
            print(paint(line, color) if color else line)


def _agreed(arguments: argparse.Namespace) -> bool:
    """Whether the difference that was shown is to be written."""
    if arguments.yes:
        return True
    if not can_ask():
        raise UsageError("nothing is written; --yes writes these corrections")
    return confirmed("Write these corrections?")


def _tell_of(findings: Sequence[Finding]) -> int:
    """What is left for a person to decide; the exit status."""
    for finding in findings:
        print(show_finding(finding))
    wrong = sum(finding.severity == "error" for finding in findings)
    if not findings:
        print("the static checks find nothing to correct")
    return 1 if wrong else 0
