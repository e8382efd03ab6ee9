"""An ablation of Handover with `maddpg`: rewards, demonstrations, observations; two seeds each.

    python benchmarks/deadlock.py [--only team local] [--seeds 1 2] [--jobs 1] [--folder runs/here]

One more way of training belongs to it, progress only: it is handover/scratch of learning.py, with
the same options.

Trains what is not trained yet, goes on with what was stopped, plays each policy in 300 episodes
that training has not seen, and writes

- benchmarks/results/deadlock.tar.xz: plan, tables and result of each run; see kept_runs.py, and
- benchmarks/results/deadlock.json: what came of each, with the command that makes it again.

All runs have the same learner (`maddpg`) and at most 150,000 control steps, which take half an hour
of one core; `team_long` and `starts_long` have at most 500,000, and of them only seed 1 was run.
Their settings are the same, except for the preset `demos` with demonstrations. All but `own`
observe the whole scene. Nothing is left out: a run that failed is there as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path

from kept_runs import RESULTS, unpacked
from machine import describe_machine
from training_runs import EPISODES, summary, trained

SEEDS = (1, 2)
WRONG_ORDER = "tests/tasks/variants/handover_kept.yaml"

WAYS = {
    "team": ("handover", "--reward", "team"),
    "local": ("handover", "--reward", "local"),
    "shaped": ("handover", "--reward", "shaped"),
    "wrong_order": (WRONG_ORDER, "--reward", "team"),
    "demos": ("handover", "--reward", "team", "--demos", "200"),
    "own": ("handover", "--reward", "ratchet", "--observe", "task"),
    "team_long": ("handover", "--reward", "team"),
    "starts_long": ("handover", "--reward", "team", "--starts", "0.5"),
}
"""The task and what is particular to each way of training."""

STEPS = {"team_long": 500_000, "starts_long": 500_000}
"""Control steps, where they are not 150,000."""

COMMON = ("--evaluate-every", "10000", "--evaluate-episodes", "100", "--stop-at", "0.99")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=WAYS, default=tuple(WAYS), metavar="WAY")
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS)
    parser.add_argument("--jobs", type=int, default=1, help="runs at once, a core each")
    parser.add_argument("--folder", type=Path, default=Path("runs/deadlock"), help="of the runs")
    arguments = parser.parse_args()
    wanted = list(product(arguments.seeds, arguments.only))
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for line in pool.map(partial(run, folder=arguments.folder), wanted):
            print(line, flush=True)
    return 0


def run(wanted: tuple[int, str], folder: Path) -> str:
    """Train, evaluate and keep one run; say what came of it."""
    seed, way = wanted
    result = trained(command(way, seed, folder), "deadlock")
    write_summary()
    return f"{way}-{seed}: {result['success_rate']:.1%} of {EPISODES} episodes"


def command(way: str, seed: int, folder: Path) -> list[str]:
    """What trains a run from the beginning."""
    task, *options = WAYS[way]
    length = ["--observe", "scene", "--steps", str(STEPS.get(way, 150_000))]
    words = ["train", task, *length, *COMMON, *options, "--seed", str(seed)]
    return [*words, "--out", str(folder / f"{way}-{seed}")]


def write_summary() -> None:
    """Write what came of all runs that are kept."""
    with unpacked("deadlock") as kept:
        data = {
            "command": "python benchmarks/deadlock.py",
            "machine": describe_machine(),
            "runs": [summary(folder) for folder in sorted(kept.glob("*/"))],
        }
    (RESULTS / "deadlock.json").write_text(json.dumps(data, indent=2) + "\n")


if __name__ == "__main__":
    sys.exit(main())
