"""The tables of a benchmark, as rows of texts; the command prints them, and the page has them."""

from __future__ import annotations

from collections.abc import Sequence

from taskbuilder.benchmark.records import CellRecord
from taskbuilder.benchmark.results import (
    MethodResults,
    TaskResult,
    interval,
    safe_success,
    success_at_end,
)
from taskbuilder.benchmark.statistics import Banded

Rows = list[list[str]]

NONE = "–"

NOTES = {
    "*": "a development task, on which methods may be tuned",
    "!": "a training run took more CPU time than the track allows",
}
"""Marks behind the names of tasks and behind CPU times."""


def task_table(results: MethodResults) -> Rows:
    """A row for each task of a method, below a head."""
    seeds = results.about.seeds
    head = ["task", "median seed, %", f"seed {' '.join(map(str, seeds))}", "safe", "CPU min"]
    return [head, *(_row(each) for each in results.tasks)]


def _row(result: TaskResult) -> list[str]:
    name = f"{result.task}{' *' if result.development else ''}"
    median = result.median
    if result.impossible or median is None:
        return [name, "not possible" if result.impossible else NONE, NONE, NONE, NONE]
    each = " ".join(map(_seed, result.cells))
    if median.status == "failed":
        return [name, "failed", each, _percent(0.0), NONE]
    minutes = f"{median.train_cpu_s / 60.0:.1f}" if median.train_cpu_s else NONE
    minutes += " !" if result.over_budget else ""
    return [name, with_interval(median), each, _percent(safe_success(median)), minutes]


def _seed(cell: CellRecord | None) -> str:
    if cell is None:
        return NONE
    return "x" if cell.status != "done" else f"{100.0 * success_at_end(cell):.0f}"


def with_interval(cell: CellRecord) -> str:
    """Success at the last step with its interval, in percent."""
    low, high = interval(cell)
    return f"{_percent(success_at_end(cell))} ({_percent(low)}–{_percent(high)})"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f}"


def suite_table(several: Sequence[MethodResults]) -> Rows:
    """A row for each method, below a head: its figures over the suite."""
    head = ["method", "IQM, %", "without development tasks", "tasks", "tuning runs"]
    return [head, *(_suite_row(each) for each in several)]


def _suite_row(results: MethodResults) -> list[str]:
    counted = len(results.scores())
    return [
        results.name,
        figure(results.interquartile_mean()),
        figure(results.interquartile_mean(without_development=True)),
        f"{counted} of {len(results.tasks)}",
        results.tuning_runs,
    ]


def figure(found: Banded | None) -> str:
    """A figure of the suite with its band, in percent."""
    if found is None:
        return NONE
    value = _percent(float(found.value))
    if found.low is None or found.high is None:
        return value
    return f"{value} ({_percent(float(found.low))}–{_percent(float(found.high))})"


def beside_table(several: Sequence[MethodResults]) -> Rows:
    """A row for each task, below a head, with the median seed of each method."""
    rows = [["task", *(each.name for each in several)]]
    for own in zip(*(each.tasks for each in several), strict=True):
        mark = " *" if own[0].development else ""
        rows.append([f"{own[0].task}{mark}", *(_row(each)[1] for each in own)])
    return rows


def marks(several: Sequence[MethodResults]) -> Rows:
    """The marks of these results, and what they mean."""
    tasks = [task for results in several for task in results.tasks]
    used = {"*": any(t.development for t in tasks), "!": any(t.over_budget for t in tasks)}
    return [[mark, says] for mark, says in NOTES.items() if used[mark]]


def baseline_table(results: MethodResults) -> Rows:
    """What the expert and random actions achieve at each task, below a head."""
    rows = [["task", "expert: at the last step", "return", "random: at the last step", "return"]]
    for each in results.tasks:
        row = [each.task]
        for name in ("expert", "random"):
            found = each.shared.baselines.get(name) if each.shared else None
            of = f"{found.successes_at_end} of {found.episodes}" if found else NONE
            row += [of, f"{found.mean_return:.2f}" if found else NONE]
        rows.append(row)
    return rows


def cost_table(results: MethodResults) -> Rows:
    """The CPU minutes of each task, summed over its seeds, below a head."""
    rows = [["task", "demonstrations", "by", "collecting", "training", "evaluation"]]
    for each in results.tasks:
        shared, cells = each.shared, each.there
        rows.append(
            [
                each.task,
                str(shared.demonstrations) if shared else NONE,
                (shared.demonstrator if shared else "") or NONE,
                f"{shared.cpu_s / 60.0:.1f}" if shared else NONE,
                f"{sum(c.train_cpu_s for c in cells) / 60.0:.1f}",
                f"{sum(c.evaluate_cpu_s for c in cells) / 60.0:.1f}",
            ]
        )
    return rows
