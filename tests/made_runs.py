"""A task that is quickly played, policies whose acts are known, and training runs made up."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.learn.plan import plan_of, save_plan
from taskbuilder.policies.trained import Network, TrainedPolicy
from taskbuilder.policies.zoo import save_policy

SCENE = """\
task: sideways
summary: The arm moves sideways, past a goal that is now here and now there.
timing: {control_hz: 10, physics_hz: 120, episode_steps: 12}
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [0, 0, 0]}
      home: {tcp: {position: [0.45, 0, 0.4], rpy_deg: [180, 0, 0]}}
  sites:
    first: {position: [0.45, 0.08, 0.4]}
    goal: {marker: {sphere: 0.03}, place: {center: [0.45, 0.1, 0.4], size: [0.002, 0.4, 0.002]}}
  cameras:
    front: {position: [1.6, 0.1, 0.5], look_at: [0.45, 0.1, 0.4], size: [64, 48]}
observe:
  arm: [self.tcp, goal.position, time_left]
variations:
  - {goal.color: blue}
"""
DESCRIPTION = """\
from taskbuilder.description import Bonus, Description, Distance, Near


class Sideways(Description):
    success = Near("arm.tcp", "goal", within=0.03)
    stages = {"begun": Near("arm.tcp", "first", within=0.04), "there": success}
    reward = (Distance("reach", "arm.tcp", "goal", agent="arm"), Bonus("there", success, 1.0))
"""
ENV = {"observe": "task", "frame": "task", "rotation": "quaternion", "variation": 0}
SEEN, SAID = 11, 5
"""Numbers that the arm sees and acts by."""

STAGES = ("begun", "there")


def write_task(folder: Path) -> Path:
    """The task's files, sideways.yaml and sideways.py."""
    (folder / "sideways.py").write_text(DESCRIPTION)
    file = folder / "sideways.yaml"
    file.write_text(SCENE)
    return file


def sideways(
    push: float = 0.5,
    *,
    axis: int = 1,
    agents: Sequence[str] = ("arm",),
    seen: int = SEEN,
    said: int = SAID,
    **about: Any,
) -> TrainedPolicy:
    """A policy that pushes along y, whatever it sees; at half its speed it passes most goals."""
    bias = np.zeros(said, dtype=np.float32)
    bias[axis] = np.arctanh(push)
    net = Network(((np.zeros((seen, said), dtype=np.float32), bias),), squash=True)
    known = {
        "task": "sideways",
        "algorithm": "maddpg",
        "reward": "ratchet",
        "track": "scratch",
        "env": ENV,
        "stages": list(STAGES),
        "seed": 3,
        "step": 20_000,
        "command": "taskbuilder train sideways.yaml --steps 20000 --seed 3",
    }
    return TrainedPolicy(dict.fromkeys(agents, net), known | about)


def policy_content(**options: Any) -> bytes:
    """The bytes of a policy's file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "policy.npz"
        save_policy(path, sideways(**options))
        return path.read_bytes()


def plan_content(**plan: Any) -> bytes:
    """The bytes of a run's plan."""
    with tempfile.TemporaryDirectory() as folder:
        save_plan(Path(folder), plan_of({"task": "sideways", **plan}), {})
        return (Path(folder) / "run.json").read_bytes()


def write_run(
    folder: Path,
    *,
    learned_at: int = 10_000,
    per_episode: int = 20,
    every: int = 2_000,
    terms: Sequence[str] = ("reach/arm", "there"),
    lasting: float | None = None,
    **plan: Any,
) -> Path:
    """A training run of which success, return and stages rise at a step, noise apart.

    Args:
        folder: Where; made if it is not there.
        learned_at: Environment steps after which half of the episodes succeed.
        per_episode: Control steps of an episode.
        every: Steps between evaluations.
        terms: Labels of the reward's.
        lasting: Fraction of the successes that last; None for a run that does not record it.
        plan: As for `Plan`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    made = plan_of({"task": "sideways", "steps": 20_000, "evaluate_every": every, **plan})
    save_plan(folder, made, {"stages": list(STAGES), "horizon": per_episode})
    rng = np.random.default_rng(made.seed)

    def skill(step: float) -> float:
        return float(1.0 / (1.0 + np.exp(-(step - learned_at) / (0.1 * made.steps))))

    names = ("step", "episode", "steps", "success", "stage", "team_return", "paid")
    rows: list[list[float]] = []
    for number in range(1, made.steps // per_episode + 1):
        step = number * per_episode
        stage = int(rng.binomial(2, skill(step)))
        paid = [10.0 * skill(step) + rng.normal() for _ in terms]
        rows.append([step, number, per_episode, stage == 2, stage, sum(paid), stage, *paid])
    _write(folder / "episodes.csv", [*names, *(f"term/{label}" for label in terms)], rows)
    names = ("step", "episode", "episodes", "success_rate", "team_return", "steps_to_success")
    rows = []
    for step in range(every, made.steps + 1, every):
        counts = np.bincount(rng.binomial(2, skill(step), size=20), minlength=3).tolist()
        row = [step, step // per_episode, 20, counts[2] / 20, 20 * skill(step), 5, *counts]
        rows.append(row if lasting is None else [*row, lasting * counts[2] / 20])
    names = (*names, "stage/0", "stage/1", "stage/2")
    names = names if lasting is None else (*names, "success_at_end_rate")
    _write(folder / "evaluations.csv", names, rows)
    names = ("step", "seconds", "steps_per_second", "critic", "actor")
    _write(folder / "updates.csv", names, [[1_000, 2.5, 400.0, 0.25, float("nan")]])
    return folder


def _write(path: Path, names: Sequence[str], rows: Sequence[Sequence[float]]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows([[f"{value:.6g}" for value in row] for row in rows])
