"""Is holding on optimal? What the expert earns, and those who stop half-way or do nothing.

    python benchmarks/holding_on.py

No learning. From each of 40 seeds that nothing was tuned on, the expert plays its whole script;
then its script up to the end of each stage but the last, holding still from there on; and one
player holds still from the start. They play with the constants of the tasks; and the Handover once
more with a bonus for handing over that is smaller than the one for holding: 0.5 to 1.0, where the
task has 2.0.

Writes a line an episode to benchmarks/results/holding_on.csv, where an interrupted run goes on, and
means and paired differences to benchmarks/results/holding_on.json.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from statistics import fmean
from typing import Any

from machine import describe_machine

from taskbuilder import parallel_env, play
from taskbuilder.expert import Expert, stall_after_stages
from taskbuilder.expert.baselines import EXPERT, NOTHING, Baseline
from taskbuilder.intervals import PairedDifference
from taskbuilder.jobs import workers
from taskbuilder.processes import cores
from taskbuilder.rollout import HoldStill, Rollout

RESULTS = Path(__file__).parent / "results"
WRONG = Path(__file__).parents[1] / "tests" / "tasks" / "variants" / "handover_kept.yaml"
TASKS = {
    "pick_push_place": "pick_push_place",
    "collaborative_lift": "collaborative_lift",
    "handover": "handover",
    "handover, wrong order": str(WRONG),
}
FIRST_SEED = 3_200_000
DISCOUNT = 0.95
FIELDS = ("task", "way", "seed", "success", "return", "discounted_return")


def play_all(job: tuple[str, int]) -> list[dict[str, Any]]:
    """Every way of playing, from one seed."""
    task, seed = job
    with closing(parallel_env(TASKS[task])) as env, closing(Expert(env)) as expert:
        whole = expert.play(seed)
        plays: dict[Baseline, Rollout] = {EXPERT: whole, **stall_after_stages(env, whole)}
        plays[NOTHING] = play(env, HoldStill(), seed)
    return [
        {
            "task": task,
            "way": str(baseline),
            "seed": seed,
            "success": int(rollout.success),
            "return": f"{rollout.team_return:.6f}",
            "discounted_return": f"{rollout.discounted(DISCOUNT):.6f}",
        }
        for baseline, rollout in plays.items()
    ]


def rows_of(file: Path) -> list[dict[str, str]]:
    """The episodes that have been played already."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return [row for row in csv.DictReader(lines) if None not in row.values()]


def summary(rows: list[dict[str, str]]) -> Iterator[dict[str, Any]]:
    """Figures by task and way, each beside the expert's on the same seeds."""
    groups: dict[tuple[str, str], dict[str, dict[str, str]]] = {}
    for row in rows:
        groups.setdefault((row["task"], row["way"]), {})[row["seed"]] = row
    for (task, baseline), own in groups.items():
        expert = groups[task, str(EXPERT)]
        found: dict[str, Any] = {
            "task": task,
            "way": baseline,
            "episodes": len(own),
            "successes": sum(row["success"] == "1" for row in own.values()),
        }
        for column in ("return", "discounted_return"):
            theirs = [float(row[column]) for row in own.values()]
            ours = [float(expert[seed][column]) for seed in own]
            lead = PairedDifference.of(ours, theirs)
            found[column] = round(fmean(theirs), 3)
            found[f"{column}_behind"] = [round(lead.mean, 3), round(lead.half_width, 3)]
        yield found


def main() -> None:
    """Play what has not been played, and sum up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=cores())
    arguments = parser.parse_args()
    file = RESULTS / "holding_on.csv"
    known = {(row["task"], int(row["seed"])) for row in rows_of(file)}
    seeds = range(FIRST_SEED, FIRST_SEED + arguments.seeds)
    jobs = [(task, seed) for task in TASKS for seed in seeds if (task, seed) not in known]
    with file.open("a", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, FIELDS)
        if not known:
            writer.writeheader()
        with workers(arguments.jobs) as spread:
            for rows in spread(play_all, jobs):
                writer.writerows(rows)
                lines.flush()
    found = list(summary(rows_of(file)))
    text = json.dumps({"machine": describe_machine(), "ways": found}, indent=2, ensure_ascii=False)
    (RESULTS / "holding_on.json").write_text(text + "\n", encoding="utf-8")
    for row in found:
        margin, half = row["discounted_return_behind"]
        print(
            f"{row['task']:22} {row['way']:20} {row['return']:8.2f} {row['discounted_return']:8.2f}"
            f"  behind by {margin:.2f} ± {half:.2f}"
        )


if __name__ == "__main__":
    main()
