"""Behaviour cloning from the whole scene, in tasks whose fixed objects are placed at random.

    python benchmarks/whole_scene.py [--only press_button] [--folder runs/whole_scene]

The buttons, the shelf, the coaster or the plate of these tasks are known only from the channels of
fixed objects that the whole scene contains. Each task has 100 demonstrations, 3,000 updates and 60
episodes of evaluation: once from the whole scene, and once from what the task file lists. On one
core, a task takes about ten minutes. Collects and trains what is not there yet, and writes
benchmarks/results/whole_scene.json.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from machine import describe_machine

TASKS = (
    *("press_button", "two_buttons", "buttons_in_order", "button_hatch", "cup_handover"),
    *("relay_line", "pusher_and_picker"),
)
DEMOS, UPDATES, EPISODES = 100, 3_000, 60
FIRST_DEMO, FIRST_EPISODE = 100_000, 2_000_000
RESULTS = Path(__file__).parent / "results" / "whole_scene.json"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=TASKS, choices=TASKS, metavar="TASK")
    parser.add_argument("--folder", type=Path, default=Path("runs/whole_scene"), help="of the runs")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    known = json.loads(RESULTS.read_text())["runs"] if RESULTS.exists() else []
    runs = {(run["task"], run["observe"]): run for run in known}
    for task in arguments.only:
        for observe in ("scene", "task"):
            runs[task, observe] = run(task, observe, arguments.folder)
            print(task, observe, runs[task, observe]["successes"], flush=True)
        order = [runs[key] for task in TASKS for key in runs if key[0] == task]
        about = {"command": "python benchmarks/whole_scene.py", "machine": describe_machine()}
        RESULTS.write_text(json.dumps({**about, "runs": order}, indent=1) + "\n")
    return 0


def run(task: str, observe: str, folder: Path) -> dict[str, Any]:
    """Collect, train and evaluate, as far as this has not been done."""
    data, out = folder / "data" / task, folder / f"{task}-{observe}"
    collect = ["collect", task, "--episodes", str(DEMOS), "--observe", "scene"]
    collect += ["--seed", str(FIRST_DEMO), "--jobs", "1", "--out", str(data)]
    train = ["train", "--algorithm", "bc", "--data", str(data), "--observe", observe]
    train += ["--seed", "1", "--steps", str(UPDATES), "--evaluate-every", str(UPDATES)]
    train += ["--evaluate-episodes", "1", "--film-every", "0", "--out", str(out)]
    evaluate = ["evaluate", str(out), "--seed", str(FIRST_EPISODE), "--episodes", str(EPISODES)]
    evaluate += ["--controls", "0", "--jobs", "1", "--json"]
    taskbuilder(*collect)
    if not (out / "policy.npz").exists():
        taskbuilder(*train)
    played = json.loads(taskbuilder(*evaluate))
    return {
        "task": task,
        "observe": observe,
        "demonstrations": DEMOS,
        "updates": UPDATES,
        "episodes": EPISODES,
        "successes": round(played["success_rate"] * EPISODES),
        "commands": [" ".join(["taskbuilder", *words]) for words in (collect, train, evaluate)],
    }


def taskbuilder(*words: str) -> str:
    """Run a command, and return what it prints."""
    command = [sys.executable, "-m", "taskbuilder", *words]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise SystemExit(f"taskbuilder {' '.join(words)}\n{ran.stderr}")
    return ran.stdout


if __name__ == "__main__":
    sys.exit(main())
