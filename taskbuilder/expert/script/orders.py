"""Orders as sequences of motions and grips, computed when their turn comes.

An order has phases: for example, a grasp approaches, moves straight in, and closes the gripper. A
phase is computed from the current situation, so an object that has moved is grasped where it is.
"""

from __future__ import annotations

import math

from taskbuilder.expert.planning.planner import Move
from taskbuilder.expert.script.handles import move_joint
from taskbuilder.expert.script.pressing import press_phases
from taskbuilder.expert.script.pushing import push_phases
from taskbuilder.expert.script.situation import (
    DOWN,
    LOAD_TOLERANCE_M,
    TOOL_TOLERANCE_M,
    Go,
    Grip,
    NotHeldError,
    Phase,
    Situation,
    grasp_of,
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
    from_rpy_deg,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    turn_between,
    unit,
)
from taskbuilder.schema.bodies import Grasp
from taskbuilder.schema.expert import Together
from taskbuilder.schema.grasping import grasping
from taskbuilder.schema.order import NOTHING, Order
from taskbuilder.schema.robots import joint_values

HALF_OPEN = 0.5
"""Commanded opening above which a gripper holds what it holds from inside."""

APPROACH_M = 0.08
"""Default length of the straight path to a grasp point, in metres."""


def phases(robot: str, order: Order) -> tuple[Phase, ...]:
    """The phases of an order, in sequence."""
    if order.grasp is not None:
        point = order.grasp
        return (
            lambda now: _ready(now, robot, point),
            *_way_in(robot, order, point, APPROACH_M),
            lambda now: _take(now, robot, point),
        )
    if order.reach is not None:
        return _way_in(robot, order, order.reach, 0.0)
    if order.bring is not None:
        return (lambda now: bring(now, (robot,), order, align=order.align),)
    if order.retreat is not None:
        return (lambda now: _retreat(now, robot, order),)
    if order.close is not None:
        name = "" if order.close == NOTHING else order.close
        return (lambda _: Grip(robot, 0.0, name),)
    if order.release:
        return (lambda now: _let_go(now, robot),)
    if order.joint is not None:
        return (lambda now: move_joint(now, robot, order),)
    if order.push is not None:
        return push_phases(robot, order, order.push)
    if order.press is not None:
        return press_phases(robot, order, order.press)
    if order.home or order.posture is not None:
        return (lambda now: _posture(now, robot, order),)
    raise NotImplementedError(f"{order.verb} has no phases")


def _ready(now: Situation, robot: str, point: str) -> Grip | None:
    """To open a gripper before it is at a grasp point, or to close it if it is to go inside."""
    if _from_inside(now, robot, point):
        return Grip(robot, 0.0)
    return None if now.is_open(robot) else Grip(robot, 1.0)


def _take(now: Situation, robot: str, point: str) -> Grip:
    """To close a gripper at a grasp point, or to open it inside."""
    grasp = grasp_of(now.scene, point)
    link = (grasp.link if grasp else None) or ""
    name, inside = point.partition(".")[0], _from_inside(now, robot, point)
    return Grip(robot, 1.0 if inside else 0.0, name, link, inside)


def _let_go(now: Situation, robot: str) -> Grip:
    """To open a gripper, or to close it if it holds something from inside."""
    load = now.load(robot) or ""
    inside = bool(load) and now.world.robots[robot].gripper.told() > HALF_OPEN
    return Grip(robot, 0.0 if inside else 1.0, load, inside=inside)


def _from_inside(now: Situation, robot: str, point: str) -> bool:
    grasp = grasp_of(now.scene, point)
    how = grasping(now.scene.robots[robot], now.world.robots[robot].model)
    return grasp is not None and grasp.inside and how is not None and how.rule == "friction"


def _way_in(robot: str, order: Order, frame: str | Vec3, usual: float) -> tuple[Phase, ...]:
    """Phases to reach a frame, with a straight path at the end if there is one."""
    approach = usual if order.approach is None else order.approach
    tolerance = order.tolerance or TOOL_TOLERANCE_M

    def near(now: Situation) -> Go | None:
        goals = tool_poses(now, robot, order, frame)
        if any(_on_the_way(now.tool(robot), goal, approach) for goal in goals):
            return None
        starts = tuple(goal.moved(scale(goal.axis(2), -approach)) for goal in goals)
        return Go(tuple(_tool_move(robot, start, order) for start in starts))

    def there(now: Situation) -> Go:
        goals = tool_poses(now, robot, order, frame)
        if not approach:
            return Go(tuple(_tool_move(robot, goal, order) for goal in goals), "", tolerance)
        return Go((_tool_move(robot, goals[0], order, straight=True),), "", tolerance)

    return (near, there) if approach else (there,)


def _tool_move(robot: str, goal: Pose, order: Order, *, straight: bool = False) -> Move:
    return Move(
        {robot: Pose()},
        goal,
        straight=straight or order.straight,
        speed=order.speed,
        touching=order.touching,
    )


def _on_the_way(tool: Pose, goal: Pose, approach: float) -> bool:
    """Whether a tool is already on the straight path, with the right orientation."""
    back = subtract(tool.position, goal.position)
    along = -dot(back, goal.axis(2))
    aside = norm(add(back, scale(goal.axis(2), along)))
    turned = turn_between(tool.quaternion, goal.quaternion)
    return aside < TOOL_TOLERANCE_M and 0.0 < along < 1.5 * approach and turned < math.radians(5)


def _retreat(now: Situation, robot: str, order: Order) -> Go:
    tool = now.tool(robot)
    goal = tool.moved(scale(tool.axis(2), -(order.retreat or 0.0)))
    move = _tool_move(robot, goal, order, straight=True)
    return Go((move,), "", order.tolerance or TOOL_TOLERANCE_M)


def _posture(now: Situation, robot: str, order: Order) -> Go:
    """The motion to home or to a named posture: of the joints, or of the tool that they give."""
    built, entry = now.world.robots[robot], now.scene.robots[robot]
    joints = built.home
    if order.posture is not None:
        joints = joint_values(built.model.arm, entry.postures[order.posture].joints_deg)
    move = Move(
        {robot: Pose()},
        entry.base.pose @ built.chain.forward(joints),
        speed=order.speed,
        touching=order.touching,
        joints=joints,
    )
    return Go((move,), "", order.tolerance or TOOL_TOLERANCE_M)


# --- poses


def tool_poses(now: Situation, robot: str, order: Order, frame: str | Vec3) -> tuple[Pose, ...]:
    """World poses of a robot's tcp that reach a frame, the nearest orientation first."""
    tool, at = now.tool(robot), place_of(now, frame)
    shift = add(rotate(at.quaternion, order.offset), (0.0, 0.0, order.above))
    grasp = grasp_of(now.scene, frame) if isinstance(frame, str) else None
    if order.rpy_deg is not None:
        turns: tuple[Quat, ...] = (from_rpy_deg(order.rpy_deg),)
    elif grasp is not None:
        turn = grasp_turn(grasp, at)
        half = (0.0, 0.0, 1.0, 0.0)  # about the approach: fingers are alike
        turns = (turn, multiply(turn, half))
    else:
        turns = (tool.quaternion,)
    near_first = sorted(turns, key=lambda turn: turn_between(tool.quaternion, turn))
    return tuple(Pose(add(at.position, shift), turn) for turn in near_first)


def grasp_turn(grasp: Grasp, body: Pose) -> Quat:
    """The orientation of a tool that grasps a body at a grasp point.

    Args:
        grasp: The grasp point.
        body: Pose of the body in the world.
    """
    axes = [body.axis(index) for index in range(3)]
    if grasp.approach == "down":
        approach = DOWN
    else:
        sign = 1.0 if grasp.approach[0] == "+" else -1.0
        approach = scale(axes["xyz".index(grasp.approach[1])], sign)
    wanted = "xyz".index(grasp.across)
    # The fingers close at right angles to the approach; an axis along it says nothing of how.
    for axis in (axes[wanted], *axes):
        closing = subtract(axis, scale(approach, dot(axis, approach)))
        if norm(closing) > 0.1:
            break
    closing = unit(closing)
    return from_axes(cross(closing, approach), closing, approach)


# --- loads


def bring(
    now: Situation, robots: tuple[str, ...], order: Order | Together, *, align: bool = False
) -> Go:
    """The motion in which robots bring a shared load, until an object is at its goal.

    The object may be the load, or lie on it. A load of several robots is kept level.

    Raises:
        NotHeldError: A robot holds nothing.
    """
    name = order.bring or ""
    loads = {robot: now.load(robot) for robot in robots}
    for robot, load in loads.items():
        if load is None:
            raise NotHeldError(robot, f"holds nothing and cannot bring {name}")
    held = name if name in loads.values() else str(loads[robots[0]])
    load_at, object_at, goal = now.pose(held), now.pose(name), _goal(now, order)
    turn = load_at.quaternion
    if align:
        turn = multiply(goal.quaternion, multiply(_inverse(object_at), turn))
    elif len(robots) > 1:
        turn = level(turn)
    # Where the thing is in the load stays what it is, however the load is turned.
    thing_in_load = load_at.inverse().apply(object_at.position)
    place = Pose(subtract(goal.position, rotate(turn, thing_in_load)), turn)
    carriers = {robot: load_at.inverse() @ now.tool(robot) for robot in robots}
    move = Move(
        carriers, place, straight=order.straight, speed=order.speed, touching=order.touching
    )
    return Go((move,), name, order.tolerance or LOAD_TOLERANCE_M)


def _goal(now: Situation, order: Order | Together) -> Pose:
    at = place_of(now, order.place if isinstance(order, Order) else order.to)
    return at.moved(add(rotate(at.quaternion, order.offset), (0.0, 0.0, order.above)))


def _inverse(pose: Pose) -> Quat:
    return pose.inverse().quaternion


def level(turn: Quat) -> Quat:
    """The nearest orientation in which the most vertical axis is exactly vertical."""
    pose = Pose((0.0, 0.0, 0.0), turn)
    axis = max((pose.axis(index) for index in range(3)), key=lambda a: abs(a[2]))
    up: Vec3 = (0.0, 0.0, math.copysign(1.0, axis[2]))
    about = cross(axis, up)
    sine = norm(about)
    if sine < 1e-9:
        return turn
    half = 0.5 * math.atan2(sine, dot(axis, up))
    x, y, z = scale(about, math.sin(half) / sine)
    return multiply((x, y, z, math.cos(half)), turn)
