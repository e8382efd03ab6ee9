"""What methods achieve on suites of tasks, from the results of the benchmark."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from generators.leaderboard import BY_ROBOTS
from generators.results import RESULTS
from generators.tasks import title
from taskbuilder import load_suite
from taskbuilder.reference.markdown import table
from taskbuilder.schema.catalogue import Catalogue

LEARNED, MOSTLY = 0.95, 0.8
"""Success at the last step from which a task counts as learned, and as mostly learned."""


def over(_: str) -> str:
    """How many tasks of each suite are learned, by every method that has results."""
    rows = [_counts(found, method) for _, found, method in _submitted()]
    measured = {row[0] for row in rows}
    for suite in BY_ROBOTS:
        if suite not in measured:
            count = len(load_suite(suite, catalogue=Catalogue()).tasks)
            rows.append([suite, "not measured yet", str(count), "0", "–", "–", "–"])
    head = ["suite", "method", "tasks", "measured", "95 % or more", "80 % or more", "below 80 %"]
    return table(head, rows)


def tasks(_: str) -> str:
    """Every task of every suite, the best first, with what was measured."""
    parts = []
    for folder, found, method in _submitted():
        seeds = ", ".join(map(str, method["seeds"]))
        name = found["suite"]["name"]
        about = f"`{method['name']}`, training seed {seeds}. [All numbers](../../{_link(folder)})."
        rows = [_row(task) for task in sorted(_measured(method), key=_order)]
        missing = [_title(task) for task in method["tasks"] if not task["cells"]]
        head = ["task", "demonstrations by", "success at the last step", "safe success"]
        head += ["random actions", "CPU minutes of training"]
        parts += [f"### {name.capitalize()}", about, table(head, rows)]
        if missing:
            parts.append(f"Not measured yet: {', '.join(missing)}.")
    return "\n\n".join(parts)


def _submitted() -> Iterator[tuple[Path, Mapping[str, Any], Mapping[str, Any]]]:
    """Folder, results and method of everything that was measured by the rules of a track."""
    for file in sorted((RESULTS / "suites").glob("*/results.json"), key=_size):
        found = json.loads(file.read_text(encoding="utf-8"))
        if not found["comparable"]:
            raise ValueError(f"{file.parent.name} was not measured by the rules of its track")
        for method in found["methods"]:
            yield file.parent, found, method


def _size(file: Path) -> tuple[int, str]:
    """The suites in the order of their numbers of robots, and others behind them."""
    suite = file.parent.name.partition("-")[0]
    return (BY_ROBOTS.index(suite) if suite in BY_ROBOTS else len(BY_ROBOTS), file.parent.name)


def _link(folder: Path) -> str:
    return f"benchmarks/results/suites/{folder.name}/results.csv"


def _measured(method: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [task for task in method["tasks"] if task["cells"]]


def _counts(found: Mapping[str, Any], method: Mapping[str, Any]) -> list[str]:
    rates = [task["success_at_end_rate"] for task in _measured(method)]
    learned = sum(rate >= LEARNED for rate in rates)
    mostly = sum(rate >= MOSTLY for rate in rates)
    counts = (len(method["tasks"]), len(rates), learned, mostly, len(rates) - mostly)
    return [found["suite"]["name"], f"`{method['name']}`", *map(str, counts)]


def _order(task: Mapping[str, Any]) -> tuple[float, str]:
    return -task["success_at_end_rate"], task["task"]


def _title(task: Mapping[str, Any]) -> str:
    return f"{title(task['task'])}{' *' if task['development'] else ''}"


def _row(task: Mapping[str, Any]) -> list[str]:
    low, high = (f"{100.0 * bound:.1f}" for bound in task["interval_at_end"] or (0.0, 0.0))
    median = next(cell for cell in task["cells"] if cell["seed"] == task["median_seed"])
    random = task["baselines"]["random"]
    over = " !" if task["over_budget"] else ""
    return [
        _title(task),
        f"`{task['demonstrator']}`",
        f"{100.0 * task['success_at_end_rate']:.1f} % ({low}–{high} %)",
        f"{100.0 * task['safe_success_rate']:.1f} %",
        f"{random['successes_at_end']} of {random['episodes']}",
        f"{median['train_cpu_s'] / 60.0:.1f}{over}",
    ]
