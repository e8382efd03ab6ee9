"""Training runs side by side: those alike as one, with what they have in common and how sure it is.

Runs are alike if they differ in nothing but their seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import UsageError, display_path
from taskbuilder.learn.logs import RunLog, Table
from taskbuilder.learn.statistics import bootstrap_band, iqm

Numbers = NDArray[np.float64]
Line = tuple[Numbers, Numbers]
"""Environment steps, and a quantity at each."""

POINTS = 200
"""Of a smoothed line."""

WINDOW = 1.0 / 40.0
"""Of the longest run: over so many steps episodes are averaged."""


@dataclass(frozen=True)
class Aggregate:
    """What runs have in common, as far as all of them have come.

    Attributes:
        steps: (n,) environment steps.
        iqm: (n,) interquartile mean over the runs.
        low, high: (n,) its 95 % bootstrap band.
    """

    steps: Numbers
    iqm: Numbers
    low: Numbers
    high: Numbers


@dataclass(frozen=True)
class RunGroup:
    """Runs that differ in nothing but their seeds.

    Attributes:
        traits: What they have in common, by name, in words; "" where there is nothing to say.
        runs: At least one.
    """

    traits: Mapping[str, str]
    runs: tuple[RunLog, ...]

    def success(self) -> list[Line]:
        """Success rate of each run's evaluations."""
        return [(r.evaluations["step"], r.evaluations["success_rate"]) for r in self.runs]

    def smoothed(self, column: str, longest: float) -> list[Line]:
        """A quantity of each run's training episodes, averaged over a moving window.

        Args:
            column: Of the table of episodes; runs that lack it are left out.
            longest: Steps of the longest run of all that are compared.
        """
        tables = [run.episodes for run in self.runs if column in run.episodes]
        lines = [smooth(table["step"], table[column], longest) for table in tables]
        return [line for line in lines if len(line[0])]

    def stages(self) -> Line:
        """Mean share of an evaluation's episodes by furthest stage: (n,) and (stages + 1, n).

        Of the runs that came so far: they stop at different steps, once they succeed.
        """
        count = max(_stage_count(run.evaluations) for run in self.runs)
        steps = _known_steps(self.success())
        shares = []
        for run in self.runs:
            table = run.evaluations
            nobody = np.zeros(len(table["step"]))
            counts = [table.get(f"stage/{stage}", nobody) for stage in range(count)]
            total = np.maximum(table["episodes"], 1.0)
            known = table["step"]
            shares.append([np.interp(steps, known, n / total, right=np.nan) for n in counts])
        return steps, np.nanmean(shares, axis=0)


def group_runs(runs: Sequence[RunLog]) -> list[RunGroup]:
    """Put runs that are alike together.

    Raises:
        UsageError: They are of different tasks, or one has no evaluations yet.
    """
    first = runs[0]
    for run in runs:
        name = display_path(run.folder)
        if run.plan.task != first.plan.task:
            raise UsageError(
                f"{name} is of {run.plan.task} and {display_path(first.folder)} of "
                f"{first.plan.task}: their returns and stages mean different things; plot the "
                "runs of each task apart"
            )
        if not len(run.evaluations["step"]):
            every = run.plan.evaluate_every
            raise UsageError(f"{name} has no evaluations yet; there is one every {every:,} steps")
    groups: dict[tuple[str, ...], list[RunLog]] = {}
    for run in runs:
        groups.setdefault(tuple(_traits(run).values()), []).append(run)
    return [RunGroup(_traits(group[0]), tuple(group)) for group in groups.values()]


def names_of(groups: Sequence[RunGroup]) -> list[str]:
    """A name for each group: what sets it off from the others, or all where there is one."""
    traits = [group.traits for group in groups]
    telling = [key for key in traits[0] if len({t[key] for t in traits}) > 1]
    if len(traits) == 1:
        telling = [key for key in traits[0] if key not in ("frame", "rotation")]
    names = []
    for own in traits:
        # Words for what is not there are of use only where others have it.
        words = [own[key] or _WITHOUT[key] * (len(traits) > 1) for key in telling]
        names.append(" · ".join(word for word in words if word))
    return names


_WITHOUT = {
    "demos": "no demonstrations",
    "starts": "the task's own starts",
    "observe": "own observations",
    "variation": "plain task",
    "settings": "its own settings",
}


def _traits(run: RunLog) -> dict[str, str]:
    """All that decides how a run goes but its seed, in words."""
    plan = run.plan
    return {
        "algorithm": plan.algorithm,
        "reward": f"{plan.reward} reward",
        "demos": f"{plan.demos} demonstrations" if plan.demos else "",
        "starts": f"{plan.starts:.0%} expert starts" if plan.starts else "",
        "observe": "whole scene" if plan.observe == "scene" else "",
        "frame": f"frame {plan.frame}",
        "rotation": f"rotation {plan.rotation}",
        "variation": f"variation {plan.variation}" if plan.variation else "",
        "settings": ", ".join(f"{key} {value}" for key, value in sorted(plan.settings.items())),
    }


def aggregate(lines: Sequence[Line], rng: np.random.Generator) -> Aggregate | None:
    """What lines have in common, or None for one line, or where they never run side by side.

    Args:
        lines: Of runs that are alike.
        rng: Draws the bootstrap's runs.
    """
    steps = _common_steps(lines) if len(lines) > 1 else np.zeros(0)
    if not len(steps):
        return None
    values = np.stack([np.interp(steps, *line) for line in lines])
    low, high = bootstrap_band([values], rng)
    return Aggregate(steps, iqm(values), low, high)


def _common_steps(lines: Sequence[Line]) -> Numbers:
    """Every step at which one of the lines has a point, as far as all of them reach."""
    known = _known_steps(lines)
    common: Numbers = known[known <= min(steps[-1] for steps, _ in lines)]
    return common


def _known_steps(lines: Sequence[Line]) -> Numbers:
    """Every step at which one of the lines has a point, from where all of them have begun."""
    known = np.unique(np.concatenate([steps for steps, _ in lines]))
    begun: Numbers = known[known >= max(steps[0] for steps, _ in lines)]
    return begun


def smooth(steps: Numbers, values: Numbers, longest: float) -> Line:
    """The mean over a moving window, at even steps.

    Args:
        steps: (n,) at which there is a value, rising.
        values: (n,) each.
        longest: Steps by which points and window are laid out, the same for all runs.
    """
    half = WINDOW * longest / 2.0
    points = np.linspace(0.0, longest, POINTS + 1)
    if len(steps):
        points = points[(points >= steps[0]) & (points <= steps[-1])]
    sums = np.concatenate([[0.0], np.cumsum(values)])
    begin = np.searchsorted(steps, points - half, side="left")
    end = np.searchsorted(steps, points + half, side="right")
    full = end > begin
    means = (sums[end] - sums[begin])[full] / (end - begin)[full]
    return points[full], means


def episodes_at(runs: Sequence[RunLog]) -> Callable[[Numbers], Numbers]:
    """How many training episodes had ended after so many steps: the mean of the runs.

    Beyond its end a run is taken to go on at its own mean pace.
    """

    def count(steps: Numbers) -> Numbers:
        counts = []
        for run in runs:
            known, ended = run.evaluations["step"], run.evaluations["episode"]
            known, ended = np.append(0.0, known), np.append(0.0, ended)
            inside = np.interp(steps, known, ended)
            pace = ended[-1] / max(known[-1], 1.0)
            counts.append(np.where(steps > known[-1], steps * pace, inside))
        mean: Numbers = np.mean(counts, axis=0)
        return mean

    return count


def labels_of(runs: Sequence[RunLog]) -> list[str]:
    """Labels of all reward terms, in order."""
    columns = dict.fromkeys(name for run in runs for name in run.episodes)
    return [name.removeprefix("term/") for name in columns if name.startswith("term/")]


def _stage_count(table: Table) -> int:
    """How many columns there are, from ``stage/0`` on."""
    count = 0
    while f"stage/{count}" in table:
        count += 1
    return count
