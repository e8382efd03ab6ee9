"""A bench with a block on a post, and moving an arm there."""

from __future__ import annotations

import numpy as np

from taskbuilder.geometry import Pose, Vec3, from_rpy_deg
from taskbuilder.kinematics.inverse import solve
from taskbuilder.world.world import World

HANDS = (0.45, 0.0, 0.40)
"""Where the tcp is at home: in the middle of the block."""

BENCH = """
timing: {control_hz: 10, physics_hz: 120}
scene:
  robots:
    arm:
      model: MODEL
      base: {position: [0, 0, 0]}
      home: {tcp: {position: [0.45, 0, HEIGHT], rpy_deg: [180, 0, 0]}}
  objects:
    post: {shape: {box: [0.1, 0.03, 0.38]}, fixed: true, position: [0.45, 0, 0.19]}
    block:
      shape: {box: [0.06, 0.04, 0.04]}
      mass: 0.1
      position: [0.45, 0, 0.4005]
"""


def bench(model: str = "ur5e", *, height: float = HANDS[2]) -> str:
    """A robot with its open gripper around a block that stands on a thin post, or above it."""
    return BENCH.replace("MODEL", model).replace("HEIGHT", str(height))


def bring(world: World, robot: str, position: Vec3, *, steps: int, yaw_deg: float = 0.0) -> None:
    """Bring a tool that points down to a position, over some control steps."""
    arm = world.robots[robot]
    goal = arm.body.pose().inverse() @ Pose(position, from_rpy_deg((180.0, 0.0, yaw_deg)))
    start = np.array(arm.arm.command.values)
    found = solve(arm.chain, goal, start=tuple(start), rng=np.random.default_rng(0))
    assert found.ok
    for step in range(1, steps + 1):
        way = start + (np.array(found.joints) - start) * step / steps
        world.step({robot: tuple(way.tolist())})


def squeeze(world: World, robot: str, *, steps: int = 5, opening: float = 0.0) -> None:
    """Close a gripper."""
    world.robots[robot].move_gripper(opening)
    for _ in range(steps):
        world.step()


def state(world: World) -> list[object]:
    """Everything that moves, to the bit."""
    seen: list[object] = [world.time]
    for thing in world.objects.values():
        seen += [thing.body.pose(), thing.body.velocity()]
        seen.append(thing.body.joint_states(tuple(range(len(thing.body.joints)))))
    for robot in world.robots.values():
        seen.append(robot.body.joint_states(tuple(range(len(robot.body.joints)))))
        seen += [robot.arm.command, robot.gripper.command]
    return seen + [site.pose for site in world.sites.values()]
