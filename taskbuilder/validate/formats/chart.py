"""The chart of what ways of playing a task earn: a line for each way, a dot for each episode."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from taskbuilder.validate.formats.markup import Content, Html, element
from taskbuilder.validate.formats.words import number
from taskbuilder.validate.report import Probe

EXPERT = "expert"
MOST_DOTS = 60
TICKS = 4
MARGIN = 0.03
"""Share of the axis that stays free at either end."""


@dataclass(frozen=True)
class Way:
    """A line of the chart.

    Attributes:
        name: The way of playing.
        returns: What it earned, less what was not finite.
        mean: Of those; None where there are none.
        kind: ``expert``, ``rival`` for what earns as much as the expert, or ``other``.
        solved: In how many episodes it succeeded.
        episodes: How many were played.
    """

    name: str
    returns: tuple[float, ...]
    mean: float | None
    kind: str
    solved: int
    episodes: int


@dataclass(frozen=True)
class Axis:
    """From returns to shares of the chart's width."""

    low: float
    high: float

    def share(self, value: float) -> str:
        """Where a return stands: ``12.3%``."""
        return f"{100 * (value - self.low) / (self.high - self.low):.2f}%"

    def tell(self, value: float) -> str:
        """A return in figures, as precise as the chart is long: ``−12.3``."""
        length = self.high - self.low
        decimals = next((d for least, d in ((1000, 0), (10, 1), (1, 2)) if length >= least), 3)
        rounded = round(value, decimals) + 0.0  # no minus before a zero
        return f"{rounded:,.{decimals}f}".replace("-", "\N{MINUS SIGN}")

    def ticks(self) -> list[float]:
        """Round returns, some `TICKS` of them, that lie on the axis."""
        rough = (self.high - self.low) / TICKS
        power = 10.0 ** math.floor(math.log10(rough))
        step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough)
        first, last = math.ceil(self.low / step), math.floor(self.high / step)
        return [round(i * step, 12) for i in range(first, last + 1)]


def chart(title: str, probes: Sequence[Probe], *, discounted: bool) -> Html:
    """A figure of what each way earned, the best on top.

    Args:
        title: What is shown.
        probes: The ways; that named ``expert`` is what the others are held against.
        discounted: Whether to show discounted returns.
    """
    listed = ways(probes, discounted=discounted)
    axis = _axis(listed)
    expert = next((way.mean for way in listed if way.kind == EXPERT), None)
    lines = [_line(way, axis, expert) for way in listed]
    scale = element("li", element("span"), _scale(axis), element("span"), class_="scale")
    return element(
        "figure",
        element("figcaption", title),
        element("ol", lines, scale, class_="ways"),
        class_="chart",
    )


def ways(probes: Sequence[Probe], *, discounted: bool) -> list[Way]:
    """The lines of the chart, by mean return from the greatest to the least."""
    measured = [
        (probe, _finite(probe.discounted if discounted else probe.returns)) for probe in probes
    ]
    means = {probe.name: statistics.fmean(got) for probe, got in measured if got}
    best = means.get(EXPERT, math.inf)
    listed = [
        Way(
            probe.name,
            got,
            means.get(probe.name),
            EXPERT
            if probe.name == EXPERT
            else "rival"
            if means.get(probe.name, -math.inf) >= best
            else "other",
            probe.successes,
            len(probe.returns),
        )
        for probe, got in measured
    ]
    return sorted(listed, key=lambda way: -math.inf if way.mean is None else way.mean, reverse=True)


def _finite(returns: Sequence[float]) -> tuple[float, ...]:
    return tuple(value for value in returns if math.isfinite(value))


def _axis(listed: Sequence[Way]) -> Axis:
    values = [0.0, *(value for way in listed for value in way.returns)]
    low, high = min(values), max(values)
    if high - low < 1e-9:
        low, high = low - 1.0, high + 1.0
    free = MARGIN * (high - low)
    return Axis(low - free, high + free)


def _line(way: Way, axis: Axis, expert: float | None) -> Html:
    solved = f"solved {way.solved} of {way.episodes}" if way.solved else None
    mean = "not finite" if way.mean is None else axis.tell(way.mean)
    return element(
        "li",
        element("span", way.name, element("small", solved) if solved else None, class_="name"),
        _plot(way, axis, expert),
        element("span", mean, class_="mean"),
        class_=way.kind,
    )


def _plot(way: Way, axis: Axis, expert: float | None) -> Html:
    marks = [_upright("tick", axis, tick) for tick in axis.ticks()]
    if axis.low < 0.0 < axis.high:
        marks.append(_upright("zero", axis, 0.0))
    if expert is not None:
        marks.append(_upright("goal", axis, expert))
    step = max(1, math.ceil(len(way.returns) / MOST_DOTS))
    dots = [
        element("circle", cx=axis.share(value), cy="50%", r="3", class_="dot")
        for value in way.returns[::step]
    ]
    if way.returns:
        ends = {"x1": axis.share(min(way.returns)), "x2": axis.share(max(way.returns))}
        marks.append(element("line", class_="spread", y1="50%", y2="50%", **ends))
    if way.mean is not None:
        at = axis.share(way.mean)
        dots.append(element("line", x1=at, x2=at, y1="20%", y2="80%", class_="mark"))
    return _drawn([marks, dots])


def _upright(kind: str, axis: Axis, value: float) -> Html:
    at = axis.share(value)
    return element("line", x1=at, x2=at, y1="0", y2="100%", class_=kind)


def _scale(axis: Axis) -> Html:
    labels = [element("text", number(tick), x=axis.share(tick), y="70%") for tick in axis.ticks()]
    return _drawn(labels)


def _drawn(content: Content) -> Html:
    return element("span", element("svg", content, aria_hidden="true"), class_="plot")
