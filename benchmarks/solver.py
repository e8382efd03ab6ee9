"""What the solver's limits cost, and what they let slip, while nothing, or something, is held.

    python benchmarks/solver.py

The experts of three tasks play the same seeds with other limits on the solver's iterations, and on
what it may leave unsolved. Of every physics step, Bullet reports how many iterations it took and
the squared residual that is left. Slip is how far a held object moves in a gripper from the control
step after the one at which it is first held. The time of a control step is CPU time, measured in
episodes without these reports. Results go to benchmarks/results/solver.json, and from there to
docs/physics.md (`make docs`).
"""

from __future__ import annotations

import json
import math
import time
from collections import defaultdict
from contextlib import closing
from pathlib import Path
from statistics import fmean, median
from typing import Any
from unittest import mock

from machine import describe_machine

from taskbuilder import parallel_env
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert import Expert
from taskbuilder.geometry import Vec3
from taskbuilder.sim import client as engine

OUT = Path(__file__).parent / "results" / "solver.json"
TASKS = ("handover", "pick_push_place", "collaborative_lift")
SEEDS = range(4_300_000, 4_300_010)
TIMED = SEEDS[:3]
LIMITS = (
    *((limit, engine.RESIDUAL) for limit in (15, 30, 45, 60, 100, 200)),
    *((engine.SOLVER_ITERATIONS, residual) for residual in (1e-7, 1e-5, 1e-4)),
)


class Iterations:
    """Counts the iterations of each physics step, while something is held and while not."""

    def __init__(self, env: TaskEnv) -> None:
        self.of: dict[bool, list[int]] = {True: [], False: []}
        self.left: list[float] = []
        self.holding = False
        bullet = env.episode.world.client.bullet
        bullet.setPhysicsEngineParameter(reportSolverAnalytics=1)
        self._step, bullet.stepSimulation = bullet.stepSimulation, self.step

    def step(self) -> None:
        """Take a physics step; islands are solved one after the other, the hardest counts."""
        islands = self._step()
        if islands:
            self.of[self.holding].append(max(island["numIterationsUsed"] for island in islands))
            if self.holding:
                self.left.append(max(island["remainingResidual"] for island in islands))


class Grasps:
    """Follows what each robot holds; call it after each control step."""

    def __init__(self) -> None:
        self.taken: dict[tuple[str, str], Vec3] = {}
        self.slip = 0.0
        self.count: Iterations | None = None
        self._new: set[tuple[str, str]] = set()

    def __call__(self, env: TaskEnv) -> None:
        """Measure the slip of what is held."""
        world = env.episode.world
        pairs = [(r, o) for r in world.robot_names for o in world.movable if world.held(o, r)]
        for gone in {*self.taken} - {*pairs}:
            del self.taken[gone]
        for robot, thing in pairs:
            if (robot, thing) not in self._new | {*self.taken}:
                continue  # the fingers are still closing
            place = (world.pose(f"{robot}.tcp").inverse() @ world.pose(thing)).position
            start = self.taken.setdefault((robot, thing), place)
            if len(pairs) == 1:  # two robots that hold one object pull at it
                self.slip = max(self.slip, math.dist(start, place))
        self._new = {*pairs}
        if self.count:
            self.count.holding = bool(pairs)


def measure(task: str) -> dict[str, Any]:
    """Play a task with the limits that hold now."""
    slips, solved, iterations, left = [], 0, defaultdict[bool, list[int]](list), []
    for seed in SEEDS:
        with closing(parallel_env(task)) as env, closing(Expert(env)) as expert:
            watch = Grasps()
            watch.count = Iterations(env)
            solved += expert.play(seed, watch=watch).success
            slips.append(1000.0 * watch.slip)
            left += watch.count.left
            for holding, counts in watch.count.of.items():
                iterations[holding] += counts
    times = [timed(task, seed) for seed in TIMED]
    return {
        "success": solved,
        "slip_mm": {"median": round(median(slips), 2), "max": round(max(slips), 2)},
        "iterations": {"free": mean(iterations[False]), "held": mean(iterations[True])},
        "left": float(f"{median(left):.1e}"),
        "step_ms": {
            "expert": round(min(expert for expert, _ in times), 2),
            "random": round(min(random for _, random in times), 2),
        },
    }


def mean(counts: list[int]) -> float:
    """The mean, to a tenth."""
    return round(fmean(counts), 1)


def timed(task: str, seed: int) -> tuple[float, float]:
    """CPU time of a control step in ms: with the expert's actions, and with random ones."""
    with closing(parallel_env(task)) as env:
        with closing(Expert(env)) as expert:
            played = expert.play(seed)
        actions = [
            {agent: given[step] for agent, given in played.actions.items()}
            for step in range(played.steps)
        ]
        env.reset(seed=seed)
        expert_ms = stepped(env, actions)
        env.reset(seed=seed)
        for number, agent in enumerate(env.possible_agents):
            env.action_space(agent).seed(seed + number)
        spaces = {agent: env.action_space(agent) for agent in env.possible_agents}
        drawn = [{agent: space.sample() for agent, space in spaces.items()} for _ in actions]
        return expert_ms, stepped(env, drawn)


def stepped(env: TaskEnv, actions: Any) -> float:
    """CPU time of a control step in ms."""
    started, steps = time.process_time(), 0
    for action in actions:
        if not env.agents:
            break
        env.step(action)
        steps += 1
    return 1000.0 * (time.process_time() - started) / steps


def main() -> None:
    """Measure all tasks with all limits."""
    rows = []
    for limit, residual in LIMITS:
        with (
            mock.patch.object(engine, "SOLVER_ITERATIONS", limit),
            mock.patch.object(engine, "RESIDUAL", residual),
        ):
            tasks = {task: measure(task) for task in TASKS}
        rows.append({"iterations": limit, "residual": residual, "tasks": tasks})
        print(limit, residual, tasks, flush=True)
        found = {
            "command": "python benchmarks/solver.py",
            "machine": describe_machine(),
            "today": [engine.SOLVER_ITERATIONS, engine.RESIDUAL],
            "episodes": len(SEEDS),
            "rows": rows,
        }
        OUT.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
