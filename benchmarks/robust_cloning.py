"""Behaviour cloning from demonstrations of every variation, and what is left of it under noise.

    python benchmarks/robust_cloning.py [--only handover] [--seeds 1 2 3] [--jobs 2]

Three tasks, from states, 600 demonstrations of each that take the variations in turn, with noise on
the observations in training. Each policy plays 300 episodes that neither training nor the choice of
a policy has seen, and 300 more of each variation with Gaussian noise of 5 mm on all positions.

`handover_randomized` is Handover with quantities that are drawn in every episode, in demonstrations
and evaluations: the stick's mass, from 30 % below that of the lightest variation to 30 % above that
of the heaviest; its friction and the motors' gains, from ±30 % and ±20 %; and the delay of each
robot's actions, none or one control step. Its episodes have 65 control steps, as the expert, which
waits after each motion of a robot that may be delayed, is seldom done within 50. Its actions are
target poses instead of steps: which step is right depends on the earlier ones that a delayed robot
has yet to carry out, and policies that learned steps stopped short of their goals. Training adds
the default noise to observations. There are 1,200 demonstrations. The policies play 300 episodes of
each variation without noise.

Writes benchmarks/results/robust_cloning.json, with the commands that make each run again, and every
episode to robust_cloning.csv.gz. What was stopped goes on; nothing is left out. A run takes about a
quarter of an hour on one core, most of it for the evaluations. `--publish` puts a policy of each
task into the zoo, that of the median seed.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import io
import json
import re
import shutil
import sys
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

from cloning import ZOO, keep, minutes, taskbuilder
from machine import describe_machine

from taskbuilder import catalogue

RANDOMIZED = "handover_randomized"
TASKS = ("pick_push_place", "collaborative_lift", "handover", RANDOMIZED)
RESULTS = Path(__file__).parent / "results"
SUMMARY, ROWS = RESULTS / "robust_cloning.json", RESULTS / "robust_cloning.csv.gz"
FIRST_DEMO, FIRST_EPISODE = 100_000, 2_000_000
UPDATES, EPISODES, NOISE_M = 15_000, 300, 0.005
DEMOS = dict.fromkeys(TASKS, 600) | {RANDOMIZED: 1_200}
EVERY = str(UPDATES // 5)
TRACK = "cloned"
ACTION = "action: {arm: tcp_pose}"
QUANTITIES = """
randomize:
  stick.mass: {uniform: [0.056, 0.195]}
  stick.friction: {uniform: [0.56, 1.04]}
  left.gains: {uniform: [0.8, 1.2]}
  right.gains: {uniform: [0.8, 1.2]}
  left.delay: {choice: [0, 1]}
  right.delay: {choice: [0, 1]}
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=TASKS, choices=TASKS, metavar="TASK")
    parser.add_argument("--seeds", nargs="+", type=int, default=(1, 2, 3))
    parser.add_argument("--jobs", type=int, default=1, help="runs at once")
    parser.add_argument("--publish", action="store_true", help="put policies into the zoo")
    parser.add_argument("--folder", type=Path, default=Path("runs/robust"), help="of the runs")
    arguments = parser.parse_args()
    for task in arguments.only:
        collect(task, arguments.folder)
    wanted = [(task, seed) for seed in arguments.seeds for task in arguments.only]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for line in pool.map(partial(run, folder=arguments.folder), wanted):
            print(line, flush=True)
            write(arguments.folder)
    if arguments.publish:
        for task in set(arguments.only) - {RANDOMIZED}:
            publish(task, arguments.folder)
    return 0


def collect(task: str, folder: Path) -> None:
    """Collect the demonstrations of a task, or what is missing of them."""
    folder.mkdir(parents=True, exist_ok=True)
    if task == RANDOMIZED:
        write_randomized(folder)
    taskbuilder(*collect_words(task, folder))


def collect_words(task: str, folder: Path) -> list[str]:
    words = ["collect", named(task, folder), "--episodes", str(DEMOS[task]), "--variation", "all"]
    words += ["--observe", "scene", "--seed", str(FIRST_DEMO)]
    words += ["--randomize"] if task == RANDOMIZED else []
    return [*words, "--out", str(folder / "data" / task)]


def named(task: str, folder: Path) -> str:
    """What commands call a task: its name, or the path of its file."""
    return str(folder / f"{task}.yaml") if task == RANDOMIZED else task


def write_randomized(folder: Path) -> None:
    """Write Handover's files anew, with what is drawn at random in every episode."""
    source = catalogue().task("handover").file
    text = source.read_text(encoding="utf-8").replace("task: handover", f"task: {RANDOMIZED}")
    text = text.replace("episode_steps: 50", "episode_steps: 65")
    text = re.sub(r"^( +)home: .*$", rf"\g<0>\n\g<1>{ACTION}", text, flags=re.MULTILINE)
    (folder / f"{RANDOMIZED}.yaml").write_text(text + QUANTITIES, encoding="utf-8")
    shutil.copyfile(source.with_suffix(".py"), folder / f"{RANDOMIZED}.py")


def run(wanted: tuple[str, int], folder: Path) -> str:
    """Train and evaluate one run, as far as this has not been done; say what came of it."""
    task, seed = wanted
    out = folder / f"{task}-{seed}"
    log = folder / f"{out.name}.log"
    train = train_words(task, seed, folder)
    if not (out / "policy.npz").exists() or not (out / "trained").exists():
        taskbuilder(*(["train", "--resume", str(out)] if out.exists() else train), log=log)
        (out / "trained").touch()
    said = []
    for name, words in evaluations(task, out).items():
        if not (file := out / f"{name}.json").exists():
            file.write_text(taskbuilder(*words, "--controls", "0", "--jobs", "1", "--json"))
        said.append(f"{name} {worst(played(json.loads(file.read_text()))):.1%}")
    words = [collect_words(task, folder), train, *evaluations(task, out).values()]
    commands = [" ".join(["taskbuilder", *each]) for each in words]
    (out / "commands.json").write_text(json.dumps(commands))
    return f"{out.name}: {', '.join(said)}"


def train_words(task: str, seed: int, folder: Path) -> list[str]:
    """What trains a run from the beginning."""
    words = ["train", "--algorithm", "bc", "--data", str(folder / "data" / task)]
    words += ["--seed", str(seed), "--steps", str(UPDATES)]
    words += [] if task == RANDOMIZED else ["--set", "noise=0.1"]
    words += ["--evaluate-every", EVERY, "--checkpoint-every", EVERY]
    words += ["--task-path", str(folder)] if task == RANDOMIZED else []
    return [*words, "--out", str(folder / f"{task}-{seed}")]


def evaluations(task: str, out: Path) -> dict[str, list[str]]:
    """The evaluations of a policy, by name."""
    words = ["evaluate", str(out), "--seed", str(FIRST_EPISODE), "--episodes", str(EPISODES)]
    if task == RANDOMIZED:
        words += ["--task-path", str(out.parent), "--variation", "all", "--randomize"]
        return {"randomized": words}
    noise = ["--variation", "all", "--noise", str(NOISE_M)]
    return {"fresh": [*words, "--variation", "0"], "noise": [*words, *noise]}


def played(result: dict[str, Any]) -> list[dict[str, Any]]:
    """The evaluations of each variation in what `evaluate --json` printed."""
    return result.get("variations", [result])


def worst(variations: list[dict[str, Any]]) -> float:
    return min(each["success_rate"] for each in variations)


def write(folder: Path) -> None:
    """Write the results of all runs so far; those whose folders are elsewhere stay as they are."""
    here = sorted(file.parent for file in folder.glob("*/commands.json"))
    runs, rows = others({out.name for out in here})
    for out in here:
        task, seed = out.name.rsplit("-", 1)
        plan = json.loads((out / "run.json").read_text())
        found = {}
        for name in evaluations(task, out):
            result = played(json.loads((out / f"{name}.json").read_text()))
            keys = ("variation", "success_rate", "interval", "success_at_end_rate", "stages")
            found[name] = [{key: each.get(key, 0) for key in keys} for each in result]
            for each in (each for one in result for each in one["episodes"]):
                numbers = (each["variation"], each["seed"], int(each["success"]))
                rows.append([task, seed, name, *map(str, numbers)])
        runs.append(
            {
                "task": task,
                "seed": int(seed),
                "demonstrations": DEMOS[task],
                "updates": plan["steps"],
                "minutes": minutes(out),
                "evaluations": found,
                "commands": json.loads((out / "commands.json").read_text()),
            }
        )
    lines = io.StringIO()
    writer = csv.writer(lines, lineterminator="\n")
    writer.writerow(["task", "seed", "evaluation", "variation", "episode_seed", "success"])
    writer.writerows(sorted(rows, key=lambda row: (row[0], int(row[1]))))
    ROWS.write_bytes(gzip.compress(lines.getvalue().encode(), mtime=0))
    data = {
        "command": "python benchmarks/robust_cloning.py",
        "machine": describe_machine(),
        "episodes": EPISODES,
        "noise_m": NOISE_M,
        "quantities": QUANTITIES.strip(),
        "runs": sorted(runs, key=lambda run: (run["task"], run["seed"])),
    }
    SUMMARY.write_text(json.dumps(data, indent=2) + "\n")


def others(names: Collection[str]) -> tuple[list[dict[str, Any]], list[list[str]]]:
    """Runs, and their episodes, that were kept before and are none of these."""
    if not SUMMARY.exists():
        return [], []
    runs = json.loads(SUMMARY.read_text())["runs"]
    with gzip.open(ROWS, "rt", encoding="utf-8", newline="") as file:
        _, *rows = csv.reader(file)
    return (
        [run for run in runs if f"{run['task']}-{run['seed']}" not in names],
        [row for row in rows if f"{row[0]}-{row[1]}" not in names],
    )


def publish(task: str, folder: Path) -> None:
    """Put the policy of the median seed into the zoo, with its plan and its curve."""
    runs = [run for run in json.loads(SUMMARY.read_text())["runs"] if run["task"] == task]
    runs.sort(key=lambda run: worst(run["evaluations"]["noise"]))
    median = folder / f"{task}-{runs[(len(runs) - 1) // 2]['seed']}"
    keep(median, ZOO / task / TRACK)


if __name__ == "__main__":
    sys.exit(main())
