"""Training that is killed at random moments, and goes on.

    python benchmarks/kills.py [--kills 50] [--runs 10]

Tiny networks learn the task handover in `--runs` runs with seeds of their own; meanwhile their
processes are killed (SIGKILL) `--kills` times in all, at moments drawn evenly over the time that a
run takes, saves included, and started again with `taskbuilder train --resume`. At the end each
must have the weights, the tables and the policy of a run that was never killed, to the bit.

Writes benchmarks/results/kills.json where it is run in full.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe_machine
from tqdm import tqdm

from taskbuilder.arrays import read_arrays
from taskbuilder.policies.zoo import load_policy

RESULTS = Path(__file__).parent / "results" / "kills.json"

KILLS, RUNS = 50, 10
STEPS = 1_200
TRAIN = (sys.executable, "-m", "taskbuilder", "train")
PLAN = (
    *("handover", "--steps", str(STEPS), "--envs", "2"),
    *("--evaluate-every", "600", "--evaluate-episodes", "1", "--checkpoint-every", "120"),
    *("--set", "hidden=[8,8]", "batch=16", "warm_up=60"),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=KILLS)
    parser.add_argument("--runs", type=int, default=RUNS)
    arguments = parser.parse_args()
    rng = np.random.default_rng(0)
    parts = np.array_split(np.arange(arguments.kills), arguments.runs)
    with tempfile.TemporaryDirectory() as folder:
        runs = [
            torment(Path(folder), seed, len(part), rng)
            for seed, part in enumerate(tqdm(parts, desc="runs", disable=None))
        ]
    kills = sum(run["kills"] for run in runs)
    equal = sum(run["equal"] for run in runs)
    print(f"{kills} kills in {len(runs)} runs; {equal} of {len(runs)} equal to the bit")
    if (arguments.kills, arguments.runs) == (KILLS, RUNS):
        data = {"command": "python benchmarks/kills.py", "machine": describe_machine()}
        RESULTS.write_text(json.dumps({**data, "steps": STEPS, "runs": runs}, indent=2) + "\n")
    return 0 if equal == len(runs) and kills == arguments.kills else 1


def torment(folder: Path, seed: int, kills: int, rng: np.random.Generator) -> dict[str, Any]:
    """Train twice with one seed, once in peace and once under fire; compare."""
    whole, killed = folder / f"whole-{seed}", folder / f"killed-{seed}"
    started = time.monotonic()
    subprocess.run([*TRAIN, *PLAN, "--seed", str(seed), "--out", str(whole)], **QUIET, check=True)
    seconds = time.monotonic() - started
    struck, moments = 0, []
    first = command = [*TRAIN, *PLAN, "--seed", str(seed), "--out", str(killed)]
    while True:
        with subprocess.Popen(command, **QUIET) as child:
            if struck == kills:
                assert child.wait() == 0, f"the run with seed {seed} could not be resumed"
                break
            wait = float(rng.uniform(0.0, seconds))
            try:
                child.wait(wait)
            except subprocess.TimeoutExpired:
                child.kill()
                struck += 1
                moments.append({"after_s": round(wait, 2), "step": newest_step(killed)})
        if child.returncode == 0:  # done before it could be struck: once more from the start
            shutil.rmtree(killed)
        began = (killed / "run.json").exists()
        command = [*TRAIN, "--resume", str(killed)] if began else first
    return {"seed": seed, "kills": struck, "moments": moments, "equal": same(whole, killed)}


QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def newest_step(folder: Path) -> int:
    """The step of the newest checkpoint; 0 for none."""
    return max(
        (int(p.stem.removeprefix("step-")) for p in folder.glob("checkpoints/step-*")), default=0
    )


def same(one: Path, other: Path) -> bool:
    """Whether two runs ended with the same weights, policy and tables."""
    name = f"checkpoints/step-{STEPS:09d}.npz"
    first, second = (read_arrays(folder / name, "checkpoint")[0] for folder in (one, other))
    policies = [load_policy(str(folder)).arrays() for folder in (one, other)]
    tables = ("episodes.csv", "evaluations.csv")
    return (
        equal(first, second)
        and equal(*policies)
        and all((one / table).read_bytes() == (other / table).read_bytes() for table in tables)
    )


def equal(one: dict[str, Any], other: dict[str, Any]) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[k], other[k]) for k in one)


if __name__ == "__main__":
    sys.exit(main())
