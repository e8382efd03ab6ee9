"""Comparing training runs: runs that differ only in their seeds form a group.

A group is plotted as the interquartile mean of its runs, with a bootstrap band.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import UsageError, display_path
from taskbuilder.evaluation.statistics import bootstrap_band, iqm
from taskbuilder.learn.logs import RunLog, Table

Numbers = NDArray[np.float64]
Line = tuple[Numbers, Numbers]
"""Environment steps, and the value of a quantity at each."""

AT_END = "success_at_end_rate"
"""Column of evaluations that the first runs do not have."""

POINTS = 200
"""Points of a smoothed line."""

WINDOW = 1.0 / 40.0
"""Width of the moving average, as a fraction of the longest run."""


@dataclass(frozen=True)
class Aggregate:
    """The mean and band of several runs, up to the last step that all have reached.

    Attributes:
        steps: (n,) environment steps.
        iqm: (n,) interquartile mean over the runs.
        low, high: (n,) 95 % bootstrap band of the mean.
    """

    steps: Numbers
    iqm: Numbers
    low: Numbers
    high: Numbers


@dataclass(frozen=True)
class RunGroup:
    """Runs that differ only in their seeds.

    Attributes:
        traits: Their common options, by name, in words; "" for an option at its default.
        runs: At least one run.
    """

    traits: Mapping[str, str]
    runs: tuple[RunLog, ...]

    def success(self) -> list[Line]:
        """Success rate of each run's evaluations."""
        return [(r.evaluations["step"], r.evaluations["success_rate"]) for r in self.runs]

    def success_at_end(self) -> list[Line]:
        """Rate of success at the last control step, of the runs that record it."""
        tables = [run.evaluations for run in self.runs if AT_END in run.evaluations]
        return [(table["step"], table[AT_END]) for table in tables]

    def smoothed(self, column: str, longest: float) -> list[Line]:
        """The moving average of a quantity over each run's training episodes.

        Args:
            column: Column of the table of episodes; runs without it are left out.
            longest: Steps of the longest run in the comparison.
        """
        tables = [run.episodes for run in self.runs if column in run.episodes]
        lines = [smooth(table["step"], table[column], longest) for table in tables]
        return [line for line in lines if len(line[0])]

    def stages(self) -> Line:
        """Mean fraction of evaluation episodes by last stage: (n,) and (stages + 1, n).

        The mean at a step is over the runs that reached it, since runs stop at different steps.
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
    """Group runs that differ only in their seeds.

    Raises:
        UsageError: The runs are of different tasks, or one has no evaluations yet.
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
    """A name for each group: the options that differ between groups, or all for a single one."""
    traits = [group.traits for group in groups]
    telling = [key for key in traits[0] if len({t[key] for t in traits}) > 1]
    if len(traits) == 1:
        telling = [key for key in traits[0] if key not in ("frame", "rotation", "distances")]
    names = []
    for own in traits:
        # Words for a missing option are shown only if other groups have the option.
        words = [own[key] or _WITHOUT[key] * (len(traits) > 1) for key in telling]
        names.append(" · ".join(word for word in words if word))
    return names


_WITHOUT = {
    "demos": "no demonstrations",
    "starts": "the task's own starts",
    "observe": "own observations",
    "grasp": "grasp as in the task file",
    "variation": "plain task",
    "settings": "its own settings",
}


def _traits(run: RunLog) -> dict[str, str]:
    """All options of a run except its seed, in words."""
    plan = run.plan
    return {
        "algorithm": plan.algorithm,
        "reward": f"{plan.reward} reward",
        "demos": f"{plan.demos} demonstrations" if plan.demos else "",
        "starts": f"{plan.starts:.0%} expert starts" if plan.starts else "",
        "observe": "whole scene" if plan.observe == "scene" else "",
        "frame": f"frame {plan.frame}",
        "rotation": f"rotation {plan.rotation}",
        "distances": f"distances in {plan.distances}",
        "grasp": f"grasp {plan.grasp}" if plan.grasp != "task" else "",
        "variation": f"variation {plan.variation}" if plan.variation else "",
        "settings": ", ".join(f"{key} {value}" for key, value in sorted(plan.settings.items())),
    }


def aggregate(lines: Sequence[Line], rng: np.random.Generator) -> Aggregate | None:
    """Aggregate lines; None for a single line, or if the lines do not overlap.

    Args:
        lines: Lines of runs in one group.
        rng: Generator of the bootstrap.
    """
    steps = _common_steps(lines) if len(lines) > 1 else np.zeros(0)
    if not len(steps):
        return None
    values = np.stack([np.interp(steps, *line) for line in lines])
    low, high = bootstrap_band([values], rng)
    return Aggregate(steps, iqm(values), low, high)


def _common_steps(lines: Sequence[Line]) -> Numbers:
    """All steps with a point of some line, up to the end of the shortest line."""
    known = _known_steps(lines)
    common: Numbers = known[known <= min(steps[-1] for steps, _ in lines)]
    return common


def _known_steps(lines: Sequence[Line]) -> Numbers:
    """All steps with a point of some line, from the step at which all lines have begun."""
    known = np.unique(np.concatenate([steps for steps, _ in lines]))
    begun: Numbers = known[known >= max(steps[0] for steps, _ in lines)]
    return begun


def smooth(steps: Numbers, values: Numbers, longest: float) -> Line:
    """The moving average at evenly spaced steps.

    Args:
        steps: (n,) increasing steps.
        values: (n,) values at these steps.
        longest: Steps of the longest run, which set the spacing and the window for all runs.
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
    """The mean number of training episodes that had ended at given steps.

    Beyond its end, a run is extrapolated at its own mean rate.
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
    """The number of columns ``stage/0``, ``stage/1``, ..."""
    count = 0
    while f"stage/{count}" in table:
        count += 1
    return count
