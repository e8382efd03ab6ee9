"""The lines of a file that a finding speaks of."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.errors import Location

AROUND = 2
"""How many lines are shown before and after."""

LARGEST_BYTES = 1024 * 1024
LONGEST_LINE = 160

_WORD = re.compile(r"[\w.-]+|\"[^\"]*\"|'[^']*'|.")


@dataclass(frozen=True)
class Line:
    """A line of a file, cut where it is very long.

    Attributes:
        number: From 1.
        before: Its text up to what is marked; all of it where nothing is.
        marked: What the finding speaks of, or "".
        after: The rest.
        spoken_of: Whether it is the finding's line.
    """

    number: int
    before: str
    marked: str = ""
    after: str = ""
    spoken_of: bool = False


def excerpt(location: Location | None) -> tuple[Line, ...]:
    """The lines around a place; none where the file cannot be shown."""
    if location is None or not location.line:
        return ()
    lines = _lines(location.file)
    if not location.line <= len(lines):
        return ()
    first = max(location.line - AROUND, 1)
    last = min(location.line + AROUND, len(lines))
    return tuple(
        _marked(number, lines[number - 1], location.column)
        if number == location.line
        else Line(number, lines[number - 1][:LONGEST_LINE])
        for number in range(first, last + 1)
    )


def _lines(file: Path) -> list[str]:
    try:
        if not file.is_file() or file.stat().st_size > LARGEST_BYTES:
            return []
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []  # gone since, or not ours to read
    return text.removesuffix("\n").split("\n")


def _marked(number: int, text: str, column: int) -> Line:
    """A line with the word at its column marked."""
    if not 1 <= column <= len(text):
        return Line(number, text[:LONGEST_LINE], spoken_of=True)
    start = column - 1
    end = _end(text, start)
    first = max(0, start - LONGEST_LINE // 2) if len(text) > LONGEST_LINE else 0
    return Line(
        number,
        text[first:start],
        text[start:end][:LONGEST_LINE],
        text[end : first + LONGEST_LINE],
        spoken_of=True,
    )


def _end(text: str, start: int) -> int:
    """Where a word ends, or a bracket that closes in this line."""
    if text[start] in "([{":
        depth = 0
        for place in range(start, len(text)):
            depth += (text[place] in "([{") - (text[place] in ")]}")
            if not depth:
                return place + 1
    found = _WORD.match(text, start)
    return found.end() if found else start + 1
