"""Tasks that tests write, and playing them."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.rollout import Rollout
from taskbuilder.task import load_task

TABLE = """
task: {name}
summary: A task made for a test.
cooperation: optional
timing: {{control_hz: 10, physics_hz: 120, episode_steps: {steps}}}
scene:
  robots:
    arm:
      model: {model}
      base: {{position: [-0.6, 0, 0.4]}}
      home: {{tcp: {{position: [-0.1, 0, 0.65], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
{robots}  objects:
    table: {{shape: {{box: [1.6, 1.2, 0.04]}}, fixed: true, position: [0, 0, 0.38]}}
    block:
      shape: {{box: [0.05, 0.04, 0.05]}}
      mass: 0.1
      position: [-0.1, 0.15, 0.4255]
      grasps: {{middle: {{across: y}}, side: {{approach: -z, across: x}}}}
{objects}  sites:
    goal: {{position: [-0.1, -0.2, 0.55]}}
    spot: {{position: [-0.1, 0.0, 0.6]}}
{sites}expert:
{expert}
{extra}
"""

RIGHT = """\
    right:
      model: ur5e
      base: {position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}
      home: {tcp: {position: [0.25, 0, 0.65], rpy_deg: [180, 0, 180]}}
"""

DESCRIPTION = """
from taskbuilder.description import Bonus, Description, Distance, Held, Near


class Made(Description):
    held = Held("block", by="arm")
    near = Near("block", "goal", within=0.03)
    success = near
    reward = (Distance("carry", "block", "goal"), Bonus("there", near, 1.0))
"""


def made(
    folder: Path,
    *stages: str,
    robots: str = "",
    objects: str = "",
    sites: str = "",
    action: str = "",
    model: str = "ur5e",
    description: str = DESCRIPTION,
    steps: int = 60,
    extra: str = "",
    **options: object,
) -> TaskEnv:
    """An environment of a task with an arm, a table and a block, and the given stages."""
    listed = "\n".join(f"  - {stage}" for stage in stages)
    text = TABLE.format(
        name=folder.name,
        steps=steps,
        action=action,
        model=model,
        robots=robots,
        objects=objects,
        sites=sites,
        expert=listed,
        extra=extra,
    )
    file = folder / f"{folder.name}.yaml"
    file.write_text(text, encoding="utf-8")
    file.with_suffix(".py").write_text(description, encoding="utf-8")
    return parallel_env(load_task(file), **options)


class Digest:
    """A hash of all that agents see and earn, and of where everything is, step by step."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        self.steps = 0

    def __call__(self, env: TaskEnv) -> None:
        world = env.episode.world
        for name in (*world.object_names, *(f"{robot}.tcp" for robot in world.robot_names)):
            pose = world.pose(name)
            self._hash.update(np.array([*pose.position, *pose.quaternion]).tobytes())
        for values in env._last.values():  # what agents saw last
            self._hash.update(np.ascontiguousarray(values).tobytes())
        self._hash.update(np.array(env.team_reward()).tobytes())
        self.steps += 1

    @property
    def hex(self) -> str:
        """The hash so far."""
        return self._hash.hexdigest()


def same(one: Rollout, other: Rollout) -> bool:
    """Whether two demonstrations are alike to the bit, but for the time that planning took."""
    actions = all(np.array_equal(one.actions[a], other.actions[a]) for a in one.actions)
    return actions and np.array_equal(one.rewards, other.rewards) and one.trouble == other.trouble
