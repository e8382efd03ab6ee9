"""Steps, pictures and training of this checkout beside those of an earlier one, in turns.

    git worktree add /tmp/earlier d39ca4ce
    python benchmarks/paces.py --before /tmp/earlier [--rounds 5] [--steps 1500]

One program, which uses what both checkouts offer, is run with the modules of either, each time in a
process of its own. It measures CPU time: of control steps with random actions on six tasks, of
control steps of the handover's expert, of pictures of 128 x 128 that the rasteriser draws, and of
training Handover with MADDPG. Starting to train takes in the first 600 steps, 500 of them to warm
up; training is what more steps take. Medians over the rounds go to benchmarks/results/paces.json,
each with its smallest and largest value.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

from machine import describe_machine
from proof_times import revision
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "benchmarks" / "results" / "paces.json"

PROGRAM = """
import contextlib, io, json, os, sys, tempfile, time
import numpy as np
import taskbuilder
from taskbuilder.cli import main

def spent():  # by this process, and by those that it has started and waited for
    return sum(os.times()[:4])

def step_us(task, **options):
    env = taskbuilder.parallel_env(task, horizon=10_000, **options)
    rng, seconds = np.random.default_rng(0), []
    for seed in range(4):
        env.reset(seed=seed)
        for _ in range(60):
            shapes = {agent: env.action_space(agent).shape for agent in env.agents}
            actions = {
                agent: rng.uniform(-1, 1, shape).astype(np.float32)
                for agent, shape in shapes.items()
            }
            begun = time.process_time()
            env.step(actions)
            seconds.append(time.process_time() - begun)
    env.close()
    return 1e6 * float(np.mean(seconds[60:]))

def expert_step_us():
    env = taskbuilder.parallel_env("handover")
    expert = taskbuilder.Expert(env)
    taskbuilder.play(env, expert, seed=0)
    begun = time.process_time()
    steps = sum(taskbuilder.play(env, expert, seed=seed).steps for seed in range(1, 9))
    seconds = time.process_time() - begun
    expert.close()
    env.close()
    return 1e6 * seconds / steps

def training_s(steps):
    begun = spent()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        words = f"train handover --envs 4 --workers 1 --seed 11 --steps {steps} --film-every 0"
        words += f" --evaluate-every 1000000 --checkpoint-every 1000000 --out {folder}/run"
        if main([*words.split(), "--set", "warm_up=500"]):
            raise SystemExit("training failed")
    return spent() - begun

tasks = ("reach", "pick_push_place", "collaborative_lift", "handover", "relay_line", "ring_pass")
figures = {f"control step of {task}, us": step_us(task) for task in tasks}
figures["control step of the handover's expert, us"] = expert_step_us()
two = {"renderer": "raster", "cameras": ("front", "left_wrist"), "camera_size": (128, 128)}
figures["control step of handover with two pictures, us"] = step_us("handover", **two)
start, most = 600, 600 + int(sys.argv[1])
figures["starting to train, s"] = training_s(start)
figures[f"training for {sys.argv[1]} control steps, s"] = (
    training_s(most) - figures["starting to train, s"]
)
print(json.dumps(figures))
"""


def measured(checkout: Path, steps: int) -> dict[str, float]:
    """Run the program with the modules of a checkout."""
    alone = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PROGRAM, str(steps)],
        cwd=checkout,
        env={**os.environ, **alone, "PYTHONPATH": str(checkout)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    figures: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return figures


def summary(values: list[float]) -> dict[str, float]:
    """The median of values, the smallest and the largest."""
    return {
        "median": round(statistics.median(values), 1),
        "least": round(min(values), 1),
        "most": round(max(values), 1),
    }


def main() -> None:
    """Measure both checkouts in turns, and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--before", type=Path, required=True, help="the earlier checkout")
    parser.add_argument("--rounds", type=int, default=5, help="measurements of each checkout")
    parser.add_argument("--steps", type=int, default=1_000, help="control steps of training")
    asked = parser.parse_args()
    checkouts = {"before": asked.before.resolve(), "now": ROOT}
    rounds: dict[str, list[dict[str, float]]] = {name: [] for name in checkouts}
    for number in tqdm(range(asked.rounds), desc="rounds"):
        order = list(checkouts) if number % 2 == 0 else list(reversed(checkouts))
        for name in order:  # neither always comes first
            rounds[name].append(measured(checkouts[name], asked.steps))
    figures: dict[str, dict[str, Any]] = {
        figure: {name: summary([each[figure] for each in rounds[name]]) for name in checkouts}
        for figure in rounds["now"][0]
    }
    data = {
        "command": f"python benchmarks/paces.py --before EARLIER --rounds {asked.rounds}",
        "before": revision(checkouts["before"]),
        "machine": describe_machine(),
        "figures": figures,
    }
    OUT.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    for figure, sides in figures.items():
        before, now = (sides[name]["median"] for name in checkouts)
        print(f"{figure:52} {before:9.1f} {now:9.1f} {now / before - 1.0:+7.1%}")


if __name__ == "__main__":
    main()
