"""Parts of a page that need no pictures: its head, the families of checks, figures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from taskbuilder import __version__
from taskbuilder.validate.formats.blame import why_skipped
from taskbuilder.validate.formats.markup import Content, Html, element
from taskbuilder.validate.formats.words import counted, duration, measured, severities
from taskbuilder.validate.report import Check, FamilyResult, Making, TaskReport

_UNITS = {"_s": "s", "_ms": "ms", "_us": "µs", "_m": "m", "_mm": "mm", "_hz": "Hz", "_mb": "MB"}
"""Endings of the names of measures, and the units that they stand for."""


def section(title: str, *content: Content, note: Content = None) -> Html:
    """A titled part of a page, with a line under the title that says how to read it."""
    head = element("header", element("h2", title), element("p", note) if note else None)
    return element("section", head, element("div", *content, class_="body"))


def header(report: TaskReport, summary: str, picture: Html | None) -> Html:
    """The task's name, what it is, and the verdict."""
    name, _, facts = report.headline.partition(" · ")
    words = element(
        "div",
        element("h1", name),
        element("p", summary, class_="summary") if summary else None,
        element("p", facts, class_="facts") if facts else None,
        verdict(report),
    )
    return element("header", words, picture, class_="top")


def verdict(report: TaskReport) -> Html:
    """Whether the task passed, and over what."""
    errors, warnings = severities(report)
    checks = sum(len(family.checks) for family in report.families)
    word = "Passed" if report.ok else "Failed"
    found = ", ".join(
        counted(n, what) for n, what in ((errors, "error"), (warnings, "warning")) if n
    )
    return element(
        "p",
        element("strong", f"{word}: {found}" if found else word),
        f"{counted(checks, 'check')} in {duration(report.seconds)}",
        class_="verdict ok" if report.ok else "verdict failed",
    )


def families(report: TaskReport) -> Html:
    """A row for each family, which opens to its checks and their figures."""
    why = why_skipped(report)
    skipped = [
        element("div", _row("skipped", name, why, ""), class_="skipped") for name in report.skipped
    ]
    return element("div", map(_family, report.families), skipped, class_="families")


def _family(family: FamilyResult) -> Html:
    state = "ok" if family.ok else "failed"
    return element(
        "details",
        _row(state, family.name, family.summary, f"{family.seconds:.1f} s", tag="summary"),
        _checks(family.checks),
        class_=state,
        open=state == "failed",
    )


def _row(state: str, name: str, summary: str, time: str, *, tag: str = "div") -> Html:
    return element(
        tag,
        element("span", state, class_="state"),
        element("b", name),
        element("span", summary, class_="figures"),
        element("time", time),
        class_="row",
    )


def _checks(checks: Iterable[Check]) -> Html:
    head = ("check", "measured", "limit", "code")
    rows = [element("tr", [element("th", word, scope="col") for word in head])]
    for check in checks:
        cells = (check.name, measured(check.value, check.unit), _limit(check), check.code)
        row = [element("td", cell) for cell in cells]
        rows.append(element("tr", row, class_=None if check.ok else "failed"))
    return element("table", rows)


def _limit(check: Check) -> str:
    """The limit, without the unit where what was measured has it, too."""
    if check.limit is None:
        return ""
    return measured(check.limit, check.unit if check.unit == "share" else "")


def measures(figures: Mapping[str, float]) -> Html:
    """Figures by name; endings of names tell their units."""
    listed = []
    for name, value in figures.items():
        ending = next((ending for ending in _UNITS if name.endswith(ending)), "")
        words = name.removesuffix(ending).replace("_", " ")
        listed.append(
            element(
                "div", element("dt", words), element("dd", measured(value, _UNITS.get(ending, "")))
            )
        )
    return element("dl", listed, class_="measures")


def made(making: Making) -> Html:
    """How a report was made: what makes it once more, from what, and when."""
    versions = ", ".join(f"{name} {which}" for name, which in making.versions.items())
    said = {
        "level": making.level,
        "seeds": f"0 to {making.seeds - 1}"
        if making.seeds > 1
        else "0"
        if making.seeds
        else "none",
        "date": making.date,
        "time": duration(making.seconds),
        "versions": versions,
        "command": element("code", making.command) if making.command else "validate_task in Python",
    }
    listed = [
        element("div", element("dt", name), element("dd", value)) for name, value in said.items()
    ]
    return element("dl", listed, class_="measures")


def footer() -> Html:
    """What made the page."""
    return element("footer", element("p", f"taskbuilder {__version__}"))
