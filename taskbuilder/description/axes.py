"""Axes of a frame, with a sign."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, get_args

from taskbuilder.geometry import Pose, Vec3

SignedAxis = Literal["x", "y", "z", "-x", "-y", "-z"]
"""An axis of a frame, or the direction opposite to it."""


def direction(pose: Pose, axis: SignedAxis) -> Vec3:
    """The unit vector of an axis of a pose, in the frame in which the pose is given."""
    x, y, z = pose.axis("xyz".index(axis[-1]))
    return (-x, -y, -z) if axis.startswith("-") else (x, y, z)


def tilt_deg(pose: Pose, axis: SignedAxis) -> float:
    """The angle between an axis of a pose and the z axis of its frame, in degrees."""
    return math.degrees(math.acos(max(-1.0, min(1.0, direction(pose, axis)[2]))))


def axis_problems(axis: str) -> Iterator[str]:
    """What is wrong with an axis that somebody wrote."""
    if axis not in get_args(SignedAxis):
        yield f"axis is {axis!r}; one of {', '.join(get_args(SignedAxis))}"
