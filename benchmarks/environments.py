"""What the environments of all tasks cost: `taskbuilder bench` over the catalogue, as data.

    python benchmarks/environments.py

prints a table and writes benchmarks/results/environments.json.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from machine import describe_machine

from taskbuilder import catalogue, load_task
from taskbuilder.bench import as_data, measure_steps

RESULTS = Path(__file__).parent / "results" / "environments.json"


def bench(task: str) -> dict[str, Any]:
    """What `taskbuilder bench` says of a task, in a process of its own."""
    words = ["bench", task, "--json"]
    command = [
        sys.executable,
        "-c",
        "import sys; from taskbuilder.cli import main; sys.exit(main())",
    ]
    done = subprocess.run([*command, *words], check=True, capture_output=True, text=True)
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


def with_joint_actions(name: str) -> dict[str, float]:
    """The cost of a step where every arm is commanded by joint increments."""
    task = load_task(name)
    scene = task.file.scenes[0]
    robots = {
        robot: entry.model_copy(
            update={"action": entry.action.model_copy(update={"arm": "joint_delta"})}
        )
        for robot, entry in scene.robots.items()
    }
    changed = scene.model_copy(update={"robots": robots})
    file = replace(task.file, scenes=(changed,))
    return as_data(measure_steps(replace(task, file=file)))


def main() -> None:
    """Measure, print and write."""
    tasks = {
        name: {**bench(name), "joint_delta": with_joint_actions(name)} for name in catalogue().tasks
    }
    RESULTS.write_text(json.dumps({"machine": describe_machine(), "tasks": tasks}, indent=2) + "\n")
    for name, found in tasks.items():
        print(
            f"{name:20} {found['real_time_factor']:5.0f} x real time, "
            f"{found['overhead_physics_steps']:.1f} physics steps beyond its own with tcp_delta, "
            f"{found['joint_delta']['overhead_physics_steps']:.1f} with joint_delta "
            f"(beyond a loop at rest: {found['overhead_rest_steps']:.1f} and "
            f"{found['joint_delta']['overhead_rest_steps']:.1f}), "
            f"reset {found['reset_ms']:.2f} ms"
        )


if __name__ == "__main__":
    main()
