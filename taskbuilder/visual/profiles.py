"""The picture of a benchmark, as PNG, in the style of `charts`; drawn with matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import shorten
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from numpy.typing import NDArray

from taskbuilder.visual.charts import COLORS, GRAY, INK, PAPER

Numbers = NDArray[np.float64]

_DPI = 110
_WIDTH, _LEFT, _RIGHT, _GAP = 11.0, 0.75, 0.45, 0.55  # inches, as all that follows
_HEADER, _FOOTER, _PANEL = 1.55, 0.6, 2.9
_ROW, _TASK_ROW = 0.34, 0.24  # of a method, and of a task
_NAME_LETTERS = 34
_GRID = "#E7E3DE"
_BOLD: dict[str, Any] = {"color": INK, "fontsize": 10.5, "fontweight": "bold"}


@dataclass(frozen=True)
class MethodLine:
    """A method as it is drawn.

    Attributes:
        name: The method in a few words.
        profile: (n,) the fraction of runs whose score is above each score, and the ends of its
            band, None if there is no band; or None if there is no profile.
        mean: The interquartile mean and the ends of its band; or None if there is none.
        tasks: The scores of the runs of each task, by name of the task.
    """

    name: str
    profile: tuple[Numbers, Numbers | None, Numbers | None] | None
    mean: tuple[float, float | None, float | None] | None
    tasks: dict[str, Sequence[float]]


def benchmark_picture(
    title: str, subtitle: Sequence[str], scores: Numbers, lines: Sequence[MethodLine]
) -> bytes:
    """Performance profiles, interquartile means, and the runs of every task.

    Args:
        title: In large letters.
        subtitle: Lines below it.
        scores: (n,) scores of the profiles, from 0 to 1.
        lines: At least one method.

    Returns:
        A PNG.
    """
    tasks = list(dict.fromkeys(task for line in lines for task in line.tasks))
    below = max(_TASK_ROW * max(len(tasks), 3), 0.8)
    height = _HEADER + _PANEL + 1.05 + below + _FOOTER
    figure = Figure(figsize=(_WIDTH, height), dpi=_DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    figure.text(0.3 / _WIDTH, 1.0 - 0.4 / height, title, va="center", color=INK, fontsize=16,
                fontweight="bold")  # fmt: skip
    for number, line in enumerate(subtitle):
        at = 1.0 - (0.72 + 0.24 * number) / height
        figure.text(0.3 / _WIDTH, at, line, va="center", color=GRAY, fontsize=9.5)
    top = height - _HEADER

    def panel(left: float, width: float, top: float, tall: float) -> Axes:
        place = (left / _WIDTH, (top - tall) / height, width / _WIDTH, tall / height)
        return figure.add_axes(place, facecolor=PAPER)

    half = 0.54 * (_WIDTH - _LEFT - _RIGHT)
    _profiles(panel(_LEFT, half, top, _PANEL), scores, lines)
    names = _LEFT + half + _GAP
    rows = min(_PANEL, max(_ROW * 2 * len(lines), 0.9))
    _means(panel(names, _WIDTH - _RIGHT - names, top, rows), lines)
    room = 2.0
    wide = _WIDTH - _LEFT - room - _RIGHT
    _by_task(panel(_LEFT + room, wide, top - _PANEL - 1.05, below), tasks, lines)
    file = io.BytesIO()
    # Without its metadata, that of matplotlib's version, a picture depends on nothing but its data.
    figure.savefig(file, format="png", facecolor=PAPER, metadata={"Software": None})
    return file.getvalue()


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]


def _short(name: str) -> str:
    return shorten(name, _NAME_LETTERS, placeholder=" …") or name[:_NAME_LETTERS]


def _style(axes: Axes, title: str, *, grid: str) -> None:
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(GRAY)
    axes.tick_params(colors=GRAY, labelsize=8.5, length=3)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis=grid, color=_GRID, linewidth=0.8)  # type: ignore[arg-type]  # a name of an axis
    axes.set_axisbelow(True)
    axes.set_title(title, loc="left", pad=8, **_BOLD)
    axes.set_xlim(0.0, 1.0)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))


def _profiles(axes: Axes, scores: Numbers, lines: Sequence[MethodLine]) -> None:
    _style(axes, "performance profile", grid="both")
    axes.set_ylim(0.0, 1.02)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("success at the last step, τ", color=GRAY, fontsize=8.5)
    axes.set_ylabel("runs whose success is above τ", color=GRAY, fontsize=8.5)
    for number, line in enumerate(lines):
        if line.profile is None:
            continue
        value, low, high = line.profile
        if low is not None and high is not None:
            axes.fill_between(
                scores, low, high, step="post", color=_color(number), alpha=0.16, linewidth=0
            )
        axes.step(scores, value, where="post", color=_color(number), linewidth=2.0, clip_on=False)


def _means(axes: Axes, lines: Sequence[MethodLine]) -> None:
    _style(axes, "interquartile mean of success at the last step", grid="x")
    axes.set_ylim(2.0 * len(lines) - 0.5, -0.5)
    axes.set_yticks([])
    for number, line in enumerate(lines):
        color, at = _color(number), 2.0 * number + 1.0
        axes.text(0.0, at - 0.75, _short(line.name), color=color, fontsize=9, va="center")
        if line.mean is None:
            axes.text(0.0, at, "no figure: not complete", color=GRAY, fontsize=8.5, va="center")
            continue
        value, low, high = line.mean
        if low is not None and high is not None:
            axes.barh(at, high - low, left=low, height=0.42, color=color, alpha=0.25, linewidth=0)
        axes.plot([value, value], [at - 0.3, at + 0.3], color=color, linewidth=2.4, clip_on=False)


def _by_task(axes: Axes, tasks: Sequence[str], lines: Sequence[MethodLine]) -> None:
    _style(axes, "every run: success at the last step", grid="both")
    axes.set_ylim(len(tasks) - 0.5, -0.5)
    axes.set_yticks(range(len(tasks)), [_short(task) for task in tasks])
    axes.tick_params(axis="y", colors=INK)
    apart = 0.5 / max(len(lines), 1)
    for number, line in enumerate(lines):
        shift = (number - (len(lines) - 1) / 2.0) * apart
        points = [(s, tasks.index(task) + shift) for task, own in line.tasks.items() for s in own]
        if points:
            x, y = zip(*points, strict=True)
            style: dict[str, Any] = {
                "markersize": 5.0,
                "alpha": 0.75,
                "markeredgewidth": 0.0,
                "clip_on": False,
            }
            axes.plot(x, y, "o", color=_color(number), **style)
