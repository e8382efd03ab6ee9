"""Moving a joint of an articulated object by its handle."""

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

LEAST_LEVER_M = 0.05
"""Distance from its axis at which a handle counts as being, at least, for a tolerance in metres."""

FINEST_M, FINEST_RAD = 0.002, math.radians(0.5)
"""Tolerances that the distance to move does not make smaller."""


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
    arc = None
    tolerance = order.tolerance or LOAD_TOLERANCE_M
    if not joint.slides:
        axis = joint.axis(at)
        arm = subtract(tool.position, at.position)
        radius = norm(subtract(arm, scale(axis, dot(arm, axis))))
        arc = Arc(at.position, axis, by, turns=order.turn_tool)
        goal = arc.pose(tool, 1.0)
        tolerance = _turn_tolerance(order, radius)

    def gap(situation: Situation) -> float:
        return abs(target - situation.joint(joint.name))

    move = Move(
        {robot: Pose()},
        goal,
        straight=True,
        arc=arc,
        speed=order.speed,
        touching=(*order.touching, joint.owner),
    )
    # What has not moved has not arrived, however near its goal it began.
    finest = FINEST_M if joint.slides else FINEST_RAD
    tolerance = min(tolerance, max(abs(by) / 2.0, finest))
    return Go(
        (move,),
        "",
        tolerance,
        joint=(joint.name, target),
        holds=handle or "",
        gap=gap,
        until=order.until or "",
    )


def _turn_tolerance(order: Order, radius: float) -> float:
    """Tolerance in rad of a joint that turns by a handle at this distance in metres."""
    if order.tolerance_deg is not None:
        return math.radians(order.tolerance_deg)
    if order.tolerance is not None:
        return order.tolerance / max(radius, LEAST_LEVER_M)
    return min(TURN_TOLERANCE, LOAD_TOLERANCE_M / max(radius, LEAST_LEVER_M))
