"""Printing for people: colour on terminals only, tables, progress."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Sequence
from typing import Any, TextIO, TypeVar

from taskbuilder.errors import Finding

Item = TypeVar("Item")

_CODES = {"red": "31", "green": "32", "yellow": "33", "dim": "2", "bold": "1"}


def paint(text: str, color: str, stream: TextIO | None = None) -> str:
    """The text in a colour, if the stream is a terminal and NO_COLOR is not set."""
    stream = stream or sys.stdout
    if not stream.isatty() or os.environ.get("NO_COLOR"):
        return text
    return f"\x1b[{_CODES[color]}m{text}\x1b[0m"


def print_json(data: Any) -> None:
    """One JSON document on standard output."""
    print(json.dumps(data, indent=2, ensure_ascii=False))


def print_table(rows: Sequence[Sequence[str]], indent: str = "") -> None:
    """Rows with aligned columns; the last column is left as it is."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)] if rows else []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        print(indent + "  ".join([*cells, row[-1]]).rstrip())


def show_finding(finding: Finding) -> str:
    """A finding with its severity in colour."""
    color = "red" if finding.severity == "error" else "yellow"
    mark = f"{finding.severity}[{finding.code}]"
    return str(finding).replace(mark, paint(mark, color), 1)


def progress(items: Iterable[Item], label: str, total: int | None = None) -> Iterable[Item]:
    """The items, with a bar on standard error while a person is watching it."""
    if not sys.stderr.isatty():
        return items
    from tqdm import tqdm

    bar: Iterable[Item] = tqdm(
        items, desc=f"  {label}", total=total, leave=False, unit="", delay=0.3
    )
    return bar


def say(line: str) -> None:
    """Print a line at once, above a bar of `progress` if there is one."""
    if not sys.stderr.isatty():
        print(line, flush=True)
        return
    from tqdm import tqdm

    tqdm.write(line, file=sys.stdout)
