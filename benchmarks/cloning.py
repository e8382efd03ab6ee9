"""Behaviour cloning from 200 demonstrations: three tasks, from states and from pictures, two seeds.

    python benchmarks/cloning.py [--only handover/states] [--seeds 1 2] [--device cuda] [--jobs 2]

Collects what is not collected yet, trains what is not trained yet, goes on with what was stopped,
plays each policy in 300 episodes that neither training nor the choice of a policy has seen, and
writes

- benchmarks/results/cloning.csv.gz: every episode of every run, and
- benchmarks/results/cloning.json: what came of each run, with the commands that make it again.

On one core, a run from states takes minutes and one from pictures about half an hour.
Nothing is left out: a run that failed is there as it is, and so are runs with pictures of another
`--size` than the task's own. `--demos`, `--states`, `--pictures` and `--episodes` change how much
is done, to try this program quickly. `--publish` puts the policies that observe pictures into the
zoo, for each task that of the median seed: of two, the one that succeeds less.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import io
import json
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

from machine import describe_machine
from training_runs import copy_plan

TASKS = ("pick_push_place", "collaborative_lift", "handover")
INPUTS = ("states", "pictures")
CAMERAS = "front,top"
RUNS = tuple(f"{task}/{inputs}" for task, inputs in product(TASKS, INPUTS))
SIZES = {"pick_push_place": 64, "collaborative_lift": 96, "handover": 64}
"""Of pictures: the goal of Collaborative Lift, a ball of 5 cm, is two pixels wide at 64."""
FIRST_DEMO, FIRST_EPISODE = 100_000, 2_000_000
TASKBUILDER = (sys.executable, "-m", "taskbuilder")
ZOO = Path(__file__).parents[1] / "taskbuilder" / "policies" / "models"
TRACK = "visuomotor"
EVALUATION, COMMANDS = "evaluation.json", "commands.json"


def main() -> int:
    arguments = parse()
    for task in TASKS:
        if any(name.startswith(f"{task}/") for name in arguments.only):
            collect(task, arguments)
    wanted = [(name, seed) for seed in arguments.seeds for name in arguments.only]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for line in pool.map(partial(run, arguments=arguments), wanted):
            print(line, flush=True)
    write(arguments)
    if arguments.publish:
        for name in arguments.only:
            publish(name, arguments)
    return 0


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=RUNS, choices=RUNS, metavar="TASK/INPUTS")
    parser.add_argument("--seeds", nargs="+", type=int, default=(1, 2))
    parser.add_argument("--device", default="cpu", help="device of the networks: cpu or cuda")
    parser.add_argument("--jobs", type=int, default=1, help="runs at once")
    parser.add_argument("--demos", type=int, default=200, help="demonstrations of each task")
    parser.add_argument("--size", type=int, help="size of the pictures (default the task's)")
    parser.add_argument("--states", type=int, default=5_000, help="updates from states")
    parser.add_argument("--pictures", type=int, default=15_000, help="updates from pictures")
    parser.add_argument("--episodes", type=int, default=300, help="episodes of each evaluation")
    parser.add_argument("--set", nargs="+", default=(), metavar="K=V", help="settings of bc")
    parser.add_argument("--publish", action="store_true", help="put policies into the zoo")
    parser.add_argument("--folder", type=Path, default=Path("runs/cloning"), help="of the runs")
    parser.add_argument("--results", type=Path, default=Path(__file__).parent / "results")
    return parser.parse_args()


def taskbuilder(*words: str, log: Path | None = None) -> str:
    """Run a command, append what it says to a log, and return what it prints."""
    ran = subprocess.run([*TASKBUILDER, *words], capture_output=True, text=True, check=False)
    if log is not None:
        with log.open("a") as file:
            file.write(ran.stdout + ran.stderr)
    if ran.returncode:
        raise SystemExit(f"taskbuilder {' '.join(words)}\n{ran.stderr}")
    return ran.stdout


def collect(task: str, arguments: argparse.Namespace) -> None:
    """Collect the demonstrations of a task, or what is missing of them."""
    folder = data_of(task, arguments)
    folder.parent.mkdir(parents=True, exist_ok=True)
    pictures = ("--cameras", CAMERAS, "--size", str(arguments.size or SIZES[task]))
    seeds = ("--episodes", str(arguments.demos), "--seed", str(FIRST_DEMO))
    taskbuilder("collect", task, *seeds, "--observe", "scene", *pictures, "--out", str(folder))


def run(wanted: tuple[str, int], arguments: argparse.Namespace) -> str:
    """Train and evaluate one run, as far as this has not been done; say what came of it."""
    name, seed = wanted
    out, folder = folder_of(name, seed, arguments), arguments.folder
    if not (out / EVALUATION).exists():
        train = train_command(name, seed, arguments)
        again = ["train", "--resume", str(out)] if (out / "run.json").exists() else train
        taskbuilder(*again, log=folder / f"{out.name}.log")
        first, count = str(FIRST_EPISODE), str(arguments.episodes)
        evaluate = ["evaluate", str(out), "--seed", first, "--episodes", count]
        played = taskbuilder(*evaluate, "--controls", "0", "--jobs", "1", "--json")
        commands = [" ".join(["taskbuilder", *words]) for words in (train, evaluate)]
        (out / COMMANDS).write_text(json.dumps(commands))
        (out / EVALUATION).write_text(played)
    result = json.loads((out / EVALUATION).read_text())
    return f"{out.name}: {result['success_rate']:.1%} of {result_episodes(result)} episodes"


def data_of(task: str, arguments: argparse.Namespace) -> Path:
    """Where the demonstrations are."""
    size = arguments.size or SIZES[task]
    name = task if size == SIZES[task] else f"{task}-{size}"
    return Path(arguments.folder) / "data" / name


def folder_of(name: str, seed: int, arguments: argparse.Namespace) -> Path:
    """Where a run is."""
    task, inputs = name.split("/")
    size = arguments.size or SIZES[task]
    other = "" if inputs == "states" or size == SIZES[task] else str(size)
    return Path(arguments.folder) / f"{task}-{inputs}{other}-{seed}"


def train_command(name: str, seed: int, arguments: argparse.Namespace) -> list[str]:
    """What trains a run from the beginning."""
    task, inputs = name.split("/")
    steps = getattr(arguments, inputs)
    every = str(max(steps // 5, 1))
    words = ["train", "--algorithm", "bc", "--data", str(data_of(task, arguments))]
    words += ["--cameras", CAMERAS] if inputs == "pictures" else []
    words += ["--seed", str(seed), "--steps", str(steps), "--device", arguments.device]
    words += ["--evaluate-every", every, "--checkpoint-every", every]
    words += ["--set", *arguments.set] if arguments.set else []
    return [*words, "--out", str(folder_of(name, seed, arguments))]


def result_episodes(result: dict[str, Any]) -> int:
    return len(result["episodes"])


def write(arguments: argparse.Namespace) -> None:
    """Write the results of all runs so far."""
    runs, rows = [], []
    for out in sorted(arguments.folder.glob(f"*/{EVALUATION}"), key=place):
        task, inputs, size, seed = parts_of(out := out.parent)
        result = json.loads((out / EVALUATION).read_text())
        runs.append(
            {
                "task": task,
                "inputs": inputs,
                **({"picture_size": size} if inputs == "pictures" else {}),
                "seed": seed,
                "demonstrations": arguments.demos,
                "updates": result["about"]["step"],
                "minutes": minutes(out),
                "episodes": result_episodes(result),
                **{key: result[key] for key in ("success_rate", "interval", "stages")},
                "commands": json.loads((out / COMMANDS).read_text()),
            }
        )
        about = (task, inputs, size if inputs == "pictures" else "", seed)
        rows += [[*about, p["seed"], int(p["success"])] for p in result["episodes"]]
    arguments.results.mkdir(parents=True, exist_ok=True)
    lines = io.StringIO()
    writer = csv.writer(lines, lineterminator="\n")
    writer.writerow(["task", "inputs", "picture_size", "seed", "episode_seed", "success"])
    writer.writerows(rows)
    packed = gzip.compress(lines.getvalue().encode(), mtime=0)
    (arguments.results / "cloning.csv.gz").write_bytes(packed)
    data = {
        "command": shlex.join(["python", "benchmarks/cloning.py", *sys.argv[1:]]),
        "machine": describe_machine(),
        "device": arguments.device,
        "runs": runs,
    }
    (arguments.results / "cloning.json").write_text(json.dumps(data, indent=2) + "\n")


def parts_of(out: Path) -> tuple[str, str, int, int]:
    """Task, inputs, size of pictures and seed of a run, from the name of its folder."""
    task, what, seed = out.name.split("-")
    inputs = "states" if what == "states" else "pictures"
    return task, inputs, int(what.removeprefix(inputs) or SIZES[task]), int(seed)


def place(file: Path) -> tuple[int, bool, int, int]:
    """Where a run stands among the others."""
    task, inputs, size, seed = parts_of(file.parent)
    return TASKS.index(task), inputs == "pictures", size, seed


def publish(name: str, arguments: argparse.Namespace) -> None:
    """Put the policy of the median seed into the zoo, with its plan and its curve."""
    runs = [folder_of(name, seed, arguments) for seed in arguments.seeds]
    runs.sort(key=lambda run: json.loads((run / EVALUATION).read_text())["success_rate"])
    median = runs[(len(runs) - 1) // 2]
    task, inputs = name.split("/")
    if inputs == "pictures":
        keep(median, ZOO / task / TRACK)


def keep(median: Path, kept: Path) -> None:
    """Copy a policy, its plan and its curve into the zoo."""
    shutil.copyfile(median / "policy.npz", kept.with_suffix(".npz"))
    shutil.copyfile(median / "evaluations.csv", kept.with_suffix(".csv"))
    copy_plan(median, kept.with_suffix(".json"))


def minutes(out: Path) -> float | None:
    """How long a run took, with its evaluations, if it is long enough to say so."""
    file = out / "updates.csv"
    if not file.exists():
        return None
    with file.open(newline="") as lines:
        *_, last = csv.DictReader(lines)
    return round(float(last["seconds"]) / 60.0, 1)


if __name__ == "__main__":
    sys.exit(main())
