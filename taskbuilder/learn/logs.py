"""Reading the plan and tables of a training run, also while it is running."""

from __future__ import annotations

import csv
import gzip
import io
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import TaskbuilderError, display_path
from taskbuilder.learn.plan import Plan, load_plan
from taskbuilder.untrusted import read_within
from taskbuilder.wording import excerpt

Column = NDArray[np.float64]
Table = Mapping[str, Column]
"""Columns of equal length, by name."""

_NEEDED = {
    "episodes": ("step", "episode", "team_return"),
    "evaluations": ("step", "episode", "episodes", "success_rate", "stage/0"),
    "updates": ("step",),
}


class LogError(TaskbuilderError):
    """A table of a run is damaged."""


@dataclass(frozen=True)
class RunLog:
    """The logs of a training run so far.

    Attributes:
        folder: Folder of the run.
        plan: The plan.
        stages: Names of the task's stages, in order; () if the run does not record them.
        episodes: A row for each training episode.
        evaluations: A row for each evaluation.
        updates: A row for about every thousand control steps.
    """

    folder: Path
    plan: Plan
    stages: tuple[str, ...]
    episodes: Table
    evaluations: Table
    updates: Table


_LARGEST = 32 << 20
"""Maximum size of a table in bytes, unpacked: hundreds of thousands of rows."""


def read_run(folder: Path) -> RunLog:
    """Read a training run; its tables may be compressed, such as ``episodes.csv.gz``.

    Raises:
        UsageError: There is no run, or its format is not supported.
        LogError: A table is damaged.
        OSError: A file cannot be read.
    """
    plan, about = load_plan(folder)
    tables = {name: _read(folder / f"{name}.csv", needed) for name, needed in _NEEDED.items()}
    return RunLog(folder, plan, tuple(map(str, about.get("stages", ()))), **tables)


def _read(path: Path, needed: tuple[str, ...]) -> Table:
    """Read a table; a table that does not exist yet has no rows."""
    packed = path.with_name(f"{path.name}.gz")
    if path.exists():
        data = read_within(path.parent, path.name, _LARGEST)
    elif packed.exists():
        path, data = packed, _unpacked(packed)
    else:
        return {name: np.zeros(0) for name in needed}
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise damaged(path, data[: error.start].count(b"\n") + 1, "is no text") from None
    # A line without an end is being written now, or is the last line of a killed run.
    lines = text.split("\n")[:-1]
    rows = csv.reader(lines)
    try:
        names = next(rows, list(needed))
        missing = [name for name in needed if name not in names]
        if missing:
            has = excerpt(", ".join(names))
            raise damaged(path, 1, f"has no column {missing[0]}; the columns are {has}")
        values = [_row(path, rows.line_num, row, names) for row in rows]
    except csv.Error as error:
        raise damaged(path, rows.line_num, str(error)) from None
    array = np.array(values).reshape(-1, len(names))
    columns = dict(zip(names, array.T, strict=True))
    _check_order(path, columns["step"])
    return columns


def _unpacked(path: Path) -> bytes:
    content = read_within(path.parent, path.name, _LARGEST)
    try:
        with gzip.open(io.BytesIO(content)) as file:
            data = file.read(_LARGEST + 1)
    except (gzip.BadGzipFile, EOFError, zlib.error):
        raise LogError(f"{display_path(path)} is damaged, or not compressed with gzip") from None
    if len(data) > _LARGEST:
        raise LogError(f"{display_path(path)} has more than {_LARGEST >> 20} MiB when unpacked")
    return data


def _row(path: Path, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        raise damaged(path, line, f"has {len(row)} values for {len(names)} columns")
    return [_number(path, line, name, word) for name, word in zip(names, row, strict=True)]


def _number(path: Path, line: int, name: str, word: str) -> float:
    try:
        value: float | None = float(word)
    except ValueError:
        value = None
    # Losses may be NaN if the learner diverged; other columns may not.
    if value is None or not (math.isfinite(value) or path.stem == "updates"):
        raise damaged(path, line, f'{excerpt(name)} is "{excerpt(word)}", which is no number')
    return value


def _check_order(path: Path, steps: Column) -> None:
    back = np.flatnonzero(np.diff(steps) < 0)
    if len(back):
        row = int(back[0])
        what = f"step {steps[row + 1]:g} comes after {steps[row]:g}"
        raise damaged(path, row + 3, what)


def damaged(path: Path, line: int, what: str) -> LogError:
    """The error for a line of a table."""
    return LogError(f"{display_path(path)}:{line}: {what}")
