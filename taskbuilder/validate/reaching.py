"""Whether a robot can reach a pose, by inverse kinematics and without physics."""

from __future__ import annotations

import math

import numpy as np

from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.order import Order
from taskbuilder.world.robot import Robot
from taskbuilder.world.world import World

NEAR_M, NEAR_TURN = 0.004, math.radians(3.0)
"""Maximum deviation of the tcp from a pose (m, rad), the same as for experts."""


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


def within_reach(world: World, robot: str, grasp: str) -> bool:
    """Whether a robot could take an object by a grasp point where it is now."""
    asked = list(dry_run(world, [{robot: Order(grasp=grasp)}]))
    arm = world.robots[robot]
    return bool(asked) and all(any(reaches(arm, pose) for pose in one.choices) for one in asked)
