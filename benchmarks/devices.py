"""Whether training works on a GPU, and what it gains: the same short runs on the CPU and on CUDA.

    python benchmarks/devices.py

trains each learner that takes a device on the Handover, with small and with large networks, on both
devices, one run at a time; each policy is then loaded on the CPU and plays two episodes. Writes
benchmarks/results/devices.json.

The control steps a second are the median of the run's own rows after the warm-up. They contain the
physics, which is always the CPU's.
"""

from __future__ import annotations

import argparse
import csv
import json
import tempfile
from pathlib import Path
from statistics import median
from typing import Any

import torch
from machine import describe_machine

from taskbuilder.learn import evaluate, load_policy, train

RESULTS = Path(__file__).parent / "results"
LEARNERS: dict[str, dict[str, Any]] = {
    "maddpg, 128 x 128, batch 128": {"algorithm": "maddpg", "steps": 6000},
    "maddpg, 512 x 512, batch 1,024": {
        "algorithm": "maddpg",
        "steps": 4000,
        "settings": {"hidden": (512, 512), "batch": 1024},
    },
    "ppo, 64 x 64": {"algorithm": "ppo", "envs": 8, "steps": 16_000},
    "ppo, 512 x 512": {
        "algorithm": "ppo",
        "envs": 8,
        "steps": 16_000,
        "settings": {"hidden": (512, 512)},
    },
}


def measure(options: dict[str, Any], device: str) -> dict[str, float]:
    """Train and play; gives control steps a second and the policy's return."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        steps = options["steps"]
        every = {"evaluate_every": steps, "evaluate_episodes": 1, "checkpoint_every": steps}
        train("handover", device=device, seed=0, out=out, **every, **options)
        with (out / "updates.csv").open(encoding="utf-8", newline="") as lines:
            speeds = [float(row["steps_per_second"]) for row in csv.DictReader(lines)]
        played = evaluate(load_policy(str(out)), episodes=2, jobs=1)
    return {"steps_per_second": round(median(speeds[1:]), 1), "return": played.mean_return}


def main() -> None:
    """Measure what this machine has."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=RESULTS / "devices.json")
    asked = parser.parse_args()
    devices = {"cpu": "cpu"}
    if torch.cuda.is_available():
        devices["cuda"] = torch.cuda.get_device_name()
    found: dict[str, Any] = {}
    for learner, options in LEARNERS.items():
        found[learner] = {device: measure(options, device) for device in devices}
        print(learner, found[learner], flush=True)
    about = {"machine": describe_machine() | {"torch": torch.__version__}, "devices": devices}
    text = json.dumps(about | {"learners": found}, indent=2)
    asked.out.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
