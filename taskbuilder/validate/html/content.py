"""What templates ask of reports, tasks and pictures."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.assets.codes import CODES as ASSET_CODES
from taskbuilder.diagnostics import CODES
from taskbuilder.diagnostics.foreign import foreign_codes
from taskbuilder.errors import Finding
from taskbuilder.schema.expert import ExpertStage, Repeat, Wait, orders_of
from taskbuilder.validate.formats.words import counted, measured, number, severities
from taskbuilder.validate.html.excerpt import Line, excerpt
from taskbuilder.validate.html.pictures import Picture
from taskbuilder.validate.report import Check, TaskReport

_UNITS = {"_s": "s", "_ms": "ms", "_us": "µs", "_m": "m", "_mm": "mm", "_hz": "Hz", "_mb": "MB"}
"""Endings of the names of measures, and the units that they stand for."""


@dataclass(frozen=True)
class Explained:
    """A finding with its explanation.

    Attributes:
        finding: What was found.
        title: What its code stands for in a few words, or "".
        meaning: What its code means, where that was not said before, or "".
        lines: Of the file that it speaks of.
    """

    finding: Finding
    title: str
    meaning: str
    lines: tuple[Line, ...]


def explained(findings: Sequence[Finding]) -> Iterator[Explained]:
    """All findings, with the meaning of each code where it stands first."""
    said: set[str] = set()
    for finding in findings:
        title, meaning = _meaning(finding.code)
        first = finding.code not in said
        said.add(finding.code)
        yield Explained(finding, title, meaning if first else "", excerpt(finding.location))


def _meaning(code: str) -> tuple[str, str]:
    """The title of a code, and its meaning; both "" for an unknown one."""
    if code in CODES:
        return CODES[code].title, CODES[code].meaning
    if code in ASSET_CODES:
        return ASSET_CODES[code]
    foreign = (about for other, about, _ in foreign_codes() if other == code)
    about = next(foreign, None)
    return (about.title, about.meaning) if about else ("", "")


def found_wrong(report: TaskReport) -> str:
    """How much is wrong with a task: ``2 errors, 1 warning``, or ""."""
    counts = zip(severities(report), ("error", "warning"), strict=True)
    return ", ".join(counted(count, word) for count, word in counts if count)


def limit(check: Check) -> str:
    """The limit, without the unit where what was measured has it, too."""
    if check.limit is None:
        return ""
    return measured(check.limit, check.unit if check.unit == "share" else "")


def with_units(measures: Mapping[str, float]) -> Iterator[tuple[str, str]]:
    """Figures in words, by name; endings of names tell their units."""
    for name, value in measures.items():
        ending = next((ending for ending in _UNITS if name.endswith(ending)), "")
        words = name.removesuffix(ending).replace("_", " ")
        yield words, measured(value, _UNITS.get(ending, ""))


def orders(stage: ExpertStage) -> list[tuple[str, str]]:
    """Who does what in a stage: ``("left", "grasp stick.left_end")``.

    What a stage repeats follows it.
    """
    if isinstance(stage, Wait):
        return [("all", f"wait {stage}, at most {stage.within:g} s")]
    if isinstance(stage, Repeat):
        unless = f", unless {stage.unless}" if stage.unless else ""
        inner = [pair for part in stage.stages for pair in orders(part)]
        return [("all", f"{stage}{unless}:"), *inner]
    return [
        (who, f"{order}, {number(100 * order.above)} cm above" if order.above else str(order))
        for who, order in orders_of(stage)
    ]


def data_uri(picture: Picture) -> str:
    """A picture in the form in which it is part of the page itself."""
    return f"data:image/jpeg;base64,{b64encode(picture.jpeg).decode('ascii')}"
