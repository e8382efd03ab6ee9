"""The learning runs: eight tasks, with demonstrations and from scratch, several seeds each.

    python benchmarks/learning.py [--only handover/demos] [--seeds 1 2 3] [--jobs 2] [--folder runs]

The algorithm is `maddpg` with the preset of each track. For comparison, `mappo` and `ippo` are PPO
with a centralised critic and independent PPO, for as many control steps and also from scratch.

Trains what is not trained yet, goes on with what was stopped, plays each policy in 300 episodes
that neither training nor the choice of a policy has seen, and writes

- benchmarks/results/learning.tar.xz: plan, tables and result of each run; see kept_runs.py,
- benchmarks/results/learning.json: what came of each, with the command that makes it again, and
- with `--publish`, taskbuilder/policies/models/TASK/NAME.npz: the policy of the median seed, with
  its plan and its curve beside it, if it succeeds in 95 % of the episodes.

A run is minutes to two hours on one core. Nothing is left out: a run that failed is there as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from cloning import ZOO, keep
from kept_runs import RESULTS, unpacked
from machine import describe_machine
from training_runs import EPISODES, summary, trained

TASKS = ("handover", "pick_push_place", "collaborative_lift")
LIBRARY = ("two_buttons", "lift_pot", "open_lid", "stack_together", "lift_triangle")
"""Other tasks of the library, chosen before anything was trained on them."""

SEEDS = (1, 2, 3)

COMMON = ("--evaluate-episodes", "100", "--stop-at", "0.99")
SCENE = ("--observe", "scene")
EVERY = ("--evaluate-every", "10000")
STEPS = ("--steps", "150000", *EVERY)
PPO = ("--algorithm", "ppo", "--envs", "8")
TRACKS = {
    "demos": (*SCENE, "--demos", "200", "--steps", "50000", "--evaluate-every", "5000"),
    "scratch": (*SCENE, *STEPS),
    "own": ("--observe", "task", "--steps", "300000", *EVERY),
    "mappo": (*SCENE, *STEPS, *PPO, "--preset", "mappo"),
    "ippo": (*SCENE, *STEPS, *PPO, "--preset", "ippo"),
}
"""What `taskbuilder train` is told beside the task and the seed, by track."""

RUNS = (
    *(f"{task}/{track}" for track in TRACKS for task in TASKS),
    *(f"{task}/scratch" for task in LIBRARY),
)
"""By TASK/TRACK."""

ZOO_NAMES = {"own": "scratch-own"}
"""Names of policies in the zoo, where they are not those of the tracks here."""

WORTH_KEEPING = 0.95
"""Success rate of the median seed from which on its policy is one for the zoo."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", metavar="TASK/TRACK")
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS)
    parser.add_argument("--jobs", type=int, default=2, help="runs at once, a core each")
    parser.add_argument("--folder", type=Path, default=Path("runs"), help="of the runs themselves")
    parser.add_argument("--publish", action="store_true", help="put policies into the zoo")
    arguments = parser.parse_args()
    asked = arguments.only or RUNS
    wanted = [(name, seed) for seed in arguments.seeds for name in asked]
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for line in pool.map(partial(run, folder=arguments.folder), wanted):
            print(line, flush=True)
            write_summary()
    for name in asked if arguments.publish else ():
        runs = [Path(command(name, seed, arguments.folder)[-1]) for seed in arguments.seeds]
        task, track = name.split("/")
        publish(runs, ZOO / task / ZOO_NAMES.get(track, track))
    return 0


def command(name: str, seed: int, folder: Path) -> list[str]:
    """What trains a run from the beginning."""
    task, track = name.split("/")
    out = folder / f"{task}-{track}-{seed}"
    return ["train", task, "--seed", str(seed), *TRACKS[track], *COMMON, "--out", str(out)]


def run(wanted: tuple[str, int], folder: Path) -> str:
    """Train, evaluate and keep one run; say what came of it."""
    words = command(*wanted, folder)
    result = trained(words, "learning")
    return f"{Path(words[-1]).name}: {result['success_rate']:.1%} of {EPISODES} episodes"


def publish(runs: Sequence[Path], kept: Path) -> None:
    """Put the policy of the median run into the zoo, if it does the task.

    The median is that of success at the last step: what does not last is worth less.
    """
    lasting = [found(run)["success_at_end_rate"] for run in runs]
    median = runs[lasting.index(sorted(lasting)[(len(runs) - 1) // 2])]
    if found(median)["success_rate"] < WORTH_KEEPING:
        return
    kept.parent.mkdir(parents=True, exist_ok=True)
    keep(median, kept)


def found(run: Path) -> dict[str, float]:
    """What a run's policy achieved in the episodes of the claim."""
    rates: dict[str, float] = json.loads((run / "evaluation.json").read_text())
    return rates


def write_summary() -> None:
    """Write what came of all runs that are kept, and of the trials that were evaluated."""
    made_by = {"learning": {"command": "python benchmarks/learning.py"}, "learning_trials": {}}
    for name, about in made_by.items():
        with unpacked(name) as kept:
            runs = [summary(file.parent) for file in sorted(kept.glob("*/evaluation.json"))]
        data = {**about, "machine": describe_machine(), "runs": runs}
        (RESULTS / f"{name}.json").write_text(json.dumps(data, indent=2) + "\n")


if __name__ == "__main__":
    sys.exit(main())
