"""Orders that move a joint of an articulated object by its handle."""

from __future__ import annotations

import math

from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.planning.subspaces import Arc
from taskbuilder.expert.script.joints import Joint
from taskbuilder.expert.script.situation import (
    LOAD_TOLERANCE_M,
    Go,
    NotHeldError,
    Situation,
)
from taskbuilder.geometry import Pose, dot, norm, scale, subtract
from taskbuilder.schema.order import Order

TURN_TOLERANCE = math.radians(7.5)
"""Default tolerance of a joint that is turned, so that a handle near its axis is not far off."""


def move_joint(now: Situation, robot: str, order: Order) -> Go:
    """The motion along the path of a joint, by a handle that a robot holds.

    Raises:
        NotHeldError: The robot holds no link that the joint moves.
    """
    joint = Joint(now.world, order.joint or "")
    target = order.joint_position or 0.0
    handle = now.handle(robot)
    if handle not in joint.below:
        held = handle or now.load(robot) or "nothing"
        raise NotHeldError(robot, f"holds no handle of {joint.name}: it holds {held}")
    by = target - now.joint(joint.name)
    at, tool = now.pose(joint.child), now.tool(robot)
    shift = joint.shift(at, by)
    goal = shift @ tool
    radius = 1.0
    arc = None
    if not joint.slides:
        axis = joint.axis(at)
        arm = subtract(tool.position, at.position)
        radius = norm(subtract(arm, scale(axis, dot(arm, axis))))
        arc = Arc(at.position, axis, by, turns=order.turn_tool)
        goal = arc.pose(tool, 1.0)

    def gap(later: Situation) -> float:
        return abs(target - later.joint(joint.name)) * radius

    move = Move(
        {robot: Pose()},
        goal,
        straight=True,
        arc=arc,
        speed=order.speed,
        touching=(*order.touching, joint.thing),
    )
    usual = LOAD_TOLERANCE_M if joint.slides else min(LOAD_TOLERANCE_M, TURN_TOLERANCE * radius)
    tolerance = order.tolerance or usual
    return Go((move,), "", tolerance, joint=(joint.name, target), holds=handle or "", gap=gap)
