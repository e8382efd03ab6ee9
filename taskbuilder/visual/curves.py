"""Learning curves, as PNG or SVG, in the style of `charts`.

Drawn with matplotlib, of the extra `plot`, which takes a second to load.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import shorten, wrap
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.textpath import TextPath
from matplotlib.ticker import FuncFormatter, MaxNLocator, PercentFormatter
from numpy.typing import NDArray

from taskbuilder.visual.charts import COLORS, GRAY, GREEN, INK, PAPER

Numbers = NDArray[np.float64]

_DPI = 110
_WIDTH, _LEFT, _RIGHT = 11.0, 0.72, 0.35  # inches, as all that follows
_GAP = 0.62  # between columns
_COLUMNS = 4  # of small panels
_LINE = 0.24  # of text
_SUBTITLE_LETTERS = 130  # that fit on a line
_NAMES, _MARGIN = 1.05, 0.2  # least room for the names of stages, and beside the longest
_NAME_SIZE, _NAME_LETTERS = 8.5, 30  # of a name, in points, and how many letters are shown
_ROUND = [1, 2, 2.5, 5, 10]  # what ticks are multiples of
_BOLD: Mapping[str, Any] = {"color": INK, "fontsize": 10.5, "fontweight": "bold"}
_GRID, _NONE, _PALE, _DEEP = "#E7E3DE", "#DDD8D2", "#CBE0EF", "#0072B2"


@dataclass(frozen=True)
class Curve:
    """A quantity over environment steps, for runs that are alike.

    Attributes:
        runs: (n,) steps and (n,) values of each run.
        middle: (m,) steps, interquartile mean, and low and high end of its band; None for one run.
    """

    runs: Sequence[tuple[Numbers, Numbers]]
    middle: tuple[Numbers, Numbers, Numbers, Numbers] | None = None


@dataclass(frozen=True)
class Group:
    """Runs that are alike, which share a colour.

    Attributes:
        label: What sets them off from the others.
        count: How many runs there are.
        success: Success rate of evaluations, 0 to 1; None if it is not known, as for the others.
        at_end: Rate of success at the last control step of evaluations.
        team_return: Of training episodes.
        terms: Sum of each reward term over a training episode, by label.
        stages: (n,) steps of evaluations, and (stages + 1, n) shares of their episodes by
            furthest stage, none first.
    """

    label: str
    count: int
    success: Curve | None
    at_end: Curve | None
    team_return: Curve | None
    terms: Mapping[str, Curve]
    stages: tuple[Numbers, Numbers] | None


@dataclass(frozen=True)
class _Row:
    """Panels side by side: their height, the room above them, and what they show together."""

    height: float
    above: float
    places: Sequence[tuple[float, float]]  # left and width of each
    heading: str = ""


def learning_curves(
    title: str,
    subtitle: Sequence[str],
    groups: Sequence[Group],
    stages: Sequence[str],
    episodes_at: Callable[[Numbers], Numbers],
    form: Literal["png", "svg"] = "png",
) -> bytes:
    """How training went: success and return, every reward term, and the stages reached.

    Args:
        title: In large letters.
        subtitle: Lines below it; long ones are wrapped.
        groups: At least one with stages, and an evaluation in each of these.
        stages: Names of the stages, in order; those that have none are numbered.
        episodes_at: Training episodes that have ended after so many steps, for the upper axis.
        form: Of the picture.

    Returns:
        A PNG or an SVG.
    """
    subtitle = [part for line in subtitle for part in wrap(line, _SUBTITLE_LETTERS)]
    labels = list(dict.fromkeys(label for group in groups for label in group.terms))
    staged = [group for group in groups if group.stages is not None]
    rows = [_Row(2.75, 0.95, _even(2)), *_small_rows(len(labels))]
    rows += _stage_rows(len(staged), stages)
    header = _LINE * (2.6 + len(subtitle) + (len(groups) if len(groups) > 1 else 0))
    height = header + sum(row.above + row.height for row in rows) + 0.6
    figure = Figure(figsize=(_WIDTH, height), dpi=_DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    _head(figure, title, subtitle, groups)
    panels = _panels(figure, rows, height - header)
    longest = max(map(_last_step, groups))
    _draw_large(next(panels), next(panels), groups, episodes_at, longest)
    for number, (label, axes) in enumerate(zip(labels, panels, strict=False)):
        last = number + _COLUMNS >= len(labels)
        _draw_curves(axes, label, [group.terms.get(label) for group in groups], longest)
        _steps_axis(axes, "environment steps" if last else "", few=True)
    for group, axes in zip(staged, panels, strict=True):
        title = shorten(group.label, 60, placeholder=" …") if len(staged) > 1 else ""
        _draw_stages(axes, group, stages, longest, title=title)
    return _saved(figure, form)


def _last_step(group: Group) -> float:
    curves = [curve for curve in (group.success, group.team_return) if curve is not None]
    return max(float(steps[-1]) for curve in curves for steps, _ in curve.runs)


def _saved(figure: Figure, form: str) -> bytes:
    file = io.BytesIO()
    # Without dates, versions and random names a picture depends on nothing but its data.
    nothing = {"Date": None} if form == "svg" else {"Software": None}
    with rc_context({"svg.hashsalt": "taskbuilder"}):
        figure.savefig(file, format=form, facecolor=PAPER, metadata=nothing)
    return file.getvalue()


# Where panels are


def _even(count: int, names: float = 0.0) -> list[tuple[float, float]]:
    """Left and width of so many equal columns, with room for names right of each."""
    room = _WIDTH - _LEFT - _RIGHT - (count - 1) * _GAP
    width = room / count
    return [(_LEFT + number * (width + _GAP), width - names) for number in range(count)]


def _small_rows(count: int) -> Iterator[_Row]:
    for first in range(0, count, _COLUMNS):
        heading = "" if first else "reward terms, summed over a training episode"
        yield _Row(1.25, 0.62 if first else 1.25, _even(_COLUMNS)[: count - first], heading)


def _stage_rows(count: int, stages: Sequence[str]) -> Iterator[_Row]:
    room = max([_NAMES, *(_MARGIN + _width(_in_letters(name)) for name in stages)])
    for first in range(0, count, 2):
        places = _even(min(count, 2), room)[: count - first]
        heading = "" if first else "furthest stage in evaluations"
        yield _Row(1.7, 0.8 if first else 1.0 + 0.25 * (count > 1), places, heading)


def _in_letters(name: str) -> str:
    """A name of a stage that is not too long to stand beside a panel."""
    return name if len(name) <= _NAME_LETTERS else f"{name[: _NAME_LETTERS - 1]}…"


def _width(name: str) -> float:
    """Inches that the name of a stage takes."""
    return float(TextPath((0.0, 0.0), name, size=_NAME_SIZE).get_extents().width) / 72.0


def _panels(figure: Figure, rows: Sequence[_Row], top: float) -> Iterator[Axes]:
    """Make panels one after the other, from a height downward."""
    total = figure.get_figheight()
    for row in rows:
        heading = top - row.above + 0.22 + 0.25 * (len(row.places) > 1)
        figure.text(_LEFT / _WIDTH, heading / total, row.heading, **_BOLD)
        top -= row.above + row.height
        for left, width in row.places:
            place = (left / _WIDTH, top / total, width / _WIDTH, row.height / total)
            yield figure.add_axes(place, facecolor=PAPER)


def _head(figure: Figure, title: str, subtitle: Sequence[str], groups: Sequence[Group]) -> None:
    """Title, subtitle, and the colours of the groups where there are several."""
    height = figure.get_figheight()
    at = 1.7 * _LINE

    def write(text: str, left: float = 0.3, **style: Any) -> None:
        figure.text(left / _WIDTH, 1.0 - at / height, text, va="center", **style)

    write(title, color=INK, fontsize=16, fontweight="bold")
    at += 0.35 * _LINE
    for line in subtitle:
        at += _LINE
        write(line, color=GRAY, fontsize=9.5)
    at += 0.2 * _LINE
    for number, group in enumerate(groups if len(groups) > 1 else ()):
        at += _LINE
        ends, y = (0.3 / _WIDTH, 0.62 / _WIDTH), 1.0 - at / height
        figure.add_artist(Line2D(ends, (y, y), color=_color(number), linewidth=2.6))
        count = f"{group.count} run{'s' * (group.count > 1)}"
        write(f"{group.label}  ({count})", left=0.72, color=INK, fontsize=9.5)


# What is in them


def _draw_large(
    success: Axes,
    paid: Axes,
    groups: Sequence[Group],
    episodes_at: Callable[[Numbers], Numbers],
    longest: float,
) -> None:
    ends = [group.at_end for group in groups]
    title = "success in evaluations" + " (dashed: at the last step)" * any(ends)
    _draw_curves(success, title, [group.success for group in groups], longest)
    _draw_lines(success, ends, "--")
    success.set_ylim(0.0, 1.0)
    success.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    curves = [group.team_return for group in groups]
    _draw_curves(paid, "team return of training episodes", curves, longest)
    for axes in (success, paid):
        axes.set_title(axes.get_title(loc="left"), loc="left", pad=32, **_BOLD)
        _steps_axis(axes, "environment steps")
        _episodes_axis(axes, episodes_at, longest)


def _draw_curves(axes: Axes, title: str, curves: Sequence[Curve | None], longest: float) -> None:
    """A panel with its title, and the curves of all groups."""
    _plain(axes, title)
    _draw_lines(axes, curves, "-")
    axes.set_xlim(0.0, longest)
    if axes.dataLim.height == 0.0:  # what never changes is not to be looked at through a lens
        axes.set_ylim(axes.dataLim.y0 - 1.0, axes.dataLim.y0 + 1.0)


def _draw_lines(axes: Axes, curves: Sequence[Curve | None], style: str) -> None:
    """A line for each run, faint where there are several, and in bold what they have in common."""
    for number, curve in enumerate(curves):
        color = _color(number)
        if curve is None:
            continue
        alone = len(curve.runs) == 1
        for steps, values in curve.runs:
            width, strength = (2.0, 1.0) if alone else (0.9, 0.38)
            marker = "o" if len(steps) == 1 else None
            axes.plot(
                *(steps, values),
                color=color,
                linestyle=style,
                linewidth=width,
                alpha=strength,
                marker=marker,
                markersize=4,
                clip_on=False,
                zorder=2.5,
            )
        if curve.middle is not None:
            steps, middle, low, high = curve.middle
            if style == "-":  # bands on top of each other could not be told apart
                axes.fill_between(steps, low, high, color=color, alpha=0.16, linewidth=0)
            axes.plot(steps, middle, style, color=color, linewidth=2.2, clip_on=False, zorder=3)


def _draw_stages(
    axes: Axes, group: Group, stages: Sequence[str], longest: float, *, title: str
) -> None:
    """Areas on top of each other, the last stage at the bottom."""
    _plain(axes, title)
    axes.set_xlim(0.0, longest)
    axes.set_ylim(0.0, 1.0)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    _steps_axis(axes, "environment steps")
    axes.set_axisbelow(False)
    if group.stages is None:
        return
    steps, shares = group.stages
    count = len(shares) - 1
    colors = stage_colors(count)
    names = ["none", *stages[:count]]
    names += [f"stage {number}" for number in range(len(names), count + 1)]
    _name_stages(axes, names, colors)
    if len(steps) == 1:  # a single evaluation is a column, not an area
        steps, shares = np.array([0.0, steps[0]]), np.repeat(shares, 2, axis=1)
    if len(steps):
        axes.stackplot(steps, shares[::-1], colors=colors[::-1], linewidth=0)


def _name_stages(axes: Axes, names: Sequence[str], colors: Sequence[str]) -> None:
    """Squares and names to the right, in the order of the areas."""
    inch = 1.0 / (axes.get_position().width * _WIDTH)
    apart = min(0.15, 0.9 / max(len(names) - 1, 1))
    for number, (name, color) in enumerate(zip(names, colors, strict=True)):
        height = 0.95 - apart * number
        square = Line2D(
            (1.0 + 0.1 * inch, 1.0 + 0.22 * inch),
            (height, height),
            transform=axes.transAxes,
            clip_on=False,
            color=color,
            linewidth=8,
            solid_capstyle="butt",
        )
        axes.add_line(square)
        place = (1.0 + 0.3 * inch, height)
        axes.text(
            *place,
            _in_letters(name),
            transform=axes.transAxes,
            color=INK,
            fontsize=_NAME_SIZE,
            va="center",
        )


def _plain(axes: Axes, title: str) -> None:
    """The style of every panel: no box, a light grid, a title at the left."""
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)
    axes.spines["bottom"].set_color(GRAY)
    axes.tick_params(colors=GRAY, labelsize=8.5, length=3)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", color=_GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.set_title(title, loc="left", color=INK, fontsize=9.5, pad=5)


def _steps_axis(axes: Axes, label: str, *, few: bool = False) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(4 if few else 6, steps=_ROUND))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: in_short(value)))
    axes.set_xlabel(label, color=GRAY, fontsize=8.5)


def _episodes_axis(axes: Axes, at: Callable[[Numbers], Numbers], longest: float) -> None:
    """An axis above, with ticks at round numbers of episodes wherever those were reached."""
    steps = np.linspace(0.0, longest, 1001)
    ended = at(steps)
    proposed = MaxNLocator(6, steps=_ROUND).tick_values(0.0, ended[-1])
    ticks = [number for number in proposed if 0.0 <= number <= ended[-1]]
    upper = axes.twiny()
    for spine in upper.spines.values():
        spine.set_visible(False)
    upper.set_xlim(0.0, longest)
    upper.set_xticks(np.interp(ticks, ended, steps), [in_short(number) for number in ticks])
    upper.tick_params(colors=GRAY, labelsize=8.5, length=3)
    upper.set_xlabel("episodes", color=GRAY, fontsize=8.5, labelpad=4)


def in_short(number: float) -> str:
    """A round number in few characters: ``50k``, ``1.5M``."""
    for unit, sign in ((1e6, "M"), (1e3, "k")):
        if abs(number) >= unit:
            return f"{number / unit:g}{sign}"
    return f"{number:g}"


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]


def stage_colors(count: int) -> list[str]:
    """Colours of no stage, of the stages on the way from pale to deep, and of the last in green."""
    pale, deep = np.array(to_rgb(_PALE)), np.array(to_rgb(_DEEP))
    way = np.linspace(0.0, 1.0, max(count - 1, 0))
    between = [to_hex(tuple((pale + (deep - pale) * share).tolist())) for share in way]
    return [_NONE, *between, GREEN][: count + 1]
