"""Charts, as PNG; the only module that draws with matplotlib, which takes a second to load."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

# Distinct to all kinds of eyes (Okabe and Ito); the yellow of that palette is too pale for paper.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
DASHES = ("-", (0, (4, 1.5)), (0, (1, 1.2)))
INK, GRAY, PAPER, GREEN = "#2B2826", "#7A746E", "#FCFBFA", "#168048"

_TEAM = "team"
_ROOM = 1.35  # between two labels, in heights of one
_ROWS = 3  # of labels above the axes
_DPI = 110


@dataclass(frozen=True)
class Mark:
    """Something that happened at a control step.

    Attributes:
        step: Control steps that had passed.
        label: What it was.
        good: Drawn in green.
    """

    step: int
    label: str
    good: bool = False


def reward_chart(
    title: str,
    subtitle: str,
    terms: Mapping[str, NDArray[np.float64]],
    team: NDArray[np.float64],
    marks: Sequence[Mark] = (),
) -> bytes:
    """What an episode paid at each control step: a thin line a term, and the team's in bold.

    Args:
        title: In large letters.
        subtitle: Below it.
        terms: (steps,) pay of each reward term by its label.
        team: (steps,) the team's reward.
        marks: What happened; upright lines with labels above.

    Returns:
        A PNG.
    """
    figure = Figure(figsize=(9.0, 5.0), dpi=_DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.07, 0.11, 0.73, 0.66), facecolor=PAPER)
    figure.text(0.03, 0.93, title, color=INK, fontsize=15, fontweight="bold")
    figure.text(0.03, 0.885, subtitle, color=GRAY, fontsize=9.5)
    _plain(axes)
    steps = np.arange(1, len(team) + 1)
    styles = ((color, dash) for dash in cycle(DASHES) for color in COLORS)
    labels = []
    for (label, pay), (color, dash) in zip(terms.items(), styles, strict=False):
        axes.plot(steps, pay, color=color, linestyle=dash, linewidth=1.3)
        labels.append((float(pay[-1]) if len(pay) else 0.0, label, color, "normal"))
    axes.plot(steps, team, color=INK, linewidth=2.4, solid_capstyle="round")
    labels.append((float(team[-1]) if len(team) else 0.0, _TEAM, INK, "bold"))
    axes.set_xlim(0, max(len(team), 1))
    axes.set_xlabel("control step", color=GRAY, fontsize=9)
    axes.set_ylabel("reward", color=GRAY, fontsize=9)
    _label_lines(axes, labels)
    _mark(axes, marks)
    file = io.BytesIO()
    # Without its metadata, that of matplotlib's version, a chart depends on nothing but its data.
    figure.savefig(file, format="png", facecolor=PAPER, metadata={"Software": None})
    return file.getvalue()


def _plain(axes: Axes) -> None:
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(GRAY)
    axes.tick_params(colors=GRAY, labelsize=8.5, length=3)
    axes.grid(axis="y", color="#E7E3DE", linewidth=0.8)
    axes.axhline(0.0, color="#CFC9C2", linewidth=0.9)
    axes.set_axisbelow(True)


def _label_lines(axes: Axes, labels: Sequence[tuple[float, str, str, str]]) -> None:
    """Names at the right ends of lines, moved apart where they would overlap."""
    low, high = axes.get_ylim()
    height = axes.get_window_extent().height
    room = _ROOM * 9.0 / 72.0 * _DPI / height  # as a share of the axes
    ordered = sorted(labels)
    ends = [(value - low) / (high - low) for value, *_ in ordered]
    places = spread(ends, room)
    for place, end, (_, label, color, weight) in zip(places, ends, ordered, strict=True):
        axes.annotate(
            label,
            xy=(1.0, end),
            xytext=(1.035, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            color=color,
            fontsize=9,
            fontweight=weight,
            va="center",
            arrowprops={
                "arrowstyle": "-",
                "color": color,
                "linewidth": 0.7,
                "relpos": (0.0, 0.5),
                "shrinkB": 0,
            },
        )


def spread(places: Sequence[float], room: float) -> list[float]:
    """Rising numbers moved as little as they must be to be at least so far apart."""
    groups: list[list[float]] = []
    for place in places:
        groups.append([place])
        # A group stands evenly around the middle of where its members would be.
        while len(groups) > 1 and _top(groups[-2], room) + room > _bottom(groups[-1], room):
            last = groups.pop()
            groups[-1] += last
    return [_bottom(group, room) + room * index for group in groups for index in range(len(group))]


def _bottom(group: Sequence[float], room: float) -> float:
    return sum(group) / len(group) - room * (len(group) - 1) / 2.0


def _top(group: Sequence[float], room: float) -> float:
    return sum(group) / len(group) + room * (len(group) - 1) / 2.0


def _mark(axes: Axes, marks: Sequence[Mark]) -> None:
    """Upright lines, with labels above them in as many rows as keep them apart."""
    ends: list[float] = []
    for step, group in groupby(sorted(marks, key=_step), key=_step):
        together = list(group)
        good = any(mark.good for mark in together)
        color = GREEN if good else GRAY
        axes.axvline(step, color=color, linewidth=0.9, alpha=0.75, zorder=1)
        text = axes.annotate(
            " · ".join(mark.label for mark in together),
            xy=(step, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, 3),
            textcoords="offset points",
            color=color,
            fontsize=8.5,
            fontweight="bold" if good else "normal",
        )
        left, right = _extent(text)
        row = next((row for row, end in enumerate(ends) if end + 6.0 < left), len(ends)) % _ROWS
        ends[row : row + 1] = [right]
        text.set_position((2, 3 + 11 * row))


def _step(mark: Mark) -> int:
    return mark.step


def _extent(text: Text) -> tuple[float, float]:
    box = text.get_window_extent()
    return box.x0, box.x1
