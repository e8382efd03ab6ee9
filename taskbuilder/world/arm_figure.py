"""An arm as convex bodies: which postures are above the base plane, with no link in another."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint, UrdfShape
from taskbuilder.geometry import Pose
from taskbuilder.kinematics.chain import Chain, Floats, homogeneous
from taskbuilder.kinematics.inverse import beginnings_of
from taskbuilder.world.hands import link_pose, mesh_points

_CLEAR_M, _CLEAR_SHARE = 0.03, 0.06  # above the base plane; of the arm's length if that is less
_APART_M, _APART_SHARE = 0.01, 0.015  # between links that are no neighbours
_MANY = 10  # postures, from which on what they share says nothing of any of them
_DEEP_M = 0.1  # a root that is not on the floor, as in a torso, has shapes so far below it
_RISES_M = 0.01  # a link that never gets higher or lower than this is not for the posture to lift
_EXTREMES = 64
_STEPS = 40


@dataclass(frozen=True)
class ArmFigure:
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

    def in_base(self) -> tuple[int, ...]:
        """The joints whose bodies cannot but be in the base, from 0 on, as far as shapes tell.

        The first of them turns on the base, and is such if any posture has it there.
        """
        drawn = beginnings_of(self.chain, np.random.default_rng(1), 2 * _MANY)
        placed = [self._placed(one) for one in drawn]
        found = []
        for index in range(1, len(self.bodies)):
            touching = [self._touch(each, (0, index)) for each in placed]
            if all(touching) or (index == 1 and any(touching)):
                found.append(index - 1)
        return tuple(found)

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


def bodies_of(
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
