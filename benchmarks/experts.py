"""How reliably, how soon and how lastingly the experts do their tasks.

    python benchmarks/experts.py

plays every task and variation over 200 seeds that nothing was tuned on, each episode to its end,
writes a line an episode to benchmarks/results/experts.csv, where an interrupted run goes on and
which is compressed at the end, and a summary to benchmarks/results/experts.json. Episodes of a
task's earlier versions are forgotten. With `--only`, only these tasks are played; with
`--seeds 0`, none.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

from machine import describe_machine

from taskbuilder import catalogue, load_task, parallel_env
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.script.player import Expert
from taskbuilder.jobs import workers
from taskbuilder.processes import cores
from taskbuilder.validate.proportion import Proportion

RESULTS = Path(__file__).parent / "results"
FIRST_SEED = 3_100_000
FIELDS = (
    *("task", "variation", "seed", "success", "first_success", "at_end", "peak_force"),
    *("steps", "planning_s", "stage", "cause", "message", "version"),
)

Job = tuple[str, int, int]


_last: dict[tuple[str, int], tuple[TaskEnv, Expert]] = {}
"""The last task and variation that this process played."""


def expert_of(task: str, variation: int) -> Expert:
    """The expert of a task and variation; that of another one is closed, to free its memory."""
    if (task, variation) not in _last:
        while _last:
            _, (env, expert) = _last.popitem()
            expert.close()
            env.close()
        env = parallel_env(task, variation=variation)
        _last[task, variation] = env, Expert(env)
    return _last[task, variation][1]


def play(job: Job) -> dict[str, Any]:
    """One episode."""
    task, variation, seed = job
    done = expert_of(task, variation).play(seed, forces=True)
    trouble = done.trouble
    return {
        "task": task,
        "variation": variation,
        "seed": seed,
        "success": int(done.success),
        "first_success": done.first_success or "",
        "at_end": int(done.success_at_end),
        "peak_force": f"{done.peak_robot_force or 0.0:.1f}",
        "steps": done.stage_ends[-1] if done.stage_ends else "",
        "planning_s": f"{done.log.planning_s if done.log else 0.0:.4f}",
        "stage": trouble.stage if trouble else "",
        "cause": trouble.cause if trouble else "",
        "message": trouble.message if trouble else "",
        "version": version_of(task),
    }


@cache
def version_of(task: str) -> int:
    """The version of a task."""
    return load_task(task).file.spec.version


def rows_of(file: Path) -> list[dict[str, str]]:
    """The episodes of today's versions that have been played already."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if None not in row.values()]
    return [row for row in rows if int(row["version"] or 1) == version_of(row["task"])]


def summary(rows: Iterable[dict[str, str]]) -> dict[str, Any]:
    """Figures by task and variation."""
    groups: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        groups.setdefault(f"{row['task']}/{row['variation']}", []).append(row)
    found = {}
    for name, own in sorted(groups.items()):
        solved = sum(row["success"] == "1" for row in own)
        steps = sorted(int(row["first_success"]) for row in own if row["first_success"])
        planning = [float(row["planning_s"]) for row in own]
        low, high = Proportion(solved, len(own)).interval
        failed = [row for row in own if row["success"] != "1"]
        found[name] = {
            "episodes": len(own),
            "solved": solved,
            "interval": [round(low, 4), round(high, 4)],
            "first_success_median": median(steps) if steps else None,
            "first_success_last": steps[-1] if steps else None,
            "at_end": sum(row["at_end"] == "1" for row in own),
            "peak_force_largest": max(float(row["peak_force"]) for row in own),
            "planning_median_s": round(median(planning), 4),
            "planning_longest_s": round(max(planning), 4),
            "failures": [
                {key: row[key] for key in ("seed", "stage", "cause", "message")} for row in failed
            ],
        }
    return found


def main() -> None:
    """Play what has not been played, and sum up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=cores())
    parser.add_argument("--only", nargs="+", metavar="TASK")
    parser.add_argument("--anew", action="store_true", help="forget the episodes played so far")
    arguments = parser.parse_args()
    file, packed = RESULTS / "experts.csv", RESULTS / "experts.csv.gz"
    if arguments.anew:
        file.unlink(missing_ok=True)
    elif packed.exists() and not file.exists():
        file.write_bytes(gzip.decompress(packed.read_bytes()))
    rows = rows_of(file)
    known = {(row["task"], int(row["variation"]), int(row["seed"])) for row in rows}
    seeds = range(FIRST_SEED, FIRST_SEED + arguments.seeds)
    tasks = arguments.only or catalogue().tasks
    scenes = [(n, k) for n in tasks for k in range(len(load_task(n).file.scenes))]
    jobs = [(n, k, seed) for n, k in scenes for seed in seeds if (n, k, seed) not in known]
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.DictWriter(lines, FIELDS)
        writer.writeheader()
        writer.writerows(rows)
        with workers(arguments.jobs) as spread:
            for row in spread(play, jobs):
                writer.writerow(row)
                lines.flush()
    found = summary(rows_of(file))
    packed.write_bytes(gzip.compress(file.read_bytes(), mtime=0))
    file.unlink()
    text = json.dumps({"machine": describe_machine(), "scenes": found}, indent=2)
    (RESULTS / "experts.json").write_text(text + "\n", encoding="utf-8")
    for name, figures in found.items():
        steps = f"{figures['first_success_median']} (last {figures['first_success_last']})"
        print(
            f"{name:24} {figures['solved']}/{figures['episodes']}  step {steps}  "
            f"planning {figures['planning_median_s']:.3f} s"
        )


if __name__ == "__main__":
    import experts  # worker processes import `play` by this name

    experts.main()
