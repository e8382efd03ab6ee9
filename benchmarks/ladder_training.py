"""Training by the ladders that descriptions write, and by those made from the expert's stages.

    python benchmarks/ladder_training.py [--only handover/expert ...] [--folder runs/ladders]

`maddpg` with 200 demonstrations, 50,000 control steps and training seed 11, on the three tasks of
the paper and on five others, which were named before anything was trained by these ladders. Each
run is 40 to 90 minutes on one core, all 16 about 16 hours.

A run has checkpoints every 2,500 steps. Start the command again after it was stopped: it goes on
with the run that it was at, and leaves out those that are done. Each policy is then played in 300
episodes with seeds from 3,000,000 on, by which nothing was chosen.

Writes, after each run and each evaluation of a policy,

- benchmarks/results/ladder_training.csv: a row for each evaluation during training, and
- benchmarks/results/ladder_training.json: what came of each run, with its command.

A small trial, whose results are no results:

    python benchmarks/ladder_training.py --only handover/expert --steps 400 --demos 4 \\
        --episodes 4 --folder /tmp/trial --results /tmp/trial
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from machine import describe_machine
from training_runs import MEASURED, TASKBUILDER

ROOT = Path(__file__).resolve().parents[1]
PAPER = ("handover", "pick_push_place", "collaborative_lift")
OTHERS = ("button_hatch", "insert_peg", "suction_sort", "swap_places", "turntable_serve")
LADDERS = ("task", "expert")
RUNS = tuple(f"{task}/{ladder}" for task in (*PAPER, *OTHERS) for ladder in LADDERS)
"""By TASK/LADDER."""

SEED = 11
FIRST_EPISODE = 3_000_000
NAME = "ladder_training"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=RUNS, metavar="TASK/LADDER", default=RUNS)
    parser.add_argument("--folder", type=Path, default=Path("runs/ladders"), help="of the runs")
    parser.add_argument("--results", type=Path, default=ROOT / "benchmarks" / "results")
    parser.add_argument("--steps", type=int, default=50_000, metavar="N", help="control steps")
    parser.add_argument("--demos", type=int, default=200, metavar="N", help="demonstrations")
    parser.add_argument("--episodes", type=int, default=300, metavar="N", help="of each policy")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    arguments.results.mkdir(parents=True, exist_ok=True)
    for name in arguments.only:
        folder = arguments.folder / f"{name.replace('/', '-')}-{SEED}"
        train(folder, command(name, folder, arguments))
        write(arguments.folder, arguments.results)
        evaluate(folder, arguments.episodes)
        write(arguments.folder, arguments.results)
        print(f"{name}: {json.loads((folder / 'evaluation.json').read_text())['success_rate']:.1%}")
    return 0


def command(name: str, out: Path, arguments: argparse.Namespace) -> list[str]:
    """What trains a run from the beginning."""
    task, ladder = name.split("/")
    every = str(max(arguments.steps // 10, 4))
    checkpoints = str(max(arguments.steps // 20, 4))
    return [
        *("train", task, "--ladder", ladder, "--seed", str(SEED), "--observe", "scene"),
        *("--demos", str(arguments.demos), "--steps", str(arguments.steps)),
        *("--evaluate-every", every, "--checkpoint-every", checkpoints),
        *("--evaluate-episodes", str(min(arguments.episodes, 100)), "--film-every", "0"),
        *("--out", str(out)),
    ]


def train(folder: Path, words: list[str]) -> None:
    """Train, or go on with what was stopped."""
    if (folder / "evaluation.json").exists():
        return
    again = ["train", "--resume", str(folder)] if (folder / "run.json").exists() else words
    with folder.with_name(f"{folder.name}.log").open("a") as log:
        subprocess.run([*TASKBUILDER, *again], stdout=log, stderr=log, check=True)


def evaluate(folder: Path, episodes: int) -> None:
    """Play the policy of a run in episodes that nothing was chosen by."""
    found = folder / "evaluation.json"
    if found.exists():
        return
    words = ["evaluate", str(folder), "--seed", str(FIRST_EPISODE), "--controls", "0"]
    words += ["--episodes", str(episodes), "--jobs", "1", "--json"]
    played = subprocess.run([*TASKBUILDER, *words], capture_output=True, check=True, text=True)
    found.write_text(played.stdout)


def write(folder: Path, results: Path) -> None:
    """Write the tables of all runs so far."""
    runs = [run for run in sorted(folder.iterdir()) if (run / "run.json").exists()]
    rows = [row for run in runs for row in evaluations(run)]
    with (results / f"{NAME}.csv").open("w", newline="") as file:
        if rows:
            table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    data = {
        "command": "python benchmarks/ladder_training.py",
        "machine": describe_machine(),
        "runs": [summary(run) for run in runs],
    }
    (results / f"{NAME}.json").write_text(json.dumps(data, indent=1) + "\n")


def evaluations(run: Path) -> Iterator[dict[str, Any]]:
    """The evaluations of a run during training."""
    plan = json.loads((run / "run.json").read_text())
    file = run / "evaluations.csv"
    lines = file.read_text().splitlines() if file.exists() else []
    for row in csv.DictReader(lines):
        kept = ("step", "success_rate", "success_at_end_rate", "team_return")
        yield {"task": plan["task"], "ladder": plan["ladder"], **{key: row[key] for key in kept}}


def summary(run: Path) -> Mapping[str, Any]:
    """What came of a run; of one that is not done, what it is."""
    plan = json.loads((run / "run.json").read_text())
    kept = ("task", "ladder", "progress_range", "no_progress_timeout_s", "seed", "command")
    file = run / "evaluation.json"
    result = json.loads(file.read_text()) if file.exists() else {}
    return {key: plan[key] for key in kept} | {k: result[k] for k in MEASURED if k in result}


if __name__ == "__main__":
    sys.exit(main())
