"""Training speed, beside the speed of the simulation alone.

    python benchmarks/pace.py [--steps 4000] [--repeats 3] [--workers 1 2]

Trains Handover from scratch in three ways:

- as shipped: with the settings of the preset `scratch`;
- one update a step: with scalar critics and actors without layer norm, as in earlier presets;
- collecting alone: the policy acts and transitions are stored, but no network is updated.

The updates run in one thread, beside the worker processes that simulate. For each way, the result
is that of the number of workers with which it is fastest. The ways take turns, so that other load
on the machine affects all of them alike. Writes benchmarks/results/pace.json.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from typing import Any

from machine import describe_machine

from taskbuilder.learn.checkpoint_evaluator import Evaluation
from taskbuilder.learn.plan import make_plan
from taskbuilder.learn.training import TrainingStatus, train
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.task import load_task

RESULTS = Path(__file__).parent / "results" / "pace.json"
WARM_UP = 500
WAYS: dict[str, dict[str, Any]] = {
    "as shipped": {},
    "one update a step": {"update_every": 1.0, "value_bins": 0, "actor_norms": False},
    "collecting alone": {"update_every": 1e9},
}
"""Changes to the settings of the preset, by way of training."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=4_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    arguments = parser.parse_args()
    ways = [(name, workers) for name in WAYS for workers in arguments.workers]
    paces: dict[tuple[str, int], list[float]] = {way: [] for way in ways}
    for _ in range(arguments.repeats):
        for name, workers in ways:
            steps_per_second = pace(arguments.steps, workers, WAYS[name])
            paces[name, workers].append(round(steps_per_second, 1))
            print(f"{label(name, workers)}: {steps_per_second:.0f} steps/s", flush=True)
    best = {
        name: max((median(paces[way]), way[1]) for way in ways if way[0] == name) for name in WAYS
    }
    data = {
        "command": shlex.join(["python", "benchmarks/pace.py", *sys.argv[1:]]),
        "machine": describe_machine(),
        "control_steps_per_second": {name: round(value, 1) for name, (value, _) in best.items()},
        "workers": {name: workers for name, (_, workers) in best.items()},
        "repeats": {label(*way): values for way, values in paces.items()},
    }
    RESULTS.write_text(json.dumps(data, indent=2) + "\n")
    return 0


def label(name: str, workers: int) -> str:
    """A way to go, in words."""
    return f"{name}, {workers} worker{'s' * (workers > 1)}"


def pace(steps: int, workers: int, settings: Mapping[str, Any]) -> float:
    """Control steps a second after warming up."""
    plan = make_plan(
        "handover",
        steps=WARM_UP + steps,
        envs=4,
        workers=workers,
        observe="scene",
        evaluate_every=10**9,
        checkpoint_every=10**9,
        settings={"warm_up": WARM_UP, **settings},
    )
    at: dict[int, float] = {}

    def watch(status: TrainingStatus) -> None:
        at.setdefault(status.step, time.perf_counter())

    with tempfile.TemporaryDirectory() as folder:
        train(plan, load_task("handover"), Path(folder), _nothing, {}, watch)
    # The first update follows the preparations, which are not of the pace.
    first, last = WARM_UP + 2 * plan.envs, WARM_UP + steps
    return (last - first) / (at[last] - at[first])


def _nothing(policy: TrainedPolicy) -> Evaluation:
    """No evaluation."""
    del policy
    return Evaluation(0.0, {})


if __name__ == "__main__":
    sys.exit(main())
