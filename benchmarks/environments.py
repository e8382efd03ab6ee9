"""What the environments of all tasks cost: `taskbuilder bench` over the catalogue, as data.

    python benchmarks/environments.py

prints a table and writes benchmarks/results/environments.json.

    python benchmarks/environments.py forces

measures anew only what metering the force between robots costs, and keeps the rest of that file.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from machine import describe_machine

from taskbuilder import catalogue, load_task
from taskbuilder.bench import as_data, measure_steps
from taskbuilder.world.building import build_world

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


def forces(name: str, steps: int = 100, rounds: int = 5) -> dict[str, float]:
    """How long a control step of a task's world takes, with and without a watched pair.

    In turns, so that both see the machine alike; the least of each counts, as noise only adds.
    """
    world = build_world(load_task(name).file)
    world.reset(0)
    moment = world.save()
    taken: dict[str, list[float]] = {"unwatched": [], "watched": []}
    for _ in range(rounds):
        for what, pairs in (("unwatched", ()), ("watched", (("left", "right"),))):
            world.watch_forces(pairs)
            world.restore(moment)
            times = []
            for _ in range(steps):
                started = time.perf_counter()
                world.step()
                times.append(time.perf_counter() - started)
            taken[what].append(min(times) * 1e6)
    world.close()
    least = {f"{what}_us": min(times) for what, times in taken.items()}
    return {**least, "share": least["watched_us"] / least["unwatched_us"] - 1.0}


def write(data: dict[str, Any]) -> None:
    """Write the results."""
    RESULTS.write_text(json.dumps(data, indent=2) + "\n")


def main() -> None:
    """Measure, print and write."""
    metered = {
        "machine": describe_machine(),
        "what": "a control step of the world alone, arms at rest; the least of 500",
        "tasks": {name: forces(name) for name in catalogue().tasks},
    }
    for name, found in metered["tasks"].items():
        print(
            f"{name:20} {found['unwatched_us']:.0f} us a control step, {found['watched_us']:.0f} "
            f"with the force between the robots metered ({found['share']:+.1%})"
        )
    if sys.argv[1:] == ["forces"]:
        write({**json.loads(RESULTS.read_text()), "forces": metered})
        return
    tasks = {
        name: {**bench(name), "joint_delta": with_joint_actions(name)} for name in catalogue().tasks
    }
    write({"machine": describe_machine(), "tasks": tasks, "forces": metered})
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
