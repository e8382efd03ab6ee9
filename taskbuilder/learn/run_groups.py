"""Comparing training runs: those that differ only in seed and pace form a group.

A group is plotted as the interquartile mean of its runs, with a bootstrap band.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import UsageError, display_path
from taskbuilder.evaluation.statistics import bootstrap_band, iqm
from taskbuilder.learn.logs import RunLog, Table
from taskbuilder.learn.plan import Plan

Numbers = NDArray[np.float64]
RunCurve = tuple[Numbers, Numbers]
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
    """Runs that differ only in their seeds, or in what paces them.

    Attributes:
        traits: What they have in common, by field of the plan; see `Plan.experiment`.
        runs: At least one run.
    """

    traits: Mapping[str, Any]
    runs: tuple[RunLog, ...]

    def success(self) -> list[RunCurve]:
        """Success rate of each run's evaluations."""
        return [(r.evaluations["step"], r.evaluations["success_rate"]) for r in self.runs]

    def success_at_end(self) -> list[RunCurve]:
        """Rate of success at the last control step, of the runs that record it."""
        tables = [run.evaluations for run in self.runs if AT_END in run.evaluations]
        return [(table["step"], table[AT_END]) for table in tables]

    def smoothed(self, column: str, longest: float) -> list[RunCurve]:
        """The moving average of a quantity over each run's training episodes.

        Args:
            column: Column of the table of episodes; runs without it are left out.
            longest: Steps of the longest run in the comparison.
        """
        tables = [run.episodes for run in self.runs if column in run.episodes]
        lines = [smooth(table["step"], table[column], longest) for table in tables]
        return [line for line in lines if len(line[0])]

    def stages(self) -> RunCurve:
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
            recorded = table["step"]
            shares.append([np.interp(steps, recorded, n / total, right=np.nan) for n in counts])
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
    groups: dict[str, list[RunLog]] = {}
    for run in runs:
        groups.setdefault(repr(sorted(run.plan.experiment.items())), []).append(run)
    return [RunGroup(group[0].plan.experiment, tuple(group)) for group in groups.values()]


def names_of(groups: Sequence[RunGroup]) -> list[str]:
    """A name for each group: the fields that differ between groups, or what a single one chose."""
    traits = [group.traits for group in groups]
    fields = [name for name in Plan("").values if any(name in own for own in traits)]
    if len(traits) == 1:
        usual = Plan("").values
        telling = [name for name in fields if traits[0][name] != usual[name] or name in _ALWAYS]
        telling = [name for name in telling if name not in _FORMATS]
    else:
        values = {name: [own[name] for own in traits if name in own] for name in fields}
        telling = [name for name, each in values.items() if any(v != each[0] for v in each)]
    words = [[_word(name, own[name]) for name in telling if name in own] for own in traits]
    return [" · ".join(filter(None, each)) for each in words]


_ALWAYS = ("algorithm", "reward")
"""Fields that name a single group even where they are as usual."""

_FORMATS = ("task", "frame", "rotation", "distances")
"""Fields that do not name a single group: pictures have the task's name, and the others are the
form in which robots observe."""

_WORDS: Mapping[str, Callable[[Any], str]] = {
    "algorithm": str,
    "reward": lambda name: f"{name} reward",
    "demos": lambda demos: (
        f"demonstrations of {display_path(Path(demos))}"
        if isinstance(demos, str)
        else f"{demos or 'no'} demonstrations"
    ),
    "starts": lambda share: f"{share:.0%} expert starts" if share else "the task's own starts",
    "data": lambda folder: f"data {display_path(Path(folder))}" if folder else "no data set",
    "observe": lambda observe: "whole scene" if observe == "scene" else "own observations",
    "distances": lambda unit: f"distances in {unit}",
    "grasp": lambda rule: f"grasp {'as in the task file' if rule == 'task' else rule}",
    "variation": lambda number: f"variation {number}" if number else "plain task",
    "settings": lambda own: (
        ", ".join(f"{key} {value}" for key, value in sorted(own.items())) or "its own settings"
    ),
}
"""How the value of a field is said where its name and its value do not say it well."""


def _word(name: str, value: Any) -> str:
    if name in _WORDS:
        return _WORDS[name](value)
    name = name.replace("_", " ")
    if value is None or value == ():
        return f"{name} as in the task file"
    if isinstance(value, bool) or not value:
        return name if value else f"no {name}"
    if isinstance(value, tuple):
        return f"{name} {', '.join(map(_part, value))}"
    return f"{name} {value}"


def _part(value: Any) -> str:
    """An item of a tuple, or a robot and its model."""
    return "=".join(value) if isinstance(value, tuple) else str(value)


def aggregate(lines: Sequence[RunCurve], rng: np.random.Generator) -> Aggregate | None:
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


def _common_steps(lines: Sequence[RunCurve]) -> Numbers:
    """All steps with a point of some line, up to the end of the shortest line."""
    points = _known_steps(lines)
    common: Numbers = points[points <= min(steps[-1] for steps, _ in lines)]
    return common


def _known_steps(lines: Sequence[RunCurve]) -> Numbers:
    """All steps with a point of some line, from the step at which all lines have begun."""
    points = np.unique(np.concatenate([steps for steps, _ in lines]))
    begun: Numbers = points[points >= max(steps[0] for steps, _ in lines)]
    return begun


def smooth(steps: Numbers, values: Numbers, longest: float) -> RunCurve:
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
            logged, ended = run.evaluations["step"], run.evaluations["episode"]
            logged, ended = np.append(0.0, logged), np.append(0.0, ended)
            inside = np.interp(steps, logged, ended)
            pace = ended[-1] / max(logged[-1], 1.0)
            counts.append(np.where(steps > logged[-1], steps * pace, inside))
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
