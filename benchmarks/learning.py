"""The learning runs: three tasks, with demonstrations and from nothing, three seeds each.

And, where not every seed learns from nothing, the same with half of the training episodes begun in
states of the expert.

    python benchmarks/learning.py [--only handover/demos] [--seeds 1 2 3] [--jobs 2] [--folder runs]

Trains what is not trained yet, goes on with what was stopped, plays each policy in 300 episodes
that neither training nor the choice of a policy has seen, and writes

- benchmarks/results/learning/TASK-TRACK-SEED/: plan, tables and result of a run,
- benchmarks/results/learning.json: what came of each, with the command that makes it again, and
- taskbuilder/learn/models/TASK/TRACK.npz: of the seeds' policies the one that did best in the
  evaluations of its training, with its plan and its curve beside it, if it can do the task. The
  zoo has what learned from demonstrations and from nothing.

A run is minutes to an hour and a half on one core. Nothing is left out: a
run that failed is there as it is.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from machine import describe_machine
from training_runs import EPISODES, summary, trained

RESULTS = Path(__file__).parent / "results"
ZOO = Path(__file__).parents[1] / "taskbuilder" / "learn" / "models"
TASKS = ("handover", "pick_push_place", "collaborative_lift")
SEEDS = (1, 2, 3)

COMMON = ("--observe", "scene", "--evaluate-episodes", "100", "--stop-at", "0.99")
LONG = ("--steps", "300000", "--evaluate-every", "10000")
TRACKS = {
    "demos": ("--demos", "200", "--steps", "100000", "--evaluate-every", "5000"),
    "scratch": LONG,
    "resets": ("--starts", "0.5", *LONG),
}
"""What `taskbuilder train` is told beside the task and the seed, by track."""

IN_ZOO = tuple(f"{task}/{track}" for track in ("demos", "scratch") for task in TASKS)
RUNS = (*IN_ZOO, "handover/resets", "pick_push_place/resets")
"""By TASK/TRACK."""

SETTINGS = {
    # What two arms hold between them slips from them if they move much apart by chance.
    "collaborative_lift/demos": ("noise=0.05", "final_noise=0.02"),
    "collaborative_lift/scratch": ("noise=0.25", "final_noise=0.05", "noise_until=0.3"),
}
"""What is chosen of the learner's own settings, by TASK/TRACK."""

WORTH_KEEPING = 0.9
"""Success in an evaluation during training from which on a policy is one for the zoo."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", metavar="TASK/TRACK")
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS)
    parser.add_argument("--jobs", type=int, default=2, help="runs at once, a core each")
    parser.add_argument("--folder", type=Path, default=Path("runs"), help="of the runs themselves")
    arguments = parser.parse_args()
    asked = arguments.only or RUNS
    wanted = [(name, seed) for seed in arguments.seeds for name in asked]
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for line in pool.map(partial(run, folder=arguments.folder), wanted):
            print(line, flush=True)
    for name in sorted({*asked} & {*IN_ZOO}):
        publish(name, arguments.folder)
    write_summary()
    return 0


def command(name: str, seed: int, folder: Path) -> list[str]:
    """What trains a run from the beginning."""
    task, track = name.split("/")
    out = folder / f"{task}-{track}-{seed}"
    settings = SETTINGS.get(name, ())
    options = [*TRACKS[track], *COMMON, *(("--set", *settings) if settings else ())]
    return ["train", task, "--seed", str(seed), *options, "--out", str(out)]


def run(wanted: tuple[str, int], folder: Path) -> str:
    """Train, evaluate and keep one run; say what came of it."""
    words = command(*wanted, folder)
    result = trained(words, RESULTS / "learning")
    return f"{Path(words[-1]).name}: {result['success_rate']:.1%} of {EPISODES} episodes"


def publish(name: str, folder: Path) -> None:
    """Put the best of the seeds' policies into the zoo, by what training knew of them."""
    runs = [Path(command(name, seed, folder)[-1]) for seed in SEEDS]
    done = [run for run in runs if (run / "evaluation.json").exists()]
    best = max(done, key=known_success, default=None)
    if best is None or known_success(best) < WORTH_KEEPING:
        return
    kept = ZOO / name
    kept.parent.mkdir(parents=True, exist_ok=True)
    for file, ending in (
        ("policy.npz", ".npz"),
        ("run.json", ".json"),
        ("evaluations.csv", ".csv"),
    ):
        shutil.copyfile(best / file, kept.with_suffix(ending))


def known_success(run: Path) -> float:
    """The best success rate that evaluations during training found."""
    with (run / "evaluations.csv").open(newline="") as lines:
        return max(float(row["success_rate"]) for row in csv.DictReader(lines))


def write_summary() -> None:
    """Write what came of all runs that are kept."""
    folders = sorted((RESULTS / "learning").glob("*/"))
    data = {
        "command": "python benchmarks/learning.py",
        "machine": describe_machine(),
        "runs": [summary(folder) for folder in folders],
    }
    (RESULTS / "learning.json").write_text(json.dumps(data, indent=2) + "\n")


if __name__ == "__main__":
    sys.exit(main())
