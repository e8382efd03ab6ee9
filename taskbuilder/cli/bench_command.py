"""`taskbuilder bench`."""

from __future__ import annotations

import argparse
import time
from typing import Any

from taskbuilder.bench import (
    StepCost,
    as_data,
    measure_images,
    measure_resets,
    measure_steps,
    peak_memory_mb,
    renderers,
)
from taskbuilder.cli.output import paint, print_json, print_table
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.env.vector import make_vec
from taskbuilder.task import Task, load_task

SCALING_STEPS = 300
ENVS_PER_WORKER = 4


def run(arguments: argparse.Namespace) -> int:
    """Measure what an environment costs, and print it beside the floor."""
    task = load_task(arguments.task, catalogue=catalogue_of(arguments))
    cost = measure_steps(task, episodes=arguments.episodes)
    figures: dict[str, Any] = {
        "task": task.name,
        **as_data(cost),
        "reset_ms": measure_resets(task),
        "images_per_second": {name: measure_images(task, name) for name in renderers()},
        "workers": _scaling(task, arguments.workers),
        "peak_memory_mb": peak_memory_mb(),
    }
    if arguments.json:
        print_json(figures)
    else:
        _print(figures, cost)
    return 0


def _scaling(task: Task, most: int) -> dict[str, float]:
    """Control steps a second of all environments together, by number of workers."""
    rates = {}
    for workers in range(1, most + 1):
        env = make_vec(task, ENVS_PER_WORKER * workers, workers=workers)
        try:
            env.reset(seed=0)
            env.action_space.seed(0)
            actions = env.action_space.sample()
            env.step(actions)
            started = time.perf_counter()
            for _ in range(SCALING_STEPS):
                env.step(actions)
            rates[str(workers)] = SCALING_STEPS * env.num_envs / (time.perf_counter() - started)
        finally:
            env.close()
    return rates


def _beyond(steps: float, unit: str) -> str:
    """A difference of two times, which other work on the machine can make negative."""
    return f"{steps:.1f} {unit}" if steps >= 0.05 else "nothing measurable"


def _print(figures: dict[str, Any], cost: StepCost) -> None:
    print(paint(f"{figures['task']} · {cost.substeps} physics steps a control step", "bold"))
    print()
    rows = [
        ["control steps", f"{cost.steps_per_second:,.0f} a second"],
        ["simulated time", f"{cost.real_time_factor:,.0f} s a second of one core"],
        ["physics step alone", f"{cost.physics_step_us:.0f} µs"],
        ["control step", f"{cost.control_step_us:.0f} µs, {cost.overhead:.2f} × its physics"],
        ["  beyond its physics", _beyond(cost.overhead_physics_steps, "physics steps")],
        ["physics step at rest", f"{cost.rest_step_us:.0f} µs"],
        ["  beyond a loop of them", _beyond(cost.overhead_rest_steps, "physics steps at rest")],
        ["reset", f"{figures['reset_ms']:.2f} ms"],
    ]
    for renderer, rates in figures["images_per_second"].items():
        rows += [[f"{size}, {renderer}", f"{rate:.1f} images/s"] for size, rate in rates.items()]
    first = figures["workers"].get("1")
    for workers, rate in figures["workers"].items():
        times = f", {rate / first:.2f} × one" if workers != "1" else ""
        rows.append([f"{workers} worker{'s' * (workers != '1')}", f"{rate:,.0f} steps/s{times}"])
    rows.append(["peak memory", f"{figures['peak_memory_mb']:.0f} MB"])
    print_table(rows, indent="  ")
