"""A home for an arm: the tool points down before the base, and nothing lies on anything.

Inverse kinematics finds postures with the tool at several places in mid reach. The best of them is
above the base plane, free of itself, away from the limits of its joints and from singularities, and
bent neither to the side nor backwards.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.geometry import Pose, from_rpy_deg
from taskbuilder.kinematics.chain import Chain, Floats, homogeneous
from taskbuilder.kinematics.descent import descend
from taskbuilder.kinematics.inverse import beginnings_of
from taskbuilder.world.arm_branches import FEW
from taskbuilder.world.arm_figure import ArmFigure, bodies_of

_AWAY = (0.25, 0.32, 0.39, 0.46, 0.53)
_HIGH = (0.1, 0.18, 0.26, 0.34, 0.45)
"""Places of the tool before the base and above its plane, as shares of the arm's length."""

_MIDDLE = 0.39, 0.24  # the place that is preferred, other things being equal
_YAWS = (0.0, 90.0, 180.0, -90.0)
_SIDES = (0.0, 90.0, -90.0, 180.0)
"""Directions of the tool from the base: to the front, unless it cannot be there."""

_REDUNDANT, _ROLL = 7, 2
"""In an arm of seven joints, the third turns the elbow about the line from shoulder to wrist."""

_BEGINNINGS, _DRAWN = 6, 200
_OFF_M, _OFF_RAD = 1e-3, math.radians(0.5)
_LIMIT_RAD, _LIMIT_SHARE = math.radians(25.0), 0.15
_REGULAR = 0.12  # least singular value that is as good as any, with lengths in arm's lengths
_ELBOW = 0.2  # height, in arm's lengths, from which on joints are high enough
_TRIED = 60  # postures whose links are compared with each other, the best first


@dataclass(frozen=True)
class ProposedHome:
    """A posture that is proposed.

    Attributes:
        joints: Positions in rad or m.
        pointing: Whether the tool points down.
        clear: Whether its links are above the base plane, and none is in another.
    """

    joints: tuple[float, ...]
    pointing: bool
    clear: bool


def find_home(
    urdf: Urdf, arm: Sequence[UrdfJoint], link: str, tcp: Pose, others: Mapping[str, float]
) -> ProposedHome:
    """The best posture that is found for an arm to begin in.

    Args:
        urdf: The robot.
        arm: The joints of its arm, from base to wrist.
        link: The link that the tool is fixed to.
        tcp: The tool's frame in that of the link.
        others: Positions of joints beyond the arm, such as those of an open gripper.
    """
    chain = Chain.of(urdf, [joint.name for joint in arm], link, tcp)
    bodies = tuple(bodies_of(urdf, arm, others))
    figures = [ArmFigure(chain, bodies, first) for first in dict.fromkeys((chain.base, 0))]
    unclear = None
    for figure, side in itertools.product(figures, np.radians(_SIDES).tolist()):
        postures = np.array(list(_pointing(figure, side)))
        if not len(postures):
            continue
        order = postures[np.argsort(_badness(figure, postures, side), kind="stable")]
        clear = figure.first_clear(order[:_TRIED])
        if clear is not None:
            return ProposedHome(tuple(clear.tolist()), pointing=True, clear=True)
        unclear = order[0] if unclear is None else unclear
    if unclear is not None:
        return ProposedHome(tuple(unclear.tolist()), pointing=True, clear=False)
    return _anyhow(figures[0])


def _anyhow(figure: ArmFigure) -> ProposedHome:
    """A posture for a tool that cannot point down: near zero if nothing is in the way there."""
    chain = figure.chain
    zero = np.clip(np.zeros(len(chain.axes)), chain.lower, chain.upper)
    if len(zero) < FEW:  # which has no choice
        return ProposedHome(tuple(zero.tolist()), pointing=False, clear=True)
    drawn = beginnings_of(chain, np.random.default_rng(0), _DRAWN)
    order = drawn[np.argsort(_badness(figure, drawn, 0.0), kind="stable")]
    clear = figure.first_clear(np.concatenate([zero[None], order[:_TRIED]]))
    found = zero if clear is None else clear
    return ProposedHome(tuple(found.tolist()), pointing=False, clear=clear is not None)


def _pointing(figure: ArmFigure, side: float) -> list[Floats]:
    """Postures in which the tool points down on one side of the base."""
    chain = figure.chain
    zero = np.clip(np.zeros(len(chain.axes)), chain.lower, chain.upper)
    base = zero[: figure.first]
    arm = chain.with_base_at(base.tolist()) if figure.first else chain
    found = [np.concatenate([base, one]) for one in _solved(arm, figure, side)]
    if len(arm.axes) == _REDUNDANT:  # with the elbow above the line from shoulder to wrist, too
        found += _solved(_locked(arm, _ROLL), figure, side)
    return found


def _locked(chain: Chain, joint: int) -> Chain:
    """An arm of which a joint stays as near zero as it can."""
    at = np.clip(0.0, chain.lower[joint], chain.upper[joint])
    there = np.arange(len(chain.axes)) == joint
    return replace(
        chain, lower=np.where(there, at, chain.lower), upper=np.where(there, at, chain.upper)
    )


def _solved(chain: Chain, figure: ArmFigure, side: float) -> Iterator[Floats]:
    """Postures of an arm with the tool at places in its reach, pointing down."""
    zero = np.clip(np.zeros(len(chain.axes)), chain.lower, chain.upper)
    drawn = beginnings_of(chain, np.random.default_rng(0), _BEGINNINGS - 1)
    beginnings = np.concatenate([zero[None], drawn])
    for away, high in itertools.product(_AWAY, _HIGH):
        place = figure.place(away * figure.length, high * figure.length, side)
        for yaw in _YAWS:
            turn = from_rpy_deg((180.0, 0.0, math.degrees(side) + yaw))
            goal = homogeneous(Pose(place, turn))
            for found in descend(chain, goal, beginnings):
                if _arrived(chain, found, goal):
                    yield _nearest_zero(chain, found)


def _arrived(chain: Chain, joints: Floats, goal: Floats) -> bool:
    tool = chain.frames_at(joints)[-1]
    turned = (np.trace(tool[:3, :3].T @ goal[:3, :3]) - 1.0) / 2.0
    off = float(np.linalg.norm(tool[:3, 3] - goal[:3, 3]))
    return off <= _OFF_M and math.acos(min(1.0, max(-1.0, float(turned)))) <= _OFF_RAD


def _nearest_zero(chain: Chain, joints: Floats) -> Floats:
    """The same posture, with joints that turn on the full turn within limits nearest to zero."""
    turn = 2.0 * math.pi
    least, most = np.ceil((chain.lower - joints) / turn), np.floor((chain.upper - joints) / turn)
    turns = np.clip(np.round(-joints / turn), least, most)
    return np.where(chain.revolute, joints + turn * turns, joints)


# --- what is good


def _badness(figure: ArmFigure, postures: Floats, side: float) -> Floats:
    """(k,) how far each of (k, n) postures is from what is wanted of a home."""
    chain, length = figure.chain, figure.length
    frames = chain.frames_at(postures)
    jacobian = chain.jacobian(frames)
    jacobian[:, :3] /= length
    least = np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    from_base = frames[..., :3, 3] - figure.foot
    ahead = from_base @ np.array([math.cos(side), math.sin(side), 0.0]) / length
    aside = from_base @ np.array([-math.sin(side), math.cos(side), 0.0]) / length
    height = from_base[..., 2] / length
    turned = np.where(chain.revolute, np.abs(postures) / math.pi, 0.0)
    elbow = height[:, 2:-1].min(axis=1, initial=_ELBOW)
    total = (
        2.0 * np.square(_near_limits(chain, postures)).sum(axis=1)
        + 2.0 * np.square(np.maximum(0.0, 1.0 - least / _REGULAR))
        + 2.0 * (1.0 - elbow / _ELBOW)
        + 4.0 * np.maximum(0.0, -ahead).max(axis=1)
        + 2.0 * np.abs(aside).max(axis=1)
        - 1.0 * height[:, :-1].mean(axis=1)
        + 5.0 * np.square(ahead[:, -1] - _MIDDLE[0])
        + 5.0 * np.square(height[:, -1] - _MIDDLE[1])
        + 0.3 * turned.mean(axis=1)
    )
    return np.asarray(total, np.float64)


def _near_limits(chain: Chain, postures: Floats) -> Floats:
    """(k, n) how near each joint is to a limit: 0 far away, 1 at it."""
    wide = _LIMIT_SHARE * (chain.upper - chain.lower)
    wide = np.maximum(np.where(chain.revolute, np.minimum(wide, _LIMIT_RAD), wide), 1e-9)
    left = np.minimum(postures - chain.lower, chain.upper - postures)
    near = np.zeros_like(postures)
    limited = np.isfinite(left) & np.isfinite(wide)
    np.divide(left, wide, out=near, where=limited)
    return np.where(limited, np.clip(1.0 - near, 0.0, 1.0), 0.0)
