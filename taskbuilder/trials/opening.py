"""How far a gripper is open, measured on the shapes that the engine collides with."""

from __future__ import annotations

import math
from dataclasses import dataclass

from taskbuilder.geometry import Pose
from taskbuilder.shapes import BoxShape, CylinderShape, Part
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import gaps
from taskbuilder.trials.stand import Stand

_FACE_M, _THIN_M = 0.01, 0.001  # of the feeler that is moved towards the fingers
_NEAR_M = 1e-4  # at which it counts as touching
_FARTHEST_M = 0.5  # beyond which no finger is looked for
_STEPS, _TRIES = 200, 20


@dataclass(frozen=True)
class Opening:
    """What is free between fingers, along the y axis of the tcp, in metres.

    Attributes:
        below: From the tcp to the finger on the side of -y; infinity if there is none.
        above: From the tcp to the finger on the side of +y.
    """

    below: float
    above: float

    @property
    def width(self) -> float:
        """Between the fingers; infinity where one is missing."""
        return max(0.0, self.below + self.above)

    @property
    def centered(self) -> float:
        """Width of the widest block that fits with its middle at the tcp."""
        return max(0.0, 2.0 * min(self.below, self.above))


def widest(stand: Stand) -> Opening:
    """What is free between the fingers when the gripper is open.

    A jaw that turns swings past the tcp. It is felt for where it is still beside it, or when the
    gripper is open if it never is.
    """
    for number in range(_TRIES):
        found = measure(stand, 1.0 - number / _TRIES)
        if math.isfinite(found.width) and min(found.below, found.above) > 0.0:
            return found
    return measure(stand, 1.0)


def measure(stand: Stand, opening: float) -> Opening:
    """Put the gripper at an opening, past all motors, and feel for its fingers from the tcp.

    Two fingers are felt for with a plate of 10 mm that faces them; more than two with a thin rod
    along the z axis, which is the axis of the widest cylinder that fits.

    Args:
        stand: The robot, which is left at that opening.
        opening: From 0 (closed) to 1 (open).
    """
    robot = stand.robot
    robot.body.put_joints(_positions(stand, opening))
    if len(robot.gripper.tips) > 2:
        rod = _feeler(stand, CylinderShape(_THIN_M / 2.0, _FACE_M))
        free = _distance(stand, rod, 0.0) + _THIN_M / 2.0
        found = Opening(free, free)
    else:
        plate = _feeler(stand, BoxShape((_FACE_M, _THIN_M, _FACE_M)))
        found = Opening(*(_free(stand, plate, side) for side in (-1.0, 1.0)))
    return found


def _positions(stand: Stand, opening: float) -> dict[str, float]:
    spec = stand.robot.model.spec.gripper
    joints = spec.joints.items() if spec is not None else ()
    return {name: end.closed + opening * (end.open - end.closed) for name, end in joints}


def _feeler(stand: Stand, shape: BoxShape | CylinderShape) -> Body:
    part = Part(shape, Pose(), (1.0, 1.0, 1.0, 1.0))
    away = Pose((0.0, 0.0, -10.0))
    return create_body(stand.client, {"feeler": part}, pose=away)


def _free(stand: Stand, plate: Body, side: float) -> float:
    """How far a plate gets from the tcp; a distance never leads past a finger."""
    at = 0.0
    for _ in range(_STEPS):
        gap = _distance(stand, plate, side * at)
        if not math.isfinite(gap):
            return math.inf
        if gap <= _NEAR_M:
            return at + _THIN_M / 2.0 if at else min(0.0, gap)
        at += gap
        if at > _FARTHEST_M:
            return math.inf
    return at


def _distance(stand: Stand, feeler: Body, y: float) -> float:
    """Distance of a feeler from the nearest finger, on the y axis of the tcp."""
    robot = stand.robot
    feeler.place(robot.tcp @ Pose((0.0, y, 0.0)))
    tips = set(robot.tip_links)
    found = [near for near in gaps(robot.body, feeler, _FARTHEST_M) if near.link_a in tips]
    feeler.place(Pose((0.0, 0.0, -10.0)))
    return min((near.distance for near in found), default=math.inf)
