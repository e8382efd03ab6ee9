"""Pressing something with the closed gripper, or with a tool."""

from __future__ import annotations

import math

from taskbuilder.assets.model import Urdf
from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.script.fingers import FREE_M, close_gripper, closed_fingers, pointing_down
from taskbuilder.expert.script.joints import Joint
from taskbuilder.expert.script.situation import (
    DOWN,
    TOOL_TOLERANCE_M,
    Go,
    Phase,
    Situation,
    carrier_of,
)
from taskbuilder.geometry import (
    Pose,
    Vec3,
    dot,
)
from taskbuilder.schema.articulation import pressed
from taskbuilder.schema.order import Order

TRAVEL_TOLERANCE_M = 0.002
"""Default tolerance of a joint that is pressed, in metres."""

FINEST_M = 0.0005
"""Tolerance of a joint that is pressed that the distance to press it does not make smaller."""

DEPTH_M = 0.01
"""Default depth to which something is pressed, in metres."""


def press_phases(robot: str, order: Order, frame: str) -> tuple[Phase, ...]:
    """Close, go above a frame, and press straight down on it."""
    return (
        lambda now: close_gripper(now, robot, "press"),
        lambda now: _over(now, robot, order, frame),
        lambda now: _down(now, robot, order, frame),
    )


def _top(now: Situation, frame: str) -> Vec3:
    """The point of a frame that is pressed: of a body, the middle of its top."""
    joint = _pressed_joint(now, frame)
    body = joint.child if joint else frame
    owner, _, part = body.partition(".")
    obj = now.world.objects.get(owner)
    if obj is None or (part and part not in obj.boxes):
        return now.pose(frame).position
    box = now.world.box(body).seen_from(now.pose(body))
    return (box.center[0], box.center[1], box.high[2])


def _pressed_joint(now: Situation, frame: str) -> Joint | None:
    """The prismatic joint that moves as a frame is pressed, or None."""
    owner, _, link = carrier_of(now.scene, frame).partition(".")
    asset = now.world.task.assets.get(owner)
    joint = pressed(asset, link) if isinstance(asset, Urdf) else None
    return Joint(now.world, f"{owner}.{joint.name}") if joint else None


def _over(now: Situation, robot: str, order: Order, frame: str) -> Go:
    """The motion to a place above the frame."""
    turn = pointing_down(now.tool(robot).quaternion)
    x, y, z = _top(now, frame)
    place = Pose((x, y, z + FREE_M - closed_fingers(now, robot, turn).low[2]), turn)
    return Go((Move({robot: Pose()}, place, speed=order.speed, touching=order.touching),))


def _down(now: Situation, robot: str, order: Order, frame: str) -> Go:
    """The straight motion down, until the joint or the tool has gone far enough."""
    tool, top, joint = now.tool(robot), _top(now, frame), _pressed_joint(now, frame)
    deeper = order.depth or DEPTH_M
    travel: tuple[str, float] | None = None
    sign = 1.0
    if joint is not None:
        position, (low, high) = now.joint(joint.name), joint.limits
        sign = math.copysign(1.0, dot(joint.axis(now.pose(joint.child)), DOWN))
        target = order.joint_position
        if target is None:
            target = min(max(position + sign * deeper, low), high)
        travel, deeper = (joint.name, target), sign * (target - position)
    tip = tool.position[2] + closed_fingers(now, robot, tool.quaternion).low[2]
    place = tool.moved((0.0, 0.0, min(tip, top[2]) - deeper - tip))
    owner = carrier_of(now.scene, frame).partition(".")[0]
    touching = (*order.touching, *([owner] if owner in now.world.objects else []))
    move = Move({robot: Pose()}, place, straight=True, speed=order.speed, touching=touching)
    if travel is None:
        return Go((move,), "", order.tolerance or TOOL_TOLERANCE_M)
    name, end = travel

    def gap(situation: Situation) -> float:
        return max(0.0, sign * (end - situation.joint(name)))

    # What has not moved has not arrived, however near its goal it began.
    tolerance = min(order.tolerance or TRAVEL_TOLERANCE_M, max(abs(deeper) / 2.0, FINEST_M))
    return Go((move,), "", tolerance, joint=travel, gap=gap)
