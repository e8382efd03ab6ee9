"""Whether a robot can reach a pose, by inverse kinematics and without physics."""

from __future__ import annotations

import math

import numpy as np

from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.geometry import Pose, Vec3, add, norm, scale, subtract
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.order import Order
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

NEAR_M, NEAR_TURN = 0.004, math.radians(3.0)
"""Maximum deviation of the tcp from a pose (m, rad), the same as for experts."""


FARTHEST_M = 0.5
"""Maximum distance from a pose at which the edge of the workspace is searched, in metres."""

HALVINGS = 6
ATTEMPTS = 6
"""Starts of inverse kinematics in the search for the edge; a pose itself gets more."""


def reaches(robot: Robot, pose: Pose, attempts: int = 20) -> bool:
    """Whether joint positions within a robot's limits bring its tcp to a pose in the world."""
    found = solve(
        robot.chain,
        robot.body.pose().inverse() @ pose,
        start=robot.home,
        rng=np.random.default_rng(0),
        attempts=attempts,
        position_tolerance_m=NEAR_M,
        angle_tolerance=NEAR_TURN,
    )
    return found.ok


def margin_of(robot: Robot, pose: Pose, *, ok: bool) -> float:
    """How much farther from the shoulder a pose could be, by bisection.

    Args:
        robot: The robot.
        pose: A pose of its tcp in the world.
        ok: Whether it reaches the pose.

    Returns:
        Metres, at most `FARTHEST_M`; negative if the pose must be nearer, and minus infinity if
        even a pose that is `FARTHEST_M` nearer is out of reach.
    """
    away = subtract(pose.position, shoulder_of(robot))
    outwards = scale(away, 1.0 / max(norm(away), 1e-9))
    within, beyond = (0.0, FARTHEST_M) if ok else (-FARTHEST_M, 0.0)
    edge = beyond if ok else within
    if reaches(robot, _shifted(pose, outwards, edge), ATTEMPTS) is ok:
        return FARTHEST_M if ok else -math.inf
    for _ in range(HALVINGS):
        middle = (within + beyond) / 2.0
        if reaches(robot, _shifted(pose, outwards, middle), ATTEMPTS):
            within = middle
        else:
            beyond = middle
    return within


def shoulder_of(robot: Robot) -> Vec3:
    """The position of an arm's first joint in the world."""
    x, y, z = (float(value) for value in robot.chain.frames[0][:3, 3])
    return robot.body.pose().apply((x, y, z))


def _shifted(pose: Pose, direction: Vec3, metres: float) -> Pose:
    return Pose(add(pose.position, scale(direction, metres)), pose.quaternion)


def within_reach(world: World, robot: str, grasp: str) -> bool:
    """Whether a robot could take an object by a grasp point where it is now."""
    asked = list(dry_run(world, [{robot: Order(grasp=grasp)}]))
    arm = world.robots[robot]
    return bool(asked) and all(any(reaches(arm, pose) for pose in one.choices) for one in asked)
