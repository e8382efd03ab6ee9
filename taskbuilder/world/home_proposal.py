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
from functools import cached_property

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint, UrdfShape
from taskbuilder.geometry import Pose, from_rpy_deg
from taskbuilder.kinematics.chain import Chain, Floats, homogeneous
from taskbuilder.kinematics.descent import descend
from taskbuilder.kinematics.inverse import beginnings_of
from taskbuilder.world.hands import link_pose, mesh_points

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
_CLEAR_M, _CLEAR_SHARE = 0.03, 0.06  # above the base plane; of the arm's length if that is less
_APART_M, _APART_SHARE = 0.01, 0.015  # between links that are no neighbours
_LIMIT_RAD, _LIMIT_SHARE = math.radians(25.0), 0.15
_REGULAR = 0.12  # least singular value that is as good as any, with lengths in arm's lengths
_ELBOW = 0.2  # height, in arm's lengths, from which on joints are high enough
_TRIED = 60  # postures whose links are compared with each other, the best first
_MANY = 10  # of them, from which on what they share says nothing of any of them
_FEW = 3  # joints that an arm has at least
_DEEP_M = 0.1  # a root that is not on the floor, as in a torso, has shapes so far below it
_RISES_M = 0.01  # a link that never gets higher or lower than this is not for the posture to lift
_EXTREMES = 64
_STEPS = 40


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
    bodies = tuple(_bodies(urdf, arm, others))
    figures = [_Figure(chain, bodies, first) for first in dict.fromkeys((chain.base, 0))]
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


def _anyhow(figure: _Figure) -> ProposedHome:
    """A posture for a tool that cannot point down: near zero if nothing is in the way there."""
    chain = figure.chain
    zero = np.clip(np.zeros(len(chain.axes)), chain.lower, chain.upper)
    if len(zero) < _FEW:  # which has no choice
        return ProposedHome(tuple(zero.tolist()), pointing=False, clear=True)
    drawn = beginnings_of(chain, np.random.default_rng(0), _DRAWN)
    order = drawn[np.argsort(_badness(figure, drawn, 0.0), kind="stable")]
    clear = figure.first_clear(np.concatenate([zero[None], order[:_TRIED]]))
    found = zero if clear is None else clear
    return ProposedHome(tuple(found.tolist()), pointing=False, clear=clear is not None)


def _pointing(figure: _Figure, side: float) -> list[Floats]:
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


def _solved(chain: Chain, figure: _Figure, side: float) -> Iterator[Floats]:
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


def _badness(figure: _Figure, postures: Floats, side: float) -> Floats:
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


# --- what is in the way


@dataclass(frozen=True)
class _Figure:
    """An arm as convex bodies: the base, then what moves with each joint.

    Attributes:
        chain: The arm.
        bodies: For each, the outermost points of its shapes, in the frame of its joint.
        first: Index of the joint that the arm begins with; those before it carry a base.
    """

    chain: Chain
    bodies: tuple[tuple[Floats, ...], ...]
    first: int

    @cached_property
    def length(self) -> float:
        """From the first joint to the tool with the arm stretched out, and some more, in metres."""
        offsets = np.linalg.norm(self.chain.frames[1:, :3, 3], axis=1)
        travel = np.where(self.chain.revolute, 0.0, self.chain.upper - self.chain.lower)
        travel = np.where(np.isfinite(travel), travel, 0.0)[self.first :]
        return max(1e-3, float(offsets.sum() + travel.sum()))

    @cached_property
    def floor(self) -> float:
        """Height of the plane that the base stands on."""
        lowest = min((float(points[:, 2].min()) for points in self.bodies[0]), default=0.0)
        return lowest if lowest < -_DEEP_M else 0.0

    @cached_property
    def foot(self) -> Floats:
        """The point of that plane, or of one in reach above it, that lies below the first joint."""
        zero = np.clip(np.zeros(len(self.chain.axes)), self.chain.lower, self.chain.upper)
        x, y, z = self.chain.frames_at(zero)[self.first, :3, 3].tolist()
        return np.array([x, y, max(self.floor, z - 0.5 * self.length)])

    @property
    def clearance(self) -> float:
        """Least distance of links from the base plane, in metres."""
        return min(_CLEAR_M, _CLEAR_SHARE * self.length)

    def place(self, away: float, high: float, side: float) -> tuple[float, float, float]:
        """A point before the base."""
        x, y, z = self.foot.tolist()
        return x + away * math.cos(side), y + away * math.sin(side), z + high

    def lowest(self, postures: Floats) -> Floats:
        """(k,) height of the lowest point above the base plane in each of (k, n) postures.

        What no posture lifts, such as a shoulder that turns about a vertical axis, does not count.
        """
        lows = self._lows(postures)[:, self._lifted]
        return (
            np.asarray(lows.min(axis=1) - self.floor) if lows.size else np.full(len(postures), 9.0)
        )

    def first_clear(self, postures: Floats) -> Floats | None:
        """The first posture with no link below the base plane or in another one.

        Links that are in each other in all of them have shapes that are too coarse to tell.
        """
        above = postures[self.lowest(postures) >= self.clearance]
        touching = []
        for posture in above:
            touching.append(self._touching(posture))
            if not touching[-1]:
                return np.asarray(posture)
        always = frozenset.intersection(*touching) if len(touching) >= _MANY else None
        index = next((n for n, pairs in enumerate(touching) if pairs == always), None)
        return None if index is None else np.asarray(above[index])

    def _touching(self, posture: Floats) -> frozenset[tuple[int, int]]:
        placed = self._placed(posture)
        return frozenset(pair for pair in self._pairs if self._touch(placed, pair))

    @cached_property
    def _lifted(self) -> list[int]:
        lows = self._lows(beginnings_of(self.chain, np.random.default_rng(0), 40))
        return [int(k) for k in np.flatnonzero(np.ptp(lows, axis=0) > _RISES_M)]

    def _lows(self, postures: Floats) -> Floats:
        """(k, n) height of the lowest point of each body that moves."""
        frames = self.chain.frames_at(postures)[:, :-1]
        lows = np.full(frames.shape[:2], math.inf)
        for index, hulls in enumerate(self.bodies[1:]):
            if hulls:
                points = np.concatenate(hulls)
                heights = frames[:, index, 2, :3] @ points.T + frames[:, index, 2, 3:4]
                lows[:, index] = heights.min(axis=1)
        return np.where(np.isfinite(lows), lows, 9.0)

    @cached_property
    def _pairs(self) -> tuple[tuple[int, int], ...]:
        """Bodies that are no neighbours, without those that are made to be in each other."""
        solid = [index for index, hulls in enumerate(self.bodies) if hulls]
        far = [(a, b) for n, a in enumerate(solid) for b in solid[n + 3 :]]
        drawn = beginnings_of(self.chain, np.random.default_rng(1), 10)
        placed = [self._placed(one) for one in drawn]
        next_but_one = (
            pair
            for pair in zip(solid, solid[2:], strict=False)
            if not all(self._touch(each, pair) for each in placed)
        )
        return (*far, *next_but_one)

    def _placed(self, posture: Floats) -> list[list[Floats]]:
        """The points of all bodies in the frame of the root."""
        frames = [np.eye(4), *self.chain.frames_at(posture)[:-1]]
        return [
            [points @ frame[:3, :3].T + frame[:3, 3] for points in hulls]
            for frame, hulls in zip(frames, self.bodies, strict=True)
        ]

    def _touch(self, placed: list[list[Floats]], pair: tuple[int, int]) -> bool:
        apart = min(_APART_M, _APART_SHARE * self.length)
        return any(not _apart(a, b, apart) for a in placed[pair[0]] for b in placed[pair[1]])


def _bodies(
    urdf: Urdf, arm: Sequence[UrdfJoint], others: Mapping[str, float]
) -> Iterator[tuple[Floats, ...]]:
    """The shapes of the base, and of all that moves with each joint of an arm."""
    names = [joint.name for joint in arm]
    hulls: list[list[Floats]] = [[] for _ in range(len(arm) + 1)]
    solid = any(link.collisions for link in urdf.links)  # else what is only seen has to do
    for link in urdf.links:
        above = [
            names.index(j.name) for j in urdf.moving_joints_above(link.name) if j.name in names
        ]
        index = max(above, default=-1)
        frame = urdf.root if index < 0 else arm[index].child
        pose = link_pose(urdf, frame, link.name, others)
        for shape in link.collisions if solid else link.visuals:
            hulls[index + 1].append(_outermost(_outline(shape), pose @ shape.pose))
    yield from map(tuple, hulls)


def _outline(shape: UrdfShape) -> Floats:
    """Points whose hull is about the shape, in its own frame."""
    size = shape.size
    if shape.kind == "mesh" and shape.mesh is not None:
        return np.asarray(mesh_points(shape.mesh) * np.array(size))
    if shape.kind == "box":
        signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, -1).T
        return np.asarray(signs * np.array(size[:3]))
    if shape.kind == "cylinder":
        ends = _DIRECTIONS[:, :2] / np.linalg.norm(_DIRECTIONS[:, :2], axis=1)[:, None] * size[0]
        return np.column_stack([ends, np.sign(_DIRECTIONS[:, 2]) * size[1] / 2.0])
    ball = _DIRECTIONS * size[0]
    if shape.kind == "capsule":
        ball = ball + np.sign(_DIRECTIONS[:, 2:]) * np.array([0.0, 0.0, size[1] / 2.0])
    return np.asarray(ball)


def _outermost(points: Floats, pose: Pose) -> Floats:
    """Those of many points that are furthest in some direction, in the frame of the pose."""
    if len(points) > _EXTREMES:
        points = points[np.unique(np.argmax(points @ _DIRECTIONS.T, axis=0))]
    matrix = homogeneous(pose)
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def _sphere(count: int) -> Floats:
    """(count, 3) directions, evenly over the sphere."""
    number = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * number / count, math.pi * (1.0 + math.sqrt(5.0)) * number
    wide = np.sqrt(1.0 - z * z)
    return np.column_stack([wide * np.cos(turn), wide * np.sin(turn), z])


_DIRECTIONS = _sphere(_EXTREMES)


def _apart(a: Floats, b: Floats, least: float) -> bool:
    """Whether two convex hulls are at least so far apart; Gilbert's algorithm."""
    toward = a.mean(axis=0) - b.mean(axis=0)
    size = float(np.linalg.norm(toward))
    for _ in range(_STEPS):
        if size < least:
            return False
        way = toward / size
        near, far = a[int(np.argmin(a @ way))], b[int(np.argmax(b @ way))]
        support = near - far
        if float(support @ way) >= least:
            return True
        step = toward - support
        share = float(toward @ step) / max(float(step @ step), 1e-18)
        toward = toward - min(1.0, max(0.0, share)) * step
        size = float(np.linalg.norm(toward))
    return False
