"""The chart of what the expert and the baselines earn: a line for each, a dot for each episode."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from taskbuilder.expert.baselines import EXPERT, Baseline
from taskbuilder.validate.report import Probe

MOST_DOTS = 60
TICKS = 4
MARGIN = 0.03
"""Share of the axis that stays free at either end."""


@dataclass(frozen=True)
class ChartLine:
    """A line of the chart.

    Attributes:
        baseline: Who played.
        returns: What it earned, less what was not finite.
        mean: Of those; None where there are none.
        role: ``expert``, ``rival`` for what earns as much as the expert, or ``other``.
        solved: In how many episodes it succeeded.
        episodes: How many were played.
        decided_after: Number of seeds after which the comparison with the expert was decided, or
            None.
    """

    baseline: Baseline
    returns: tuple[float, ...]
    mean: float | None
    role: str
    solved: int
    episodes: int
    decided_after: int | None = None

    @property
    def dots(self) -> tuple[float, ...]:
        """Returns that are shown, some `MOST_DOTS` at most."""
        return self.returns[:: max(1, math.ceil(len(self.returns) / MOST_DOTS))]


@dataclass(frozen=True)
class Axis:
    """From returns to shares of the chart's width."""

    low: float
    high: float

    def percent(self, value: float) -> str:
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


@dataclass(frozen=True)
class Chart:
    """What each baseline earned, the best on top.

    Attributes:
        title: What is shown.
        lines: The baselines and the expert.
        axis: Of all lines.
        expert: What the expert earns in the mean, or None.
    """

    title: str
    lines: Sequence[ChartLine]
    axis: Axis
    expert: float | None


def charts(probes: Sequence[Probe]) -> list[Chart]:
    """Undiscounted and discounted returns; none where nothing was played.

    Args:
        probes: The baselines; the expert's is what the others are held against.
    """
    if not probes:
        return []
    titles = {"Undiscounted": False, "Discounted by 0.95 a step": True}
    return [_chart(title, lines(probes, discounted=which)) for title, which in titles.items()]


def _chart(title: str, listed: Sequence[ChartLine]) -> Chart:
    expert = next((line.mean for line in listed if line.baseline == EXPERT), None)
    return Chart(title, listed, _axis(listed), expert)


def lines(probes: Sequence[Probe], *, discounted: bool) -> list[ChartLine]:
    """The lines of the chart, by mean return from the greatest to the least."""
    measured = [
        (probe, _finite(probe.discounted if discounted else probe.returns)) for probe in probes
    ]
    means = {probe.baseline: statistics.fmean(got) for probe, got in measured if got}
    listed = [
        ChartLine(
            probe.baseline,
            got,
            means.get(probe.baseline),
            _role(probe.baseline, means),
            probe.successes,
            len(probe.returns),
            probe.decided_after,
        )
        for probe, got in measured
    ]
    return sorted(
        listed, key=lambda line: -math.inf if line.mean is None else line.mean, reverse=True
    )


def _role(baseline: Baseline, means: Mapping[Baseline, float]) -> str:
    if baseline == EXPERT:
        return "expert"
    return "rival" if means.get(baseline, -math.inf) >= means.get(EXPERT, math.inf) else "other"


def _finite(returns: Sequence[float]) -> tuple[float, ...]:
    return tuple(value for value in returns if math.isfinite(value))


def _axis(listed: Sequence[ChartLine]) -> Axis:
    values = [0.0, *(value for line in listed for value in line.returns)]
    low, high = min(values), max(values)
    if high - low < 1e-9:
        low, high = low - 1.0, high + 1.0
    free = MARGIN * (high - low)
    return Axis(low - free, high + free)
