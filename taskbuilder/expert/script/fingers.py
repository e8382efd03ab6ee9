"""Closed fingers, or a tool, with which something is pushed or pressed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from taskbuilder.expert.script.situation import (
    DOWN,
    Grip,
    NotHeldError,
    Situation,
)
from taskbuilder.geometry import (
    Box,
    Pose,
    Quat,
    add,
    cross,
    dot,
    multiply,
    norm,
    rotate,
    scale,
)
from taskbuilder.world.robot import Robot
from taskbuilder.world.shapes import link_box

FREE_M = 0.02
"""Distance from which the gripper goes straight to what it pushes or presses, in metres."""


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


def close_gripper(now: Situation, robot: str, verb: str) -> Grip | None:
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


def closed_fingers(now: Situation, robot: str, turn: Quat) -> Box:
    """The closed fingers, about the tcp, along the axes of the world."""
    boxes = [
        box.seen_from(Pose((0.0, 0.0, 0.0), turn))
        for box in tip_boxes(now.world.robots[robot], closed=True)
    ]
    low = [min(box.low[i] for box in boxes) for i in range(3)]
    high = [max(box.high[i] for box in boxes) for i in range(3)]
    return Box.around((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def pointing_down(turn: Quat) -> Quat:
    """The nearest orientation in which a tool points straight down."""
    axis = rotate(turn, (0.0, 0.0, 1.0))
    about = cross(axis, DOWN)
    sine, cosine = norm(about), dot(axis, DOWN)
    if sine < 1e-9:
        return turn if cosine > 0.0 else multiply((1.0, 0.0, 0.0, 0.0), turn)
    half = 0.5 * math.atan2(sine, cosine)
    x, y, z = scale(about, math.sin(half) / sine)
    return multiply((x, y, z, math.cos(half)), turn)
