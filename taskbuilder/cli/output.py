"""Printing for people: colour on terminals only, tables, progress."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import sys
import textwrap
import time
from collections.abc import Iterable, Iterator, Sequence, Sized
from contextlib import contextmanager
from functools import partial
from typing import Any, TextIO, TypeVar

from taskbuilder.errors import Finding
from taskbuilder.wording import duration

Item = TypeVar("Item")

_CODES = {"red": "31", "green": "32", "yellow": "33", "dim": "2", "bold": "1"}
_COLORED = re.compile(r"\x1b\[\d+m")

NARROWEST = 20
"""Columns that a wrapped text gets at least."""

LINE_EVERY_S = 30.0
"""Seconds between lines that report progress where standard error is no terminal."""


def paint(text: str, color: str, stream: TextIO | None = None) -> str:
    """The text in a colour, if the stream is a terminal and NO_COLOR is not set."""
    stream = stream or sys.stdout
    if not stream.isatty() or os.environ.get("NO_COLOR"):
        return text
    return f"\x1b[{_CODES[color]}m{text}\x1b[0m"


_result: list[TextIO] = []
"""Where results go while standard output is kept for them alone; the last counts."""


@contextmanager
def results_alone() -> Iterator[None]:
    """Nothing gets to standard output but what `emit` prints, not even from C.

    What descriptions and the physics engine print meanwhile goes to standard error.
    """
    from taskbuilder.quiet import printing_to_stderr  # loads what a command loads anyway

    sys.stdout.flush()
    encoding = sys.stdout.encoding
    # errors: a path may hold bytes that are no text; in JSON this is how they are written
    with open(os.dup(1), "w", encoding=encoding, errors="backslashreplace") as stream:  # noqa: PTH123
        _result.append(stream)
        try:
            with printing_to_stderr():
                yield
        finally:
            _result.pop()


def emit(text: str) -> None:
    """Print a part of the result."""
    print(text, file=_result[-1] if _result else sys.stdout, flush=bool(_result))


def print_json(data: Any) -> None:
    """One JSON document on standard output."""
    stream = _result[-1] if _result else sys.stdout
    unicode = (stream.encoding or "").lower().replace("-", "").startswith("utf")
    emit(json.dumps(data, indent=2, ensure_ascii=not unicode))


def ready_streams() -> None:
    """Make standard output and error take anything, closed ones and narrow encodings too."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:  # else the next file to be opened would get what is printed
            os.open(os.devnull, os.O_RDWR)
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        if stream is None:
            stream = open(descriptor, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
            setattr(sys, name, stream)
        if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
            stream.reconfigure(errors="backslashreplace")


def print_table(rows: Sequence[Sequence[str]], indent: str = "", *, prose: bool = False) -> None:
    """Rows with aligned columns.

    Args:
        rows: A text for each column.
        indent: What each line begins with.
        prose: Whether the last column is prose, to be wrapped where the terminal is too narrow.
            Commands and paths are not: they are to be copied from one line.
    """
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)] if rows else []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
        start = indent + "".join(f"{cell}  " for cell in cells)
        line = _wrapped(start, row[-1], f"{indent}    ") if prose else start + row[-1]
        print(line.rstrip())


def _wrapped(start: str, text: str, below: str) -> str:
    """A row and its last column, within the width of the terminal if there is one.

    Where too little room is left beside the row, the text goes on lines of its own.
    """
    columns, begin = shutil.get_terminal_size().columns, _visible(start)
    if not sys.stdout.isatty() or begin + _visible(text) <= columns:
        return start + text
    lines = partial(textwrap.wrap, text, break_long_words=False)
    if columns - begin >= NARROWEST:
        return start + f"\n{' ' * begin}".join(lines(columns - begin))
    return f"\n{below}".join([start.rstrip(), *lines(max(columns - len(below), NARROWEST))])


def print_title(text: str) -> None:
    """A line in bold; where the terminal is too narrow, it goes on below, indented.

    It is broken between words, and a path that is longer than a line after a slash.
    """
    columns = max(shutil.get_terminal_size().columns, NARROWEST)
    lines = [text]
    if sys.stdout.isatty() and len(text) > columns:
        lines = _broken(text, columns, below="  ")
    for line in lines:
        print(paint(line, "bold"))


def _broken(text: str, columns: int, below: str) -> list[str]:
    """The lines of a text; all but the first begin with what is to stand below."""
    lines = [""]
    for word in text.split(" "):
        apart = f"{lines[-1]} {word}" if lines[-1].strip() else lines[-1] + word
        if len(apart) <= columns:
            lines[-1] = apart
        elif len(below + word) <= columns:
            lines.append(below + word)
        else:
            lines[-1] += " " if lines[-1].strip() else ""
            for piece in re.findall(r"[^/]*/|[^/]+", word):
                if len(lines[-1] + piece) > columns and lines[-1].strip():
                    lines.append(below)
                lines[-1] += piece
    return [line.rstrip() for line in lines]


def _visible(text: str) -> int:
    """The number of columns that a text takes on a terminal."""
    return len(_COLORED.sub("", text))


def show_finding(finding: Finding) -> str:
    """A finding with its severity in colour."""
    color = "red" if finding.severity == "error" else "yellow"
    mark = f"{finding.severity}[{finding.code}]"
    return str(finding).replace(mark, paint(mark, color), 1)


def progress(items: Iterable[Item], label: str, total: int | None = None) -> Iterable[Item]:
    """The items, with a bar on standard error; where that is no terminal, now and then a line."""
    if not sys.stderr.isatty():
        return _counted(items, label, total)
    from tqdm import tqdm

    bar: Iterable[Item] = tqdm(
        items, desc=f"  {label}", total=total, leave=False, unit="", delay=0.3
    )
    return bar


def _counted(items: Iterable[Item], label: str, total: int | None) -> Iterator[Item]:
    """The items, with a line on standard error every `LINE_EVERY_S` seconds."""
    if total is None and isinstance(items, Sized):
        total = len(items)
    begun = last = time.monotonic()
    for number, item in enumerate(items):
        if time.monotonic() - last >= LINE_EVERY_S:
            last = time.monotonic()
            of = "" if total is None else f" of {total}{_left(number, total, last - begun)}"
            print(f"taskbuilder: {label}: {number}{of}", file=sys.stderr, flush=True)
        yield item


def _left(done: int, total: int, passed_s: float) -> str:
    """How long the rest of some items takes, at the pace of those that are done."""
    return f", about {duration(passed_s / done * (total - done))} left" if done else ""


def warn(text: str) -> None:
    """Print a warning on standard error."""
    print(f"taskbuilder: warning: {text}", file=sys.stderr, flush=True)


def can_ask() -> bool:
    """Whether there is somebody at a terminal who can answer a question."""
    return sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()


def confirmed(question: str) -> bool:
    """Ask a question on the terminal; whether the answer is yes."""
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def say(line: str) -> None:
    """Print a line at once, above a bar of `progress` if there is one."""
    if not sys.stderr.isatty():
        print(line, flush=True)
        return
    from tqdm import tqdm

    tqdm.write(line, file=sys.stdout)
