"""Trying a gripper: it moves freely, and takes hold of blocks that are then shaken and pulled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from taskbuilder.geometry import Pose, Vec3, norm, subtract
from taskbuilder.shapes import BoxShape, CylinderShape, Shape
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.sim.divergence import JOINT_SPEED_LIMIT
from taskbuilder.trials.opening import Opening
from taskbuilder.trials.stand import BLOCK_KG, Stand, TrialBlock

GRAVITY: Vec3 = (0.0, 0.0, -9.81)
SHARES = (0.2, 0.5, 0.85)
"""Widths of the blocks, as shares of the opening between the fingers."""

MOST_PULL_N = 100.0
"""Force up to which a block is pulled, in newtons."""

_MOVE_S, _CLOSE_S, _LIFT_S, _SHAKE_S, _PULL_S = 1.5, 1.2, 0.3, 1.5, 2.0
_SHAKE_HZ = 2.0
_SHAKE_RAD, _SHAKE_M = 0.05, 0.01  # amplitude of each joint of the arm
_SLIPPED_M = 3e-3  # motion in the hand from which a pulled block has slipped
_SIDES_M = 0.012, 0.03  # the least and the greatest width of a block's other sides
_CLEAR_M = 1e-3
_DRIFT_M = 1e-3  # between block and finger, to begin with


@dataclass(frozen=True)
class Motion:
    """How a gripper moves when nothing is in its way.

    Attributes:
        seconds: From open to closed, to within 2 % of the way; infinity if it never got there.
        fastest: Highest speed of a joint, in rad/s or m/s; infinity for what is no number.
        joint: The joint that was fastest.
        left: Difference from the commanded opening at the end, as a share of the way.
        still: Highest speed of a joint at the end, in shares of the way per second.
    """

    seconds: float
    fastest: float
    joint: str
    left: float
    still: float


@dataclass(frozen=True)
class BlockGrip:
    """What a gripper does with a block.

    Attributes:
        width: Of the block, in metres.
        fits: Whether the open gripper can be around it.
        held: Whether it is held after the arm has been shaken.
        force: Mean force of the fingers on it before that, in newtons.
        slip: How far it moved in the hand meanwhile, in metres.
        load: Force in newtons with its weight, down, at which it slips; infinity for more than
            `MOST_PULL_N`.
    """

    width: float
    fits: bool
    held: bool
    force: float = 0.0
    slip: float = 0.0
    load: float = 0.0


def free_motion(stand: Stand) -> Motion:
    """Close and open the empty gripper."""
    stand.at_home()
    robot = stand.robot
    names = {joint.index: name for name, joint in robot.body.joints.items()}
    joints = robot.gripper.joints
    fastest, which, closed_s = 0.0, joints[0], math.inf
    left = still = 0.0
    for goal in (0.0, 1.0):
        robot.move_gripper(goal)
        for step in range(stand.steps(_MOVE_S)):
            stand.client.step(1)
            speeds = [_finite(speed) for speed in robot.body.joint_speeds(joints)]
            top = int(np.argmax(speeds))
            if speeds[top] > fastest:
                fastest, which = speeds[top], joints[top]
            if goal == 0.0 and math.isinf(closed_s) and abs(robot.opening()) < 0.02:
                closed_s = (step + 1) * stand.client.dt
            if fastest >= JOINT_SPEED_LIMIT:
                return Motion(math.inf, fastest, names[which], 1.0, math.inf)
        left = max(left, abs(robot.opening() - goal))
        still = max(still, *(speed / way for speed, way in _ways(stand)))
    return Motion(closed_s, fastest, names[which], left, still)


def _ways(stand: Stand) -> Iterator[tuple[float, float]]:
    """Speed and travel of the joints of the gripper that go somewhere."""
    spec = stand.robot.model.spec.gripper
    speeds = stand.robot.body.joint_speeds(stand.robot.gripper.joints)
    for speed, ends in zip(speeds, spec.joints.values() if spec else (), strict=True):
        if ends.open != ends.closed:
            yield _finite(speed), abs(ends.open - ends.closed)


def grips(stand: Stand, opened: Opening) -> Iterator[BlockGrip]:
    """Take hold of blocks of three widths.

    Args:
        stand: The robot; its arm should be rigid.
        opened: What is free between the fingers when they are open.
    """
    for share in SHARES:
        yield _grip(stand, share * opened.width, opened)


def _grip(stand: Stand, width: float, opened: Opening) -> BlockGrip:
    stand.at_home()
    side = min(max(0.35 * opened.width, _SIDES_M[0]), _SIDES_M[1])
    several = len(stand.robot.gripper.tips) > 2
    shape: Shape = CylinderShape(width / 2.0, side) if several else BoxShape((side, width, side))
    most = opened.above - width / 2.0 - _CLEAR_M
    least = -opened.below + width / 2.0 + _CLEAR_M
    y = min(max(0.0, least), most) if least <= most else (least + most) / 2.0
    with stand.block(shape, stand.robot.tcp @ Pose((0.0, y, 0.0))) as block:
        inside = closest_distance(stand.robot.body, block.body, 0.0)
        if inside is not None and inside < -_DRIFT_M:
            return BlockGrip(width, fits=False, held=False)
        return _shaken(stand, block, width)


def _shaken(stand: Stand, block: TrialBlock, width: float) -> BlockGrip:
    robot, client = stand.robot, stand.client
    robot.move_gripper(0.0)
    client.step(stand.steps(_CLOSE_S))
    forces = block.forces()
    force = sum(forces) / max(1, sum(one > 0.0 for one in forces))
    client.set_gravity(GRAVITY)
    before = block.in_hand()
    client.step(stand.steps(_LIFT_S))
    for targets in swing(stand):
        robot.arm.pass_by(targets)
        client.step(1)
    slip = displacement(block, before)
    held = block.held() and slip < width + 0.02
    load = _pulled(stand, block) if held else 0.0
    return BlockGrip(width, True, held, force, slip, load)


def swing(stand: Stand) -> Iterator[list[float]]:
    """Targets of the arm's joints that swing about home, within the limits, step by step."""
    chain, home = stand.robot.chain, np.array(stand.robot.home)
    wide = np.where(chain.revolute, _SHAKE_RAD, _SHAKE_M)
    center = np.clip(home, chain.lower + wide, chain.upper - wide)
    ways = np.minimum(wide, np.maximum(0.0, (chain.upper - chain.lower) / 2.0))
    count = stand.steps(_SHAKE_S)
    for step in range(1, count + 1):
        begun = min(1.0, 4.0 * step / count)  # without a jolt
        angle = 2.0 * math.pi * _SHAKE_HZ * step * stand.client.dt
        yield (home + begun * (center - home) + begun * ways * math.sin(angle)).tolist()


def _pulled(stand: Stand, block: TrialBlock) -> float:
    """The load, with its weight, at which a block slips when it is pulled down."""
    before, weight = block.in_hand(), BLOCK_KG * norm(GRAVITY)
    count = stand.steps(_PULL_S)
    for step in range(1, count + 1):
        pull = MOST_PULL_N * step / count
        block.body.push((0.0, 0.0, -pull))
        stand.client.step(1)
        if displacement(block, before) > _SLIPPED_M:
            return pull + weight
    return math.inf


def displacement(block: TrialBlock, before: Pose) -> float:
    """How far a block has moved in the hand, in metres; infinity for what is no number."""
    return _finite(norm(subtract(block.in_hand().position, before.position)))


def _finite(value: float) -> float:
    return abs(value) if math.isfinite(value) else math.inf
