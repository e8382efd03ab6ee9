"""Telling a diverged simulation from a running one."""

from __future__ import annotations

import math
from collections.abc import Sequence

from taskbuilder.errors import ExplosionError
from taskbuilder.geometry import Pose

# Bullet clamps joint speeds at 100 rad/s (or m/s): a joint that reaches it has exploded.
JOINT_SPEED_LIMIT = 99.0
REACH_M = 50.0
SPEED_LIMIT = 1e3


def check_pose(name: str, pose: Pose) -> None:
    """Refuse a pose that was read and cannot be.

    Raises:
        ExplosionError: A number is not finite, or the position is over 50 m from the origin.
    """
    x, y, z = pose.position
    # A comparison with nan is false, so these also catch what is not a number.
    if not (-REACH_M < x < REACH_M and -REACH_M < y < REACH_M and -REACH_M < z < REACH_M):
        raise _explosion(name, f"is at ({x:.4g}, {y:.4g}, {z:.4g}) m")
    a, b, c, d = pose.quaternion
    if not math.isfinite(a + b + c + d):
        raise _explosion(name, "has an orientation that is not finite")


def check_joints(name: str, speeds: Sequence[float]) -> None:
    """Refuse joint speeds (rad/s or m/s) that were read and cannot be.

    Raises:
        ExplosionError: One is not finite, or at Bullet's clamp of 100.
    """
    for index, speed in enumerate(speeds):
        if not -JOINT_SPEED_LIMIT < speed < JOINT_SPEED_LIMIT:
            raise _explosion(name, f"has its joint {index} moving at {speed:.4g} rad/s or m/s")


def _explosion(name: str, what: str) -> ExplosionError:
    return ExplosionError(
        f"{name} {what}: the simulation diverged; try more physics steps a second, "
        "a heavier object, or smaller forces"
    )
