"""Small scenes to plan in, and carrying out what was planned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.expert.planning.planner import Move, Planner, Trajectory
from taskbuilder.geometry import Pose, Vec3
from taskbuilder.sim.contacts import closest_distance, contacts
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

HEAD = "task: {name}\nsummary: A scene to plan in.\n"

DESCRIPTION = '''"""A scene to plan in."""

from taskbuilder.description import Description, Distance, Near


class Scene(Description):
    success = Near("{arm}.tcp", "spot", within=0.01)
    reward = (Distance("reach", "{arm}.tcp", "spot"),)
'''

WALLED = """
timing: {{control_hz: 10, physics_hz: 120, episode_steps: 100}}
scene:
  robots:
    arm:
      model: {model}
      base: {{position: [0, 0, 0]}}
      home: {{tcp: {{position: [0.45, -0.25, 0.3], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
  objects:
    wall:
      shape: {{box: [{width}, 0.04, {height}]}}
      position: [{x}, 0, {z}]
      fixed: true
{more}  sites: {{spot: {{position: [0.45, 0.25, 0.3]}}}}
"""
"""One arm, and a wall between its tool and the place on the other side of it."""

FACING = """
timing: {{control_hz: 10, physics_hz: 120, episode_steps: 100}}
scene:
  robots:
    left:
      model: ur5e
      base: {{position: [-0.6, 0, 0]}}
      home: {{tcp: {{position: [-0.2, -0.15, 0.3], rpy_deg: [180, 0, 0]}}}}
      action: {{{action}}}
    right:
      model: ur5e
      base: {{position: [0.6, 0, 0], rpy_deg: [0, 0, 180]}}
      home: {{tcp: {{position: [0.2, -0.15, 0.3], rpy_deg: [180, 0, 180]}}}}
      action: {{{action}}}
  objects:
    table: {{shape: {{box: [0.6, 1, 0.04]}}, position: [0, 0, 0.08], fixed: true}}
    bar:
      shape: {{box: [0.3, 0.03, 0.03]}}
      mass: 0.1
      position: [-0.15, 0, 0.115]
    post: {{shape: {{box: [0.04, 0.04, 0.2]}}, position: [0, 0.3, 0.2], fixed: true}}
  sites: {{spot: {{position: [0, 0, 0.3]}}}}
"""
"""Two arms that face each other over a table with a bar and a post on it."""

Make = Callable[..., "Scene"]


class Scene:
    """An environment that has begun, with a planner.

    Attributes:
        touched: Pairs of names that touched while trajectories were carried out.
    """

    def __init__(self, env: TaskEnv, seed: int = 0) -> None:
        self.env = env
        self.planner = Planner(env)
        self.touched: set[tuple[str, str]] = set()
        env.reset(seed=seed)

    @property
    def world(self) -> World:
        """Its world."""
        return self.env.episode.world

    def commanded(self, robot: str) -> Pose:
        """Where a tool is commanded to be, in the world."""
        built = self.world.robots[robot]
        return built.body.pose() @ built.chain.forward(built.arm.command.values)

    def at(self, robot: str, position: Vec3) -> Move:
        """A move of a tool to a position, turned as it is."""
        return Move({robot: Pose()}, Pose(position, self.commanded(robot).quaternion))

    def plan(self, *moves: Move, seed: int = 0, **held: str) -> Trajectory:
        """Plan moves."""
        return self.planner.plan(moves, held=held, rng=np.random.default_rng(seed))

    def go(self, *moves: Move, seed: int = 0, **held: str) -> Trajectory:
        """Plan moves and carry them out."""
        trajectory = self.plan(*moves, seed=seed, **held)
        self.carry_out(trajectory)
        return trajectory

    def carry_out(self, trajectory: Trajectory, rest: int = 2) -> None:
        """Command a trajectory's joints, then wait, and note what touches what."""
        for step in range(trajectory.steps + rest):
            targets: Mapping[str, tuple[float, ...]] = {}
            if step < trajectory.steps:
                targets = {name: points[step] for name, points in trajectory.joints.items()}
            self.world.step(targets)
            self.touched |= self._touching()

    def _touching(self) -> set[tuple[str, str]]:
        things = {**self.world.robots, **self.world.objects}
        names = {thing.body.id: name for name, thing in things.items()}
        pairs = {
            tuple(sorted((names.get(touch.body_a, ""), names.get(touch.body_b, ""))))
            for touch in contacts(self.world.client)
            if touch.force > 0.0
        }
        return {(one, other) for one, other in pairs if one and one != other}

    def nearest(self, trajectory: Trajectory, one: str, other: str) -> float:
        """The smallest distance (m, at most 0.1) between two bodies where joints are commanded.

        Between robots and things that do not move, in a world built to look at it.
        """
        apart = build_world(self.env.task.file)
        things = {**apart.robots, **apart.objects}
        found = 0.1
        for step in range(trajectory.steps):
            for name, points in trajectory.joints.items():
                robot = apart.robots[name]
                robot.body.reset_joints(robot.arm.indices, points[step])
            distance = closest_distance(things[one].body, things[other].body, within=0.1)
            found = min(found, 0.1 if distance is None else distance)
        apart.close()
        return found

    def grip(self, robot: str, opening: float) -> None:
        """Open or close a gripper."""
        self.world.robots[robot].move_gripper(opening)
        for _ in range(4):
            self.world.step({})

    def in_object(self, robot: str, thing: str) -> Pose:
        """Where a tool is in an object."""
        return self.world.pose(thing).inverse() @ self.world.pose(f"{robot}.tcp")

    def close(self) -> None:
        """Free the physics."""
        self.planner.close()
        self.env.close()


def write_scene(folder: Path, text: str, name: str = "made") -> Path:
    """A task of a scene, in a folder."""
    agent = "arm" if "    arm:" in text else "left"
    (folder / f"{name}.py").write_text(DESCRIPTION.replace("{arm}", agent), encoding="utf-8")
    path = folder / f"{name}.yaml"
    path.write_text(HEAD.format(name=name) + text, encoding="utf-8")
    return path


def walled(
    *,
    model: str = "ur5e",
    action: str = "",
    height: float = 0.4,
    width: float = 0.5,
    behind: bool = False,
) -> str:
    """The scene with the wall, which begins 0.3 m in front of the arm; another behind it."""
    rest = f"{{box: [{width}, 0.04, {height}]}}, position: [{-0.15 - width / 2}, 0, {height / 2}]"
    return WALLED.format(
        model=model,
        action=action,
        height=height,
        width=width,
        x=0.3 + width / 2.0,
        z=height / 2.0,
        more=f"    rest: {{shape: {rest}, fixed: true}}\n" if behind else "",
    )


def facing(*, action: str = "") -> str:
    """The scene with two arms."""
    return FACING.format(action=action)


def made(folder: Path, text: str, *, variation: int = 0) -> Scene:
    """A scene of a text, or of a task of the library."""
    task: str | Path = text
    if "\n" in text:
        folder.mkdir(exist_ok=True)
        task = write_scene(folder, text)
    return Scene(parallel_env(task, variation=variation))
