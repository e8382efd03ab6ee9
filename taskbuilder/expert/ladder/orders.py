"""How much of an order is done: its closeness, from 0 to 1, and whether its condition is reached.

Everything is read off the current state, besides where the robot was when the order's turn came.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from taskbuilder.assets.model import Urdf
from taskbuilder.expert.ladder.script import HeldObject, LadderOrder
from taskbuilder.expert.script.handles import TURN_TOLERANCE
from taskbuilder.expert.script.joints import Joint
from taskbuilder.expert.script.pressing import DEPTH_M, TRAVEL_TOLERANCE_M
from taskbuilder.expert.script.situation import (
    DOWN,
    LOAD_TOLERANCE_M,
    TOOL_TOLERANCE_M,
    carrier_of,
    grasp_of,
)
from taskbuilder.geometry import Pose, Vec3, add, dot, from_rpy_deg, rotate, turn_between
from taskbuilder.schema.articulation import pressed
from taskbuilder.schema.expert import Together
from taskbuilder.schema.order import NOTHING, Order
from taskbuilder.schema.robots import joint_values
from taskbuilder.world.world import World

SCALE_M = 0.2
"""Distance at which a closeness is 1 - tanh(1) = 0.24, in metres; as that of `Closeness`."""

RADIUS_M = 0.05
"""An angle counts as the distance that it moves a point this far from the axis, in metres."""

TURNED = math.radians(10.0)
"""Angle within which what is to be turned counts as turned."""

HALF_OPEN = 0.5
"""Opening above which a gripper counts as open."""

Holds = Callable[[str], bool]
"""Whether a condition of the description holds now."""


@dataclass(frozen=True)
class OrderStart:
    """What was the case when the turn of an order came.

    Attributes:
        tool: Commanded position of the robot's tcp in the world, from which it retreats.
        target: Pose in the world that the order leads to, if it moves with what the robot holds.
        joint: Position of the joint that the order moves, in rad or m.
        holds: What the robot holds then, according to the script.
    """

    tool: Vec3
    target: Pose | None = None
    joint: float = 0.0
    holds: HeldObject | None = None


@dataclass(frozen=True)
class Done:
    """How much of an order is done.

    Attributes:
        closeness: From 0 to 1.
        reached: Whether the condition is reached that ends the order.
    """

    closeness: float
    reached: bool


def start_of(world: World, robot: str, order: LadderOrder, holds: HeldObject | None) -> OrderStart:
    """What is to be remembered of the moment at which the turn of an order comes."""
    place = _place(order)
    target = None
    if place is not None and isinstance(place, str) and holds is not None:
        own = carrier_of(world.scene, place).partition(".")[0] == holds.body
        target = _target(world, order, place) if own else None
    name = _joint(world, order)
    at = world.joint(name) if name else 0.0
    return OrderStart(_commanded(world, robot), target, at, holds)


def done(world: World, robot: str, order: LadderOrder, start: OrderStart, holds: Holds) -> Done:
    """How much of an order is done now."""
    tool = world.pose(f"{robot}.tcp")
    if isinstance(order, Together) or order.bring is not None:
        return _brought(world, order, start)
    if order.grasp is not None:
        gap = math.dist(tool.position, world.position(order.grasp))
        return Done(closeness(gap), world.held(order.grasp.partition(".")[0], robot))
    if order.reach is not None:
        target = start.target or _target(world, order, order.reach)
        turn = turn_between(tool.quaternion, target.quaternion) if order.rpy_deg else 0.0
        gap = math.dist(tool.position, target.position)
        return _arrived(gap, turn, order.tolerance or TOOL_TOLERANCE_M)
    if order.retreat is not None:
        moved = math.dist(tool.position, start.tool)
        rest = order.retreat - moved
        reached = rest <= min(LOAD_TOLERANCE_M, order.retreat / 2.0)
        return Done(min(moved / order.retreat, 1.0), reached)
    if order.release or order.close is not None:
        return _gripped(world, robot, order, start)
    if order.joint is not None:
        return _moved(world, order, start, holds)
    if order.push is not None:
        at, goal = world.position(order.push), _target(world, order, order.place).position
        gap = math.dist(at[:2], goal[:2])
        near = closeness(math.dist(tool.position, at))
        return Done((near + closeness(gap)) / 2.0, gap <= (order.tolerance or LOAD_TOLERANCE_M))
    if order.press is not None:
        return _pressed(world, robot, order, order.press, start)
    if order.home or order.posture is not None:
        gap = math.dist(tool.position, _posture(world, robot, order))
        return _arrived(gap, 0.0, order.tolerance or TOOL_TOLERANCE_M)
    raise NotImplementedError(f"{order.verb} says not how much of it is done")


def closeness(gap: float) -> float:
    """1 at no distance, and towards 0 with it, in metres."""
    return 1.0 - math.tanh(gap / SCALE_M)


def _place(order: LadderOrder) -> str | Vec3 | None:
    """The place that a tool or a load is taken to, if the order names one."""
    if isinstance(order, Together):
        return order.to
    if order.reach is not None:
        return order.reach
    return order.place if order.bring is not None else None


def _target(world: World, order: LadderOrder, place: str | Vec3) -> Pose:
    """The pose in the world at a place, with the order's offset."""
    at = world.pose(place) if isinstance(place, str) else Pose(place)
    shift = add(rotate(at.quaternion, order.offset), (0.0, 0.0, order.above))
    rpy_deg = order.rpy_deg if isinstance(order, Order) else None
    turn = from_rpy_deg(rpy_deg) if rpy_deg else at.quaternion
    return Pose(add(at.position, shift), turn)


def _arrived(gap: float, turn: float, tolerance: float) -> Done:
    """Of a tool or a load at a distance in metres, turned by an angle in rad, from its target."""
    return Done(closeness(gap + RADIUS_M * turn), gap <= tolerance and turn <= TURNED)


def _brought(world: World, order: LadderOrder, start: OrderStart) -> Done:
    at = world.pose(order.bring or "")
    target = start.target or _target(world, order, _place(order) or "")
    aligned = isinstance(order, Order) and order.align
    turn = turn_between(at.quaternion, target.quaternion) if aligned else 0.0
    gap = math.dist(at.position, target.position)
    return _arrived(gap, turn, order.tolerance or LOAD_TOLERANCE_M)


def _gripped(world: World, robot: str, order: Order, start: OrderStart) -> Done:
    """Of a gripper that opens or closes; one that holds from inside closes to let go."""
    gripper, opening = world.robots[robot].gripper, world.opening(robot)
    if order.close is not None:
        held = order.close == NOTHING or world.held(order.close, robot)
        return Done(1.0 - opening, held and not gripper.moves() and gripper.told() <= HALF_OPEN)
    hold = start.holds
    grasp = grasp_of(world.scene, hold.place) if hold else None
    inside = grasp is not None and grasp.inside
    free = hold is None or not world.held(hold.body, robot)
    opened = 1.0 - opening if inside else opening
    return Done(opened, free and (inside or opened > HALF_OPEN))


# --- joints


def _joint(world: World, order: LadderOrder) -> str:
    """The joint that an order moves, or ""."""
    if isinstance(order, Together):
        return ""
    if order.press is None:
        return order.joint or ""
    owner, _, link = carrier_of(world.scene, order.press).partition(".")
    asset = world.task.assets.get(owner)
    joint = pressed(asset, link) if isinstance(asset, Urdf) else None
    return f"{owner}.{joint.name}" if joint else ""


def _share(start: float, now: float, target: float, tolerance: float) -> Done:
    """Of a joint on its way; what has not moved has not arrived, however near it began."""
    whole, rest = abs(target - start), abs(target - now)
    if (target - now) * (target - start) <= 0.0:  # there, or beyond
        return Done(1.0, True)
    return Done(max(0.0, 1.0 - rest / whole), rest <= min(tolerance, whole / 2.0))


def _moved(world: World, order: Order, start: OrderStart, holds: Holds) -> Done:
    """Of a joint that is moved by its handle."""
    usual = TURN_TOLERANCE if order.turn else LOAD_TOLERANCE_M
    given = math.radians(order.tolerance_deg) if order.tolerance_deg else order.tolerance
    position = world.joint(order.joint or "")
    moved = _share(start.joint, position, order.joint_position or 0.0, given or usual)
    return Done(moved.closeness, holds(order.until)) if order.until else moved


def _pressed(world: World, robot: str, order: Order, frame: str, start: OrderStart) -> Done:
    """Of something that is pressed: half for coming near it, and half for how far it is down."""
    near = closeness(math.dist(world.position(f"{robot}.tcp"), world.position(frame)))
    name = _joint(world, order)
    if not name:
        owner = carrier_of(world.scene, frame).partition(".")[0]
        touched = owner in world.objects and world.fingers_touch(owner, robot)
        return Done((near + touched) / 2.0, touched)
    target = order.joint_position
    if target is None:
        joint = Joint(world, name)
        down = math.copysign(order.depth or DEPTH_M, dot(joint.axis(world.pose(joint.child)), DOWN))
        low, high = joint.limits
        target = min(max(start.joint + down, low), high)
    moved = _share(start.joint, world.joint(name), target, order.tolerance or TRAVEL_TOLERANCE_M)
    return Done((near + moved.closeness) / 2.0, moved.reached)


def _commanded(world: World, robot: str) -> Vec3:
    """The commanded position of a robot's tcp, in the world."""
    return _tcp_at(world, robot, world.robots[robot].commanded())


def _posture(world: World, robot: str, order: Order) -> Vec3:
    """Position of the tcp at home, or in a named posture, in the world."""
    built, joints = world.robots[robot], world.robots[robot].home
    if order.posture is not None:
        postures = world.scene.robots[robot].postures
        joints = joint_values(built.model.arm, postures[order.posture].joints_deg)
    return _tcp_at(world, robot, joints)


def _tcp_at(world: World, robot: str, joints: Sequence[float]) -> Vec3:
    """Position of the tcp in the world, for positions of the arm's joints."""
    built = world.robots[robot]
    return (built.body.pose() @ built.chain.forward(joints)).position
