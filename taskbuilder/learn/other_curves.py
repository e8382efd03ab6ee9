"""Learning curves of other software, from CSV files, to draw beside those of runs."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taskbuilder.errors import display_path
from taskbuilder.learn.logs import LogError, damaged
from taskbuilder.learn.run_groups import RunCurve

CURVES = ("success_rate", "team_return")
"""Columns that are drawn; a file has at least one of them."""


@dataclass(frozen=True)
class OtherCurves:
    """The learning curves of one setup of another learner.

    Attributes:
        name: Name of the file, without its ending.
        seeds: Number of seeds.
        success: Success rate of evaluations, a line for each seed.
        team_return: Team return, a line for each seed.
    """

    name: str
    seeds: int
    success: tuple[RunCurve, ...]
    team_return: tuple[RunCurve, ...]


def read_curves(path: Path) -> OtherCurves:
    """Read a CSV file with the columns ``step`` and ``success_rate``, ``team_return`` or both.

    Rows with the same value in the column ``seed``, if there is one, form a line. Other columns
    are ignored, and so are empty values.

    Raises:
        LogError: A column is missing, a value is not a number, or there are no rows.
        OSError: The file cannot be read.
    """
    points: Mapping[str, dict[str, list[tuple[float, float]]]]
    points = {name: defaultdict(list) for name in CURVES}
    seeds = set()
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        rows = csv.DictReader(file, restval="")
        _check_columns(path, rows.fieldnames or ())
        for row in rows:
            for name, lines in points.items():
                if row.get(name):
                    step, value = (_number(path, rows.line_num, key, row) for key in ("step", name))
                    if name == "success_rate" and not 0.0 <= value <= 1.0:
                        what = f"{name} is {value:g}; a fraction from 0 to 1"
                        raise damaged(path, rows.line_num, what)
                    lines[row.get("seed", "")].append((step, value))
                    seeds.add(row.get("seed", ""))
    if not seeds:
        raise LogError(f"{display_path(path)} has no rows with a value")
    success, team_return = (tuple(map(_line, points[name].values())) for name in CURVES)
    return OtherCurves(path.stem, len(seeds), success, team_return)


def _check_columns(path: Path, names: object) -> None:
    columns = tuple(names) if isinstance(names, list | tuple) else ()
    if "step" not in columns or not set(CURVES) & set(columns):
        has = ", ".join(columns) or "none"
        raise damaged(
            path, 1, f"needs the columns step and {' or '.join(CURVES)}; the columns are {has}"
        )


def _number(path: Path, line: int, name: str, row: Mapping[str, str]) -> float:
    try:
        value = float(row[name])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise damaged(path, line, f'{name} is "{row[name]}", which is no number')
    return value


def _line(points: list[tuple[float, float]]) -> RunCurve:
    steps, values = np.array(sorted(points)).T
    return steps, values
