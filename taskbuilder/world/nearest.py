"""The position nearest to one out of reach that an arm reaches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from taskbuilder.geometry import Pose, Vec3
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.inverse import solve

_SHARES = 20  # of the way from the arm's first joint
_ATTEMPTS = 4


def nearest_reached(chain: Chain, base: Pose, pose: Pose, start: Sequence[float]) -> Vec3 | None:
    """The first position on the way back to an arm that its tool reaches, turned as it is.

    Args:
        chain: The arm.
        base: Pose of its base link in the world.
        pose: A pose of its tool in the world that is out of reach.
        start: Joint positions to begin at, in rad or m.

    Returns:
        The position in the world, in whole centimetres; None if there is none on the way.
    """
    x, y, z = (float(value) for value in chain.frames[0][:3, 3])
    shoulder, rng = np.array(base.apply((x, y, z))), np.random.default_rng(0)
    for number in range(_SHARES - 1, 0, -1):
        at = shoulder + number / _SHARES * (np.array(pose.position) - shoulder)
        x, y, z = (round(float(value), 2) + 0.0 for value in at)
        target = base.inverse() @ Pose((x, y, z), pose.quaternion)
        if solve(chain, target, start=start, rng=rng, attempts=_ATTEMPTS).ok:
            return x, y, z
    return None
