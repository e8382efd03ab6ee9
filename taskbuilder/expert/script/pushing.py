"""Pushing an object with the closed gripper, or with a tool."""

from __future__ import annotations

from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.script.fingers import (
    FREE_M,
    close_gripper,
    closed_fingers,
    pointing_down,
    tip_boxes,
)
from taskbuilder.expert.script.situation import (
    DOWN,
    LOAD_TOLERANCE_M,
    Go,
    Phase,
    Situation,
    place_of,
)
from taskbuilder.geometry import (
    Pose,
    Quat,
    Vec3,
    add,
    cross,
    dot,
    from_axes,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
    unit,
)
from taskbuilder.schema.order import Order

BASE_M = 0.01
"""Least height of the fingertips above the underside of what they push, in metres."""


def push_phases(robot: str, order: Order, name: str) -> tuple[Phase, ...]:
    """Close, go behind an object as seen from its goal, and push it there in a straight line."""
    return (
        lambda now: close_gripper(now, robot, "push"),
        lambda now: _behind(now, robot, order, name),
        lambda now: _through(now, robot, order, name),
    )


def _goal(now: Situation, order: Order) -> Vec3:
    at = place_of(now, order.place)
    return add(at.position, rotate(at.quaternion, order.offset))


def _level(vector: Vec3) -> Vec3:
    return (vector[0], vector[1], 0.0)


def _behind(now: Situation, robot: str, order: Order, name: str) -> Go | None:
    """The motion to a place behind the object."""
    at, goal = now.pose(name), _goal(now, order)
    direction = _level(subtract(goal, at.position))
    if norm(direction) < 1e-3:
        return None
    direction = unit(direction)
    tool = now.tool(robot)
    choices = []
    for turn in _turns(tool.quaternion, direction):
        back = _reach_behind(now, robot, name, direction, turn) + FREE_M
        x, y, _ = subtract(at.position, scale(direction, back))
        place = Pose((x, y, _height(now, robot, name, turn)), turn)
        choices.append(Move({robot: Pose()}, place, speed=order.speed, touching=order.touching))
    return Go(tuple(choices))


def _turns(turn: Quat, direction: Vec3) -> tuple[Quat, ...]:
    """Orientations to push in a direction: both fingers across it; else as the tool is."""
    across = [
        from_axes(x_axis, cross(DOWN, x_axis), DOWN)
        for x_axis in (direction, scale(direction, -1.0))
    ]
    across.sort(key=lambda other: turn_between(turn, other))
    return (*across, pointing_down(turn))


def _reach_behind(now: Situation, robot: str, name: str, direction: Vec3, turn: Quat) -> float:
    """Distance along a level way from the tcp to an object's frame when the fingers touch it."""
    along = _frame_along(direction).inverse()
    at = Pose((0.0, 0.0, 0.0), now.pose(name).quaternion)
    behind = -now.world.box(name).seen_from(along @ at).low[0]
    hand = max(
        box.seen_from(along @ Pose((0.0, 0.0, 0.0), turn)).high[0]
        for box in tip_boxes(now.world.robots[robot], closed=True)
    )
    return behind + hand


def _height(now: Situation, robot: str, name: str, turn: Quat) -> float:
    """Height of the tcp: at the middle of an object, with the fingertips above its underside."""
    box = now.world.box(name).seen_from(now.pose(name))
    least = box.low[2] + BASE_M - closed_fingers(now, robot, turn).low[2]
    return max(box.center[2], least)


def _through(now: Situation, robot: str, order: Order, name: str) -> Go | None:
    """The straight motion that pushes the object to its goal."""
    at, goal, tool = now.pose(name), _goal(now, order), now.tool(robot)
    direction = _level(subtract(goal, tool.position))
    rest = _level(subtract(goal, at.position))
    if norm(rest) < 1e-3 or norm(direction) < 1e-3:
        return None
    direction = unit(direction)
    # What is touched is measured; what is not is met where the boxes do.
    off = dot(subtract(at.position, tool.position), direction)
    contact = min(off, _reach_behind(now, robot, name, direction, tool.quaternion))
    end = subtract(goal, scale(direction, contact))
    place = Pose((end[0], end[1], tool.position[2]), tool.quaternion)
    touching = (*order.touching, name)
    move = Move({robot: Pose()}, place, straight=True, speed=order.speed, touching=touching)

    def gap(situation: Situation) -> float:
        return norm(_level(subtract(goal, situation.pose(name).position)))

    pushed = Pose((goal[0], goal[1], at.position[2]), at.quaternion)
    tolerance = order.tolerance or LOAD_TOLERANCE_M
    return Go((move,), "", tolerance, pushes=(name, pushed), gap=gap)


def _frame_along(direction: Vec3) -> Pose:
    """A frame whose x axis is a level direction, and whose z axis is upright."""
    up: Vec3 = (0.0, 0.0, 1.0)
    return Pose((0.0, 0.0, 0.0), from_axes(direction, cross(up, direction), up))
