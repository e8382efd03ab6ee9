"""Orders as sequences of motions and grips, computed when their turn comes.

An order has phases: for example, a grasp approaches, moves straight in, and closes the gripper. A
phase is computed from the current situation, so an object that has moved is grasped where it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from taskbuilder.expert.planning.planner import Move
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
from taskbuilder.schema.expert import NOTHING, Order, Together
from taskbuilder.schema.scene import Grasp, SceneSpec

APPROACH_M = 0.08
"""Default length of the straight path to a grasp point, in metres."""

TOOL_TOLERANCE_M = 0.01
LOAD_TOLERANCE_M = 0.02

DOWN: Vec3 = (0.0, 0.0, -1.0)


class Situation(Protocol):
    """The state of the scene, in the simulation or in a dry run."""

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""

    def pose(self, frame: str) -> Pose:
        """A named frame in the world."""

    def tool(self, robot: str) -> Pose:
        """The commanded pose of a robot's tcp, in the world."""

    def load(self, robot: str) -> str | None:
        """The object that a robot holds."""

    def is_open(self, robot: str) -> bool:
        """Whether a robot's gripper is open."""


@dataclass(frozen=True)
class Foreseen:
    """A predicted situation, as differences from the current one.

    Attributes:
        now: The current situation.
        moved: World poses of objects, and of links such as ``chest.lid``, that differ.
        tools: World poses of tools that differ.
        loads: Held objects, or None, of robots for which they differ.
    """

    now: Situation
    moved: Mapping[str, Pose] = field(default_factory=dict)
    tools: Mapping[str, Pose] = field(default_factory=dict)
    loads: Mapping[str, str | None] = field(default_factory=dict)

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""
        return self.now.scene

    def pose(self, frame: str) -> Pose:
        """The predicted pose of a named frame, in the world."""
        carrier = carrier_of(self.scene, frame)
        owner, _, inner = carrier.partition(".")
        at = self.now.pose(frame)
        for mover in (carrier, owner):
            if mover in self.moved:
                return self.moved[mover] @ self.now.pose(mover).inverse() @ at
        if owner in self.tools and inner == "tcp":
            return self.tools[owner] @ self.now.pose(carrier).inverse() @ at
        return at

    def tool(self, robot: str) -> Pose:
        """The predicted commanded pose of a robot's tcp, in the world."""
        return self.tools[robot] if robot in self.tools else self.now.tool(robot)

    def load(self, robot: str) -> str | None:
        """The object that a robot will hold."""
        return self.loads[robot] if robot in self.loads else self.now.load(robot)

    def is_open(self, robot: str) -> bool:
        """Whether a robot's gripper is open now."""
        return self.now.is_open(robot)


class NothingHeldError(Exception):
    """A robot has to bring an object and holds nothing."""

    def __init__(self, robot: str, thing: str) -> None:
        super().__init__(f"{robot} holds nothing that would bring {thing}")
        self.robot = robot


@dataclass(frozen=True)
class Go:
    """A motion.

    Attributes:
        choices: Equivalent moves, the nearest first.
        brings: The object that has to arrive, or "" for the tool itself.
        tolerance: Tolerance of the end position, in metres; None to continue without waiting.
    """

    choices: tuple[Move, ...]
    brings: str = ""
    tolerance: float | None = None


@dataclass(frozen=True)
class Grip:
    """A gripper opens or closes.

    Attributes:
        robot: The robot.
        opening: From 0 (closed) to 1.
        thing: The object to hold or to release; "" for none in particular.
        link: The link of the object that is held, if the task file names it; else "".
    """

    robot: str
    opening: float
    thing: str = ""
    link: str = ""


Phase = Callable[[Situation], Go | Grip | None]
"""Computes the next motion or grip; None if it is already done."""


def phases(robot: str, order: Order) -> tuple[Phase, ...]:
    """The phases of an order, in sequence."""
    if order.grasp is not None:
        point = order.grasp
        first = Grip(robot, 1.0)
        return (
            lambda now: None if now.is_open(robot) else first,
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
        thing = "" if order.close == NOTHING else order.close
        return (lambda _: Grip(robot, 0.0, thing),)
    if order.release:
        return (lambda now: Grip(robot, 1.0, now.load(robot) or ""),)
    raise NotImplementedError(f"{order.verb} has no phases")


def _take(now: Situation, robot: str, point: str) -> Grip:
    """To close a gripper at a grasp point."""
    grasp = _grasp_of(now.scene, point)
    return Grip(robot, 0.0, point.partition(".")[0], (grasp.link if grasp else None) or "")


def carrier_of(scene: SceneSpec, frame: str) -> str:
    """What a frame moves with: an object, a link as ``chest.lid``, or a frame of a robot."""
    while frame in scene.sites:
        frame = scene.sites[frame].frame
    grasp = _grasp_of(scene, frame)
    if grasp is None:
        return frame
    owner = frame.partition(".")[0]
    return owner if grasp.link is None else f"{owner}.{grasp.link}"


def _way_in(robot: str, order: Order, frame: str, usual: float) -> tuple[Phase, ...]:
    """Phases to reach a frame, with a straight path at the end if there is one."""
    way = usual if order.approach is None else order.approach
    tolerance = order.tolerance or TOOL_TOLERANCE_M

    def near(now: Situation) -> Go | None:
        goals = tool_poses(now, robot, order, frame)
        if any(_on_the_way(now.tool(robot), goal, way) for goal in goals):
            return None
        starts = tuple(goal.moved(scale(goal.axis(2), -way)) for goal in goals)
        return Go(tuple(_tool_move(robot, start, order) for start in starts))

    def there(now: Situation) -> Go:
        goals = tool_poses(now, robot, order, frame)
        if not way:
            return Go(tuple(_tool_move(robot, goal, order) for goal in goals), "", tolerance)
        return Go((_tool_move(robot, goals[0], order, straight=True),), "", tolerance)

    return (near, there) if way else (there,)


def _tool_move(robot: str, goal: Pose, order: Order, *, straight: bool = False) -> Move:
    return Move(
        {robot: Pose()},
        goal,
        straight=straight or order.straight,
        speed=order.speed,
        touching=order.touching,
    )


def _on_the_way(tool: Pose, goal: Pose, way: float) -> bool:
    """Whether a tool is already on the straight path, with the right orientation."""
    back = subtract(tool.position, goal.position)
    along = -dot(back, goal.axis(2))
    aside = norm(add(back, scale(goal.axis(2), along)))
    turned = turn_between(tool.quaternion, goal.quaternion)
    return aside < TOOL_TOLERANCE_M and 0.0 < along < 1.5 * way and turned < math.radians(5)


def _retreat(now: Situation, robot: str, order: Order) -> Go:
    tool = now.tool(robot)
    goal = tool.moved(scale(tool.axis(2), -(order.retreat or 0.0)))
    move = _tool_move(robot, goal, order, straight=True)
    return Go((move,), "", order.tolerance or TOOL_TOLERANCE_M)


# --- poses


def tool_poses(now: Situation, robot: str, order: Order, frame: str) -> tuple[Pose, ...]:
    """World poses of a robot's tcp that reach a frame, the nearest orientation first."""
    tool, at = now.tool(robot), now.pose(frame)
    shift = add(rotate(at.quaternion, order.offset), (0.0, 0.0, order.above))
    grasp = _grasp_of(now.scene, frame)
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


def _grasp_of(scene: SceneSpec, frame: str) -> Grasp | None:
    owner, _, name = frame.partition(".")
    thing = scene.objects.get(owner)
    return thing.grasps.get(name) if thing else None


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
        NothingHeldError: A robot holds nothing.
    """
    thing = order.bring or ""
    loads = {robot: now.load(robot) for robot in robots}
    for robot, load in loads.items():
        if load is None:
            raise NothingHeldError(robot, thing)
    held = thing if thing in loads.values() else str(loads[robots[0]])
    load_at, thing_at, goal = now.pose(held), now.pose(thing), _goal(now, order)
    turn = load_at.quaternion
    if align:
        turn = multiply(goal.quaternion, multiply(_inverse(thing_at), turn))
    elif len(robots) > 1:
        turn = level(turn)
    # Where the thing is in the load stays what it is, however the load is turned.
    thing_in_load = load_at.inverse().apply(thing_at.position)
    place = Pose(subtract(goal.position, rotate(turn, thing_in_load)), turn)
    carriers = {robot: load_at.inverse() @ now.tool(robot) for robot in robots}
    move = Move(
        carriers, place, straight=order.straight, speed=order.speed, touching=order.touching
    )
    return Go((move,), thing, order.tolerance or LOAD_TOLERANCE_M)


def _goal(now: Situation, order: Order | Together) -> Pose:
    at = now.pose(order.to or "")
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
