"""Distillation: policies learned from scratch teach others by their own successful episodes.

    python benchmarks/distillation.py [--only handover/task] [--seeds 1 2] [--folder runs]

The teachers are the runs from scratch of learning.py in the same folder, which observe the whole
scene. Each plays 600 episodes, from seed 100,000 on. By behaviour cloning from the successful ones,
a student learns what its teacher does, without demonstrations of an expert: once from what the task
file lists for each robot (`task`), once from the whole scene (`scene`). A student has the seed of
its teacher. It then plays 300 episodes that neither training nor the choice of a policy has seen.

Collects, trains and evaluates what is not done yet, goes on with what was stopped, and writes

- benchmarks/results/distillation.tar.xz: plan, tables and result of each student; see
  kept_runs.py, and
- benchmarks/results/distillation.json: what came of each, with the commands that make it again.

A student takes about a quarter of an hour on one core, half of it for the teacher's episodes.
`--publish` puts the policies that observe what the task file lists into the zoo, for each task that
of the median seed (of two, the one that lasts less), if it succeeds in 95 %. Nothing is left
out: a run that failed is there as it is.
"""

from __future__ import annotations

import argparse
import json
import sys
from itertools import product
from pathlib import Path

from cloning import ZOO, taskbuilder
from kept_runs import RESULTS, unpacked
from learning import TASKS, publish
from machine import describe_machine
from training_runs import EPISODES, summary, trained

KEPT = "distillation"
"""The group of the runs that are kept."""
NOISE = {"task": "0.03", "scene": "0.1"}
"""On standardised observations. The scene has the grasp points as seen from the tools. Without
them, more noise blurs the grasps."""
RUNS = tuple(f"{task}/{observed}" for task, observed in product(TASKS, NOISE))
SEEDS = (1, 2)
FIRST_EPISODE, TAUGHT, UPDATES = 100_000, 600, 15_000
TRACK, LESSON = "distilled", "lesson.json"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=RUNS, default=RUNS, metavar="TASK/OBSERVED")
    parser.add_argument("--seeds", nargs="+", type=int, default=SEEDS, help="of the teachers")
    parser.add_argument("--publish", action="store_true", help="put policies into the zoo")
    parser.add_argument("--folder", type=Path, default=Path("runs"), help="of the runs")
    arguments = parser.parse_args()
    for name, seed in product(arguments.only, arguments.seeds):
        print(run(name, seed, arguments.folder), flush=True)
        write_summary()
    for name in arguments.only if arguments.publish else ():
        task, observed = name.split("/")
        if observed == "task":
            runs = [train_words(name, seed, arguments.folder)[-1] for seed in arguments.seeds]
            publish([Path(run) for run in runs], ZOO / task / TRACK)
    return 0


def run(name: str, seed: int, folder: Path) -> str:
    """Collect, train, evaluate and keep one student; say what came of it."""
    lesson, train = collect_words(name, seed, folder), train_words(name, seed, folder)
    taskbuilder(*lesson)
    info = json.loads(taskbuilder("dataset", "info", lesson[-1], "--json"))
    about = {
        "commands": [" ".join(["taskbuilder", *words]) for words in (lesson, train)],
        "teacher": next(iter(info["tasks"].values()))["policies"],
    }
    result = trained(train, KEPT, {LESSON: json.dumps(about, indent=1) + "\n"})
    return f"{Path(train[-1]).name}: {result['success_rate']:.1%} of {EPISODES} episodes"


def collect_words(name: str, seed: int, folder: Path) -> list[str]:
    """What collects the episodes of a teacher, or what is missing of them."""
    task, _ = name.split("/")
    teacher, data = folder / f"{task}-scratch-{seed}", folder / "taught" / f"{task}-{seed}"
    words = ["collect", task, "--policy", str(teacher), "--episodes", str(TAUGHT)]
    return [*words, "--seed", str(FIRST_EPISODE), "--jobs", "1", "--out", str(data)]


def train_words(name: str, seed: int, folder: Path) -> list[str]:
    """What trains a student from the beginning."""
    task, observed = name.split("/")
    every = str(UPDATES // 5)
    words = ["train", "--algorithm", "bc", "--data", str(folder / "taught" / f"{task}-{seed}")]
    words += ["--observe", observed, "--seed", str(seed), "--steps", str(UPDATES)]
    words += ["--evaluate-every", every, "--checkpoint-every", every]
    words += ["--evaluate-episodes", "100", "--set", f"noise={NOISE[observed]}"]
    return [*words, "--out", str(folder / f"{task}-{observed}-{seed}")]


def write_summary() -> None:
    """Write what came of all students that are kept."""
    with unpacked(KEPT) as kept:
        runs = [
            {**summary(file.parent), **json.loads(file.read_text())}
            for file in sorted(kept.glob(f"*/{LESSON}"))
        ]
    data = {"command": "python benchmarks/distillation.py", "machine": describe_machine()}
    text = json.dumps({**data, "runs": runs}, indent=2)
    (RESULTS / "distillation.json").write_text(text + "\n")


if __name__ == "__main__":
    sys.exit(main())
