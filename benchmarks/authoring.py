"""How long authoring takes: commands, building, resetting, stills.

    python benchmarks/authoring.py

prints a table and writes benchmarks/results/authoring.json. Process time is user plus system time
of the whole process, from outside; the median of several runs after one that is not counted.
"""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from machine import describe_machine

from taskbuilder import build_world, catalogue, load_task
from taskbuilder.visual.still import take_still

RESULTS = Path(__file__).parent / "results" / "authoring.json"
RUNS = 9

LIMITS = {
    "help_process_s": 0.3,
    "validate_static_process_s": 0.6,
    "build_s": 0.5,
    "reset_ms": 5.0,
    "still_s": 1.5,
}


def process_seconds(*words: str) -> float:
    """Median user plus system time of `taskbuilder WORDS`."""
    command = [sys.executable, "-c", "from taskbuilder.cli import main; main()", *words]
    times = []
    for run in range(RUNS + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if run:
            times.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return statistics.median(times)


def median_seconds(action: Callable[[], object], runs: int = RUNS) -> float:
    """Median wall time of a call."""
    times = []
    for run in range(runs + 1):
        started = time.perf_counter()
        action()
        if run:
            times.append(time.perf_counter() - started)
    return statistics.median(times)


def measure_task(name: str) -> dict[str, float]:
    """Build, reset and still of one task."""
    task = load_task(name)
    build_s = median_seconds(lambda: build_world(task.file).close())
    world = build_world(task.file)
    seeds = iter(range(1_000_000))
    reset_s = median_seconds(lambda: world.reset(next(seeds)), runs=200)
    still_s = median_seconds(lambda: take_still(world, "front", (640, 480)), runs=5)
    world.close()
    return {"build_s": build_s, "reset_ms": reset_s * 1000.0, "still_s": still_s}


def main() -> None:
    """Measure, print and write."""
    commands = {
        "help_process_s": process_seconds("--help"),
        "validate_static_process_s": process_seconds("validate", "handover", "--level", "static"),
    }
    tasks = {name: measure_task(name) for name in catalogue().tasks}
    result = {"machine": describe_machine(), "limits": LIMITS, **commands, "tasks": tasks}
    RESULTS.write_text(json.dumps(result, indent=2) + "\n")
    rows = [(name, "", value) for name, value in commands.items()]
    rows += [
        (key, name, value) for name, figures in tasks.items() for key, value in figures.items()
    ]
    for key, name, value in rows:
        verdict = "ok" if value <= LIMITS[key] else "over"
        print(f"{key:28} {name:20} {value:8.3f}  limit {LIMITS[key]:g}  {verdict}")


if __name__ == "__main__":
    main()
