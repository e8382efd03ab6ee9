"""Figures and counts in words, and text that every format can hold."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from taskbuilder.validate.report import Check, TaskReport

# What XML 1.0 has no way to write, and what UTF-8 has none for.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def printable(text: str) -> str:
    """The text with a mark in place of what no document can hold, such as control characters."""
    return _UNPRINTABLE.sub("\N{REPLACEMENT CHARACTER}", text)


def number(value: float) -> str:
    """A number with three or four digits that count, and a true minus sign."""
    if not math.isfinite(value):
        return str(value)
    if value == int(value) and abs(value) < 1e9:
        text = f"{int(value):,}"
    elif abs(value) >= 1000:
        text = f"{value:,.0f}"
    else:
        text = f"{value:.3g}"
    return text.replace("-", "\N{MINUS SIGN}")


def measured(value: float | None, unit: str) -> str:
    """A figure with its unit; a dash where nothing finite was measured."""
    if value is None:
        return "\N{EN DASH}"
    if unit == "share":
        return f"{number(100.0 * value)} %"
    return f"{number(value)} {unit}".strip()


def figure(check: Check) -> str:
    """What a check measured, and its limit if it has one: ``7.2 mm, limit 5 mm``."""
    text = measured(check.value, check.unit)
    return text if check.limit is None else f"{text}, limit {measured(check.limit, check.unit)}"


def counted(count: int, word: str) -> str:
    """A number of things: ``1 error``, ``2 errors``, ``no errors``."""
    return f"{count or 'no'} {word}{'s' * (count != 1)}"


def listed(names: Sequence[str]) -> str:
    """Names as a sentence has them: ``a, b and c``."""
    *most, last = names or ("nothing",)
    return f"{', '.join(most)} and {last}" if most else last


def severities(report: TaskReport) -> tuple[int, int]:
    """How many errors and how many warnings a report has."""
    errors = sum(finding.severity == "error" for finding in report.findings)
    return errors, len(report.findings) - errors


def closing(reports: Sequence[TaskReport], seconds: float) -> tuple[str, str]:
    """The verdict on all tasks: a word, and the rest of its line.

    ``ok`` and `` in 31 s``, and which tasks have no expert to prove them by; ``failed`` and
    ``: lift: 2 errors in 3.1 s``. A validation of some families only says which.
    """
    failed = [report for report in reports if not report.ok]
    making = reports[0].making if reports else None
    some = f" · only {listed(making.only)}" if making and making.only else ""
    took = f"in {duration(seconds)}{some}"
    if not failed:
        unproved = [report.task for report in reports if not report.has_expert]
        but = f" · not proved, as there is no expert: {', '.join(unproved)}" if unproved else ""
        return "ok", f" {took}{but}"
    errors = sum(severities(report)[0] for report in reports)
    what = f": {counted(errors, 'error')}" if errors else ""
    return "failed", f": {', '.join(report.task for report in failed)}{what} {took}"


def duration(seconds: float) -> str:
    """A time as people say it: ``3.1 s``, ``31 s``, ``2 min 5 s``."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    if seconds < 120:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s"
