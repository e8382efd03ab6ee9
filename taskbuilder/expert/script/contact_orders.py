"""Orders that push or press something with the closed gripper, or with a tool."""

from __future__ import annotations

import math
from collections.abc import Iterator

from taskbuilder.assets.model import Urdf
from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.script.joints import Joint
from taskbuilder.expert.script.situation import (
    DOWN,
    LOAD_TOLERANCE_M,
    TOOL_TOLERANCE_M,
    Go,
    Grip,
    NotHeldError,
    Phase,
    Situation,
    carrier_of,
    place_of,
)
from taskbuilder.geometry import (
    Box,
    Pose,
    Quat,
    Vec3,
    add,
    cross,
    dot,
    from_axes,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
    unit,
)
from taskbuilder.schema.articulation import pressed
from taskbuilder.schema.order import Order
from taskbuilder.world.robot import Robot
from taskbuilder.world.shapes import link_box

FREE_M = 0.02
"""Distance from which the gripper goes straight to what it pushes or presses, in metres."""

BASE_M = 0.01
"""Least height of the fingertips above the underside of what they push, in metres."""

TRAVEL_TOLERANCE_M = 0.002
"""Default tolerance of a joint that is pressed, in metres."""

FINEST_M = 0.0005
"""Tolerance of a joint that is pressed that the distance to press it does not make smaller."""

DEPTH_M = 0.01
"""Default depth to which something is pressed, in metres."""


def tip_boxes(robot: Robot, *, closed: bool) -> Iterator[Box]:
    """Boxes of a gripper's fingers, or of a tool, in the frame of the tcp.

    Fingers that are closed meet in the middle, wherever they are now.
    """
    into_tool = robot.tcp.inverse()
    for link in robot.tip_links:
        box = link_box(robot.model.urdf.link(link).collisions, 1.0)
        box = box.seen_from(into_tool @ robot.body.pose_of(link))
        inner = min(box.low[1], box.high[1], key=abs)
        if closed and box.low[1] * box.high[1] > 0.0:
            box = Box(add(box.center, (0.0, -inner, 0.0)), box.half)
        yield box


def _close(now: Situation, robot: str, verb: str) -> Grip | None:
    """To close an open gripper; a tool has nothing to close.

    Raises:
        NotHeldError: The gripper holds something.
    """
    held = now.load(robot) or now.handle(robot)
    if held:
        raise NotHeldError(robot, f"needs an empty gripper to {verb}, but holds {held}")
    rest = now.world.robots[robot].gripper.rest
    ready = rest is None or now.is_open(robot) == (rest > 0.5)
    return None if rest is None or ready else Grip(robot, rest)


def _fingers(now: Situation, robot: str, turn: Quat) -> Box:
    """The closed fingers, about the tcp, along the axes of the world."""
    boxes = [
        box.seen_from(Pose((0.0, 0.0, 0.0), turn))
        for box in tip_boxes(now.world.robots[robot], closed=True)
    ]
    low = [min(box.low[i] for box in boxes) for i in range(3)]
    high = [max(box.high[i] for box in boxes) for i in range(3)]
    return Box.around((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def _pointing_down(turn: Quat) -> Quat:
    """The nearest orientation in which a tool points straight down."""
    axis = rotate(turn, (0.0, 0.0, 1.0))
    about = cross(axis, DOWN)
    sine, cosine = norm(about), dot(axis, DOWN)
    if sine < 1e-9:
        return turn if cosine > 0.0 else multiply((1.0, 0.0, 0.0, 0.0), turn)
    half = 0.5 * math.atan2(sine, cosine)
    x, y, z = scale(about, math.sin(half) / sine)
    return multiply((x, y, z, math.cos(half)), turn)


# --- push


def push_phases(robot: str, order: Order, thing: str) -> tuple[Phase, ...]:
    """Close, go behind an object as seen from its goal, and push it there in a straight line."""
    return (
        lambda now: _close(now, robot, "push"),
        lambda now: _behind(now, robot, order, thing),
        lambda now: _through(now, robot, order, thing),
    )


def _goal(now: Situation, order: Order) -> Vec3:
    at = place_of(now, order.place)
    return add(at.position, rotate(at.quaternion, order.offset))


def _level(vector: Vec3) -> Vec3:
    return (vector[0], vector[1], 0.0)


def _behind(now: Situation, robot: str, order: Order, thing: str) -> Go | None:
    """The motion to a place behind the object."""
    at, goal = now.pose(thing), _goal(now, order)
    way = _level(subtract(goal, at.position))
    if norm(way) < 1e-3:
        return None
    way = unit(way)
    tool = now.tool(robot)
    choices = []
    for turn in _turns(tool.quaternion, way):
        back = _reach_behind(now, robot, thing, way, turn) + FREE_M
        x, y, _ = subtract(at.position, scale(way, back))
        place = Pose((x, y, _height(now, robot, thing, turn)), turn)
        choices.append(Move({robot: Pose()}, place, speed=order.speed, touching=order.touching))
    return Go(tuple(choices))


def _turns(turn: Quat, way: Vec3) -> tuple[Quat, ...]:
    """Orientations to push in a direction: both fingers across it; else as the tool is."""
    across = [from_axes(x_axis, cross(DOWN, x_axis), DOWN) for x_axis in (way, scale(way, -1.0))]
    across.sort(key=lambda other: turn_between(turn, other))
    return (*across, _pointing_down(turn))


def _reach_behind(now: Situation, robot: str, thing: str, way: Vec3, turn: Quat) -> float:
    """Distance along a level way from the tcp to an object's frame when the fingers touch it."""
    along = _frame_along(way).inverse()
    at = Pose((0.0, 0.0, 0.0), now.pose(thing).quaternion)
    behind = -now.world.box(thing).seen_from(along @ at).low[0]
    hand = max(
        box.seen_from(along @ Pose((0.0, 0.0, 0.0), turn)).high[0]
        for box in tip_boxes(now.world.robots[robot], closed=True)
    )
    return behind + hand


def _height(now: Situation, robot: str, thing: str, turn: Quat) -> float:
    """Height of the tcp: at the middle of an object, with the fingertips above its underside."""
    seen = now.world.box(thing).seen_from(now.pose(thing))
    least = seen.low[2] + BASE_M - _fingers(now, robot, turn).low[2]
    return max(seen.center[2], least)


def _through(now: Situation, robot: str, order: Order, thing: str) -> Go | None:
    """The straight motion that pushes the object to its goal."""
    at, goal, tool = now.pose(thing), _goal(now, order), now.tool(robot)
    way = _level(subtract(goal, tool.position))
    rest = _level(subtract(goal, at.position))
    if norm(rest) < 1e-3 or norm(way) < 1e-3:
        return None
    way = unit(way)
    # What is touched is measured; what is not is met where the boxes do.
    off = dot(subtract(at.position, tool.position), way)
    contact = min(off, _reach_behind(now, robot, thing, way, tool.quaternion))
    end = subtract(goal, scale(way, contact))
    place = Pose((end[0], end[1], tool.position[2]), tool.quaternion)
    touching = (*order.touching, thing)
    move = Move({robot: Pose()}, place, straight=True, speed=order.speed, touching=touching)

    def gap(later: Situation) -> float:
        return norm(_level(subtract(goal, later.pose(thing).position)))

    pushed = Pose((goal[0], goal[1], at.position[2]), at.quaternion)
    tolerance = order.tolerance or LOAD_TOLERANCE_M
    return Go((move,), "", tolerance, pushes=(thing, pushed), gap=gap)


def _frame_along(way: Vec3) -> Pose:
    """A frame whose x axis is a level direction, and whose z axis is upright."""
    up: Vec3 = (0.0, 0.0, 1.0)
    return Pose((0.0, 0.0, 0.0), from_axes(way, cross(up, way), up))


# --- press


def press_phases(robot: str, order: Order, frame: str) -> tuple[Phase, ...]:
    """Close, go above a frame, and press straight down on it."""
    return (
        lambda now: _close(now, robot, "press"),
        lambda now: _over(now, robot, order, frame),
        lambda now: _down(now, robot, order, frame),
    )


def _top(now: Situation, frame: str) -> Vec3:
    """The point of a frame that is pressed: of a body, the middle of its top."""
    joint = _pressed_joint(now, frame)
    body = joint.child if joint else frame
    owner, _, part = body.partition(".")
    thing = now.world.objects.get(owner)
    if thing is None or (part and part not in thing.boxes):
        return now.pose(frame).position
    seen = now.world.box(body).seen_from(now.pose(body))
    return (seen.center[0], seen.center[1], seen.high[2])


def _pressed_joint(now: Situation, frame: str) -> Joint | None:
    """The prismatic joint that moves as a frame is pressed, or None."""
    owner, _, link = carrier_of(now.scene, frame).partition(".")
    asset = now.world.task.assets.get(owner)
    joint = pressed(asset, link) if isinstance(asset, Urdf) else None
    return Joint(now.world, f"{owner}.{joint.name}") if joint else None


def _over(now: Situation, robot: str, order: Order, frame: str) -> Go:
    """The motion to a place above the frame."""
    turn = _pointing_down(now.tool(robot).quaternion)
    x, y, z = _top(now, frame)
    place = Pose((x, y, z + FREE_M - _fingers(now, robot, turn).low[2]), turn)
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
    tip = tool.position[2] + _fingers(now, robot, tool.quaternion).low[2]
    place = tool.moved((0.0, 0.0, min(tip, top[2]) - deeper - tip))
    owner = carrier_of(now.scene, frame).partition(".")[0]
    touching = (*order.touching, *([owner] if owner in now.world.objects else []))
    move = Move({robot: Pose()}, place, straight=True, speed=order.speed, touching=touching)
    if travel is None:
        return Go((move,), "", order.tolerance or TOOL_TOLERANCE_M)
    name, end = travel

    def gap(later: Situation) -> float:
        return max(0.0, sign * (end - later.joint(name)))

    # What has not moved has not arrived, however near its goal it began.
    tolerance = min(order.tolerance or TRAVEL_TOLERANCE_M, max(abs(deeper) / 2.0, FINEST_M))
    return Go((move,), "", tolerance, joint=travel, gap=gap)
