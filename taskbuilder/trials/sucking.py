"""Trying suction: a cup takes plates, which are then shaken and pulled."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.geometry import Pose, norm, scale
from taskbuilder.schema.robot import SuctionSpec
from taskbuilder.shapes import BoxShape
from taskbuilder.sim.contacts import closest_distance
from taskbuilder.trials.gripping import GRAVITY, BlockGrip, displacement, swing
from taskbuilder.trials.stand import BLOCK_KG, Stand, TrialBlock
from taskbuilder.world.hands import link_points

SIZES = (1.0, 2.0, 4.0)
"""Widths of the plates, as multiples of that of the cup."""

_LEAST_M, _MOST_M, _THICK_M = 0.01, 0.1, 0.02  # of the cup, and of a plate
_BEFORE_M = 0.001  # the tcp, where a plate is, to begin with
_DRIFT_M = 1e-3  # that a cup may be in a plate, to begin with
_TAKE_S, _LIFT_S, _PULL_S = 0.2, 0.3, 2.0
_BEYOND = 1.6  # times its force to which a cup is pulled


@dataclass(frozen=True)
class SuctionTrial:
    """What was found out about a suction cup.

    Attributes:
        width: Of the cup, in metres.
        gap: From the end of its collision shape to the tcp, in metres; below 0 if the shape reaches
            beyond it.
        grips: What it does with plates; their force is 0, and their load is the pull at which they
            come off.
    """

    width: float
    gap: float
    grips: tuple[BlockGrip, ...]


def try_cup(stand: Stand, spec: SuctionSpec) -> SuctionTrial:
    """Take plates of three widths.

    Args:
        stand: The robot; its arm should be rigid.
        spec: Its suction.
    """
    width = _width(stand, spec)
    stand.at_home()
    gap = _gap(stand, width) - _BEFORE_M
    grips = tuple(_grip(stand, spec, share * width) for share in SIZES)
    return SuctionTrial(width, gap, grips)


def _width(stand: Stand, spec: SuctionSpec) -> float:
    """How wide the cup is across its axis."""
    urdf = stand.robot.model.urdf
    points = link_points(urdf, spec.cup, spec.cup, {})
    if not len(points):
        return _LEAST_M
    robot = stand.robot
    frame = robot.tcp.inverse() @ robot.body.pose_of(spec.cup)
    x, y = (np.array([frame.axis(n)[k] for n in range(3)]) for k in (0, 1))
    return float(np.clip(max(np.ptp(points @ x), np.ptp(points @ y)), _LEAST_M, _MOST_M))


def _plate(width: float) -> tuple[BoxShape, Pose]:
    return BoxShape((width, width, _THICK_M)), Pose((0.0, 0.0, _THICK_M / 2.0 + _BEFORE_M))


def _gap(stand: Stand, width: float) -> float:
    """Distance from the robot to a plate before the tcp; negative if it is in it."""
    shape, pose = _plate(width)
    with stand.block(shape, stand.robot.tcp @ pose) as block:
        gap = closest_distance(stand.robot.body, block.body, 2.0 * _MOST_M)
    return math.inf if gap is None else gap


def _grip(stand: Stand, spec: SuctionSpec, width: float) -> BlockGrip:
    stand.at_home()
    shape, pose = _plate(width)
    with stand.block(shape, stand.robot.tcp @ pose) as block:
        apart = closest_distance(stand.robot.body, block.body, 0.0)
        if apart is not None and apart < -_DRIFT_M:
            return BlockGrip(width, fits=False, held=False)
        robot = stand.robot
        robot.move_gripper(0.0)
        drive = robot.gripper.drive([(block.body, None)])
        drives = [] if drive is None else [drive]
        stand.client.step(stand.steps(_TAKE_S), drives)
        stand.client.set_gravity(GRAVITY)
        before = block.in_hand()
        stand.client.step(stand.steps(_LIFT_S), drives)
        for targets in swing(stand):
            robot.arm.pass_by(targets)
            stand.client.step(1, drives)
        slip, held = displacement(block, before), block.held()
        load = _pulled(stand, block, spec.force, drives) if held else 0.0
        robot.move_gripper(1.0)
    return BlockGrip(width, True, held, 0.0, slip, load)


def _pulled(
    stand: Stand, block: TrialBlock, force: float, drives: Sequence[Iterator[None]]
) -> float:
    """The load, with its weight, at which a plate comes off when it is pulled away from the cup."""
    count = stand.steps(_PULL_S)
    weight = BLOCK_KG * norm(GRAVITY)
    for step in range(1, count + 1):
        pull = _BEYOND * force * step / count
        block.body.push(scale(stand.robot.tcp.axis(2), pull))
        stand.client.step(1, drives)
        if not block.held():
            return pull + weight
    return math.inf
