"""At which physics rates frictional grasps hold: success and slip of the scripted episodes.

    python benchmarks/physics_hz.py

plays every task by script at several rates, prints a table, and writes
benchmarks/results/physics_hz.json. Slip is how far a held thing moves in a gripper that is told to
hold it, from the first control step at which it does.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "tasks"))

from machine import describe_machine
from plays import PLAYS
from scripted import Script

from taskbuilder import build_world, load_task
from taskbuilder.description.description import Outcome
from taskbuilder.geometry import Pose, Vec3

RESULTS = Path(__file__).parent / "results" / "physics_hz.json"
RATES = (40, 60, 120, 240)
HELD = {"handover": "stick", "pick_push_place": "cube", "collaborative_lift": "tray"}


class Watched(Script):
    """A script that measures how far what is held moves in each gripper."""

    def __init__(self, task: Any, world: Any, seed: int) -> None:
        super().__init__(task, world, seed)
        self.thing = HELD[task.name]
        self.taken: dict[str, Vec3] = {}
        self.slip = 0.0

    def step(self, poses: Any) -> Outcome:
        """Step, and look at every gripper."""
        outcome = super().step(poses)
        world = self.world
        for robot in world.robot_names:
            closing = world.robots[robot].gripper.command.values
            told_to_hold = closing == world.robots[robot].gripper.positions(0.0)
            if not (told_to_hold and world.held(self.thing, robot)):
                self.taken.pop(robot, None)
                continue
            in_tool: Pose = world.pose(f"{robot}.tcp").inverse() @ world.pose(self.thing)
            start = self.taken.setdefault(robot, in_tool.position)
            self.slip = max(self.slip, math.dist(start, in_tool.position))
        return outcome


def measure(name: str, rate: int, seeds: int) -> dict[str, float]:
    """Success rate and greatest slip of a task at a rate."""
    task = load_task(name)
    spec = task.file.spec
    timing = spec.timing.model_copy(update={"physics_hz": rate})
    changed = replace(
        task, file=replace(task.file, spec=spec.model_copy(update={"timing": timing}))
    )
    world = build_world(changed.file)
    solved, slip = 0, 0.0
    for seed in range(5000, 5000 + seeds):  # none that anything was tuned on
        script = Watched(changed, world, seed)
        with suppress(AssertionError):  # where the thing was lost, the script finds no way on
            PLAYS[name](script)
        solved += any(outcome.success for outcome in script.outcomes)
        slip = max(slip, script.slip)
    world.close()
    return {"solved": solved, "seeds": seeds, "slip_mm": slip * 1000.0}


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    seeds = parser.parse_args().seeds
    tasks = {name: {str(rate): measure(name, rate, seeds) for rate in RATES} for name in PLAYS}
    RESULTS.write_text(json.dumps({"machine": describe_machine(), "tasks": tasks}, indent=2) + "\n")
    for name, rates in tasks.items():
        for rate, found in rates.items():
            solved = f"{found['solved']:.0f}/{found['seeds']:.0f}"
            print(f"{name:20} {rate:>4} Hz  solved {solved:>8}  slip {found['slip_mm']:6.1f} mm")


if __name__ == "__main__":
    main()
