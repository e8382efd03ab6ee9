"""Tasks that the tests write, and looking at environments to the bit."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.geometry import Pose, Vec3, add
from taskbuilder.sim.body import Body

LIBRARY = ("collaborative_lift", "handover", "pick_push_place")

Make = Callable[..., TaskEnv]

HEAD = "task: {name}\nsummary: A task made for a test.\n"

PLAIN = """
from taskbuilder.description import Description, Distance, Near


class Made(Description):
    success = Near("arm.tcp", "spot", within=0.01)
    reward = (Distance("reach", "arm.tcp", "spot"),)
"""

ARM = """
timing: {{control_hz: 10, physics_hz: 120, episode_steps: {steps}}}
scene:
  robots:
    arm:
      model: {model}
      base: {{position: [0, 0, 0]}}
      home: {{tcp: {{position: [0.45, 0, 0.4], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
  sites:
    spot: {{position: [0.45, 0.1, 0.4]}}
"""

FACING = """
timing: {{control_hz: 10, physics_hz: 120, episode_steps: 50}}
scene:
  robots:
    left:
      model: ur5e
      base: {{position: [-0.6, 0, 0]}}
      home: {{tcp: {{position: [-0.1, 0, 0.4], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
    right:
      model: ur5e
      base: {{position: [0.6, 0, 0], rpy_deg: [0, 0, 180]}}
      home: {{tcp: {{position: [0.1, 0, 0.4], rpy_deg: [180, 0, 180]}}}}
      action: {{{action}}}
  objects:
    post: {{shape: {{box: [0.1, 0.03, 0.38]}}, fixed: true, position: [-0.1, 0, 0.19]}}
    block:
      shape: {{box: [0.06, 0.04, 0.04]}}
      mass: 0.1
      position: [-0.1, 0, 0.4005]
    other:
      shape: {{sphere: 0.03}}
      mass: 0.1
      place: {{center: [0, 0.4, 0.05], size: [0.2, 0.2, 0]}}
  sites:
    spot: {{place: {{center: [0, 0.3, 0.5], size: [0.3, 0.3, 0.3]}}}}
    ride: {{position: [0, 0, 0.1], in: block}}
"""
"""Two arms that face each other; the left one's open fingers are around a block on a post."""

TWO = """
from taskbuilder.description import Below, Bonus, Description, Distance, Held, Near


class Made(Description):
    held = Held("block", by="left")
    success = Near("block", "spot", within=0.05)
    failure = Below("block", height=0.2)
    reward = (
        Bonus("grasp", held, 1.0, agent="left"),
        Distance("reach", "left.tcp", "block", agent="left"),
        Distance("reach", "right.tcp", "block", agent="right"),
        Distance("carry", "block", "spot"),
    )
"""


def facing(*observe: str, action: str = "", extra: str = "") -> str:
    """Two arms and a block; ``observe`` are lines of that section."""
    seen = "".join(f"\n  {line}" for line in observe)
    return FACING.format(action=action) + (f"observe:{seen}\n" if seen else "") + extra


def arm(model: str = "ur5e", *, action: str = "", steps: int = 50, extra: str = "") -> str:
    """One arm alone, its tool pointing down at home."""
    return ARM.format(model=model, action=action, steps=steps) + extra


def write_task(
    folder: Path, text: str, description: str | None = None, *, name: str = "made"
) -> Path:
    """A task file and its description, in a folder; by default the one that fits the text."""
    if description is None:
        description = TWO if "    block:" in text else PLAIN
    (folder / f"{name}.py").write_text(f'"""Made."""\n{description}', encoding="utf-8")
    path = folder / f"{name}.yaml"
    path.write_text(HEAD.format(name=name) + text, encoding="utf-8")
    return path


def still(env: TaskEnv) -> dict[str, NDArray[np.float64]]:
    """For `tcp_delta`: everything stays as it was commanded."""
    return {agent: np.zeros(env.action_space(agent).shape) for agent in env.agents}


def physical(env: TaskEnv) -> dict[str, Any]:
    """Everything that moves, as read off the physics."""
    world = env.episode.world
    seen: dict[str, Any] = {"time": world.time}
    for name, thing in world.objects.items():
        seen[name] = (thing.body.pose(), thing.body.velocity(), _joints(thing.body))
    for name, robot in world.robots.items():
        seen[name] = (_joints(robot.body), robot.arm.command, robot.gripper.command)
    return seen | {f"{name}.site": world.pose(name) for name in world.sites}


def _joints(body: Body) -> Any:
    return body.joint_states(tuple(range(len(body.joints))))


def moment(env: TaskEnv) -> dict[str, Any]:
    """Everything that decides how an environment goes on."""
    episode = env.episode
    return physical(env) | {
        "agents": list(env.agents),
        "steps": episode.steps,
        "outcome": episode.outcome,
        "flags": (episode.succeeded, episode.failed, episode.exploded, episode.over),
        "seeds": env._seeds.bit_generator.state,
        "noise": episode.noise_rng.bit_generator.state,
    }


def digest(*values: Any) -> str:
    """A hash of nested arrays, numbers and mappings, to the bit and in order."""
    found = hashlib.sha256()
    for value in values:
        _feed(found, value)
    return found.hexdigest()


def _feed(found: Any, value: Any) -> None:
    if isinstance(value, Mapping):
        for key in value:
            found.update(str(key).encode())
            _feed(found, value[key])
    elif isinstance(value, list | tuple):
        for part in value:
            _feed(found, part)
    elif isinstance(value, np.ndarray):
        found.update(str((value.dtype, value.shape)).encode() + value.tobytes())
    else:
        found.update(repr(value).encode())


def random_actions(env: TaskEnv, seed: int, steps: int) -> list[dict[str, Any]]:
    """Actions for some steps, drawn from the spaces."""
    rng = np.random.default_rng(seed)
    spaces = {agent: env.action_space(agent) for agent in env.possible_agents}
    return [
        {agent: rng.uniform(space.low, space.high) for agent, space in spaces.items()}
        for _ in range(steps)
    ]


def play(env: TaskEnv, actions: list[dict[str, Any]]) -> str:
    """Hash of all that comes back when actions are played."""
    return digest(*(part for action in actions for part in (*env.step(action), env.state())))


def near(found: Any, expected: Any, within: float) -> bool:
    """Whether two vectors are nowhere further apart than that."""
    return bool(np.abs(np.subtract(found, expected)).max() <= within)


def tcp(env: TaskEnv, agent: str) -> Pose:
    """Where a tool is in the world."""
    return env.episode.world.pose(f"{agent}.tcp")


def towards(env: TaskEnv, goals: Mapping[str, Vec3], grippers: Mapping[str, float]) -> Any:
    """Normalised `tcp_delta` actions that bring tools nearer to positions in the world."""
    actions = still(env)
    for agent, goal in goals.items():
        step = env.episode.world.scene.robots[agent].action.max_step
        way = np.subtract(goal, tcp(env, agent).position) / step
        actions[agent][:3] = way / max(1.0, float(np.linalg.norm(way)))
    for agent, value in grippers.items():
        actions[agent][-1] = value
    return actions


GRASPS: Mapping[str, Mapping[str, str]] = {
    "handover": {"left": "stick.left_end"},
    "pick_push_place": {"left": "cube.middle", "right": "tray.grip"},
    "collaborative_lift": {"left": "tray.left_handle_top", "right": "tray.right_handle_top"},
}


def grasp(env: TaskEnv, grasps: Mapping[str, str]) -> list[Any]:
    """Tools come from above and close; what came back from each step."""
    world = env.episode.world
    back = []
    for height in (0.1, 0.0):
        for _ in range(10 if height else 4):
            goals = {
                agent: add(world.position(point), (0.0, 0.0, height))
                for agent, point in grasps.items()
            }
            back.append(env.step(towards(env, goals, {})))
    close = dict.fromkeys(grasps, -1.0)
    return back + [env.step(towards(env, {}, close)) for _ in range(4)]
