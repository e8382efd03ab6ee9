"""An arm that moves sideways, past milestones."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout import RecordedActions, Rollout, play

SMALL = (32, 24)

SCENE = """
task: sideways
summary: The arm moves sideways.
timing: {control_hz: 10, physics_hz: 120, episode_steps: 20}
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [0, 0, 0]}
      home: {tcp: {position: [0.45, 0, 0.4], rpy_deg: [180, 0, 0]}}
  sites:
    first: {position: [0.45, 0.08, 0.4]}
    second: {position: [0.45, 0.16, 0.4], marker: {sphere: 0.03}, color: green}
    flag: {position: [0, 0, 0.05], in: arm.tcp, marker: {sphere: 0.04}, color: yellow, opacity: 1}
  cameras:
    front: {position: [1.6, 0.1, 0.5], look_at: [0.45, 0.1, 0.4], size: [64, 48]}
    wrist: {mount: arm.tcp, size: [64, 48]}
"""
DESCRIPTION = """
from taskbuilder.description import Bonus, Description, Distance, Near


class Sideways(Description):
    success = Near("arm.tcp", "second", within=0.03)
    stages = {"begun": Near("arm.tcp", "first", within=0.03), "there": success}
    reward = (Distance("reach", "arm.tcp", "second"), Bonus("there", success, 1.0))
"""


def write_scene(folder: Path) -> Path:
    """The task's files."""
    (folder / "sideways.py").write_text(DESCRIPTION)
    file = folder / "sideways.yaml"
    file.write_text(SCENE)
    return file


def sideways(env: TaskEnv, steps: int = 10) -> Rollout:
    """The arm moves for some steps along y, at half its speed."""
    actions = np.zeros((steps, *env.action_space("arm").shape), dtype=np.float32)
    actions[:, 1] = 0.5
    return play(env, RecordedActions({"arm": actions}), seed=0)
