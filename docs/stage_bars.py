"""A chart of the furthest stages that training runs reached: one bar a run, all its episodes."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from taskbuilder.visual.charts import GRAY, INK, PAPER
from taskbuilder.visual.curves import stage_colors

_DPI, _WIDTH = 110, 9.5  # inches, as what follows
_BAR, _GROUP_GAP = 0.26, 0.14
_ABOVE, _BELOW, _LABELS, _RIGHT = 1.35, 0.6, 3.3, 0.35


def stage_bars(
    title: str, subtitle: str, groups: Mapping[str, Sequence[tuple[str, Mapping[str, int]]]]
) -> bytes:
    """Draw a stacked bar for each run: the share of its episodes by furthest stage.

    Args:
        title: In large letters.
        subtitle: Below it.
        groups: The runs of each way of training: their labels, and their numbers of episodes by
            the name of the furthest stage, none (an empty name) first.

    Returns:
        A PNG.
    """
    names = list(next(iter(groups.values()))[0][1])
    colors = stage_colors(len(names) - 1)
    bars = sum(map(len, groups.values()))
    body = bars * _BAR + len(groups) * _GROUP_GAP
    height = _ABOVE + body + _BELOW
    figure = Figure(figsize=(_WIDTH, height), dpi=_DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    place = (_LABELS / _WIDTH, _BELOW / height, 1 - (_LABELS + _RIGHT) / _WIDTH, body / height)
    axes = figure.add_axes(place, facecolor=PAPER)
    at, ticks = 0.0, []
    for way, runs in groups.items():
        middle = at + (len(runs) - 1) * _BAR / 2
        axes.text(
            -0.09,
            middle,
            way,
            transform=axes.get_yaxis_transform(),
            color=INK,
            fontsize=9.5,
            ha="right",
            va="center",
        )
        for label, counts in runs:
            left, total = 0.0, sum(counts.values())
            for name, color in zip(reversed(names), reversed(colors), strict=True):
                share = counts[name] / total
                axes.barh(at, share, left=left, height=0.82 * _BAR, color=color)
                left += share
            ticks.append((at, label))
            at += _BAR
        at += _GROUP_GAP
    axes.set_ylim(at - _GROUP_GAP - _BAR / 2 + 0.05, -_BAR / 2 - 0.05)
    axes.set_yticks([tick for tick, _ in ticks], [label for _, label in ticks])
    axes.set_xlim(0.0, 1.0)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("episodes", color=GRAY, fontsize=8.5)
    axes.tick_params(colors=GRAY, labelsize=8.5, length=0)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(GRAY)
    _head(figure, title, subtitle)
    patches = [
        Patch(color=color, label=name or "none")
        for name, color in zip(reversed(names), reversed(colors), strict=True)
    ]
    figure.legend(
        handles=patches,
        loc="upper left",
        ncols=len(patches),
        frameon=False,
        fontsize=8.5,
        labelcolor=INK,
        handlelength=0.9,
        columnspacing=1.4,
        bbox_to_anchor=(0.22 / _WIDTH, 1 - 0.88 / height),
    )
    file = io.BytesIO()
    figure.savefig(file, format="png", facecolor=PAPER, metadata={"Software": None})
    return file.getvalue()


def _head(figure: Figure, title: str, subtitle: str) -> None:
    height = figure.get_figheight()
    figure.text(
        0.3 / _WIDTH,
        1 - 0.4 / height,
        title,
        color=INK,
        fontsize=16,
        fontweight="bold",
        va="center",
    )
    figure.text(0.3 / _WIDTH, 1 - 0.72 / height, subtitle, color=GRAY, fontsize=9.5, va="center")
