"""How large an object is, where fingers can take it from above, and where a suction cup can.

Sizes are measured on the surfaces by which it collides. A gripper comes from above, and its fingers
close along one of two level axes. An object that does not lie as its own frame has it is measured
as it lies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.model import Urdf
from taskbuilder.geometry import ORIGIN, Pose, Vec3
from taskbuilder.schema.object_files import ObjectModel, as_placed
from taskbuilder.shapes import (
    AT_ORIGIN,
    BoxShape,
    CapsuleShape,
    CylinderShape,
    Shape,
    SphereShape,
    mesh_corners,
    solid,
)
from taskbuilder.world.hands import link_pose
from taskbuilder.world.shapes import parts_of, urdf_shape

Floats = NDArray[np.float64]
Axis = Literal["x", "y", "z"]

WIDEST_M = 0.08
"""Opening that a point needs at most to be proposed; most grippers of the library open further."""

FINGER_M, TIP_M = 0.024, 0.022
"""Width of a finger, and how far it reaches below the tcp, of most grippers of the library."""

_SPARE_M = 0.006  # that a gripper opens further than the object is wide
_DEEPEST_M = 0.03  # that the tcp gets below the top of an object
_OVER_M = 0.006  # and at most above the top, where its fingertips still touch
_LIFT_M = 0.004  # that fingertips stay above the table
_THINNEST_M = 0.002
_PARTS, _EVEN = 3, 0.7  # of what a finger touches; each is at least so wide beside the widest
_STEEPEST = 0.45  # slope along the other axis up to which fingers do not slip off
_OFF = 1.5  # how much a metre from the middle weighs against a metre of opening
_CONTACT_M = 0.012, 0.008  # that a finger touches below and above the tcp
_LONG_M = 0.12  # from which on an object has ends for two grippers
_ENDS = 0.08, 0.3  # where these are, as shares of its length
_PLACES, _SAMPLES, _TURNS = 25, 40_000, 32
_FLAT_M = 0.0015
_ROOM_M, _WALL_M = 0.05, 0.01  # around a suction cup nothing is so much higher
_RADII = tuple(np.arange(0.004, 0.0501, 0.002).tolist())


@dataclass(frozen=True)
class FingerHold:
    """Where fingers can take hold of an object from above.

    Attributes:
        at: In the frame of the object, in metres.
        across: The axis along which they close.
        width: Of the object there, in metres.
        opening: What a gripper whose middle is at the point has to open for it, in metres.
        depth: Height of the point above the lowest point of the object as it lies, in metres.
    """

    at: Vec3
    across: Axis
    width: float
    opening: float
    depth: float

    @property
    def low(self) -> bool:
        """Whether the fingertips of some grippers of the library would meet the table."""
        return self.depth < TIP_M + _LIFT_M / 2.0


@dataclass(frozen=True)
class Flat:
    """A level place on top of an object.

    Attributes:
        at: Its middle, in the frame of the object.
        radius: Of the largest disc about it that is level, in metres.
    """

    at: Vec3
    radius: float


@dataclass(frozen=True)
class Surfaces:
    """An object as surfaces.

    Attributes:
        triangles: (n, 3, 3) corners as it lies, in metres.
        center: Centre of mass with uniform density, as it lies.
        moves: Whether it has joints that move.
        turn: The orientation of its own frame as it lies.
    """

    triangles: Floats
    center: Vec3
    moves: bool = False
    turn: Pose = AT_ORIGIN

    @classmethod
    def of(cls, model: ObjectModel) -> Surfaces:
        """The surfaces by which an object of the catalogue collides."""
        pieces = list(_pieces(model))
        volumes = [solid(shape).volume for shape, _ in pieces]
        middles = np.array([(pose @ solid(shape).principal).position for shape, pose in pieces])
        x, y, z = (np.array(volumes) @ middles / sum(volumes)).tolist()
        main = model.assets.main
        moves = isinstance(main, Urdf) and bool(main.moving_joints)
        return cls(np.concatenate([_placed(*piece) for piece in pieces]), (x, y, z), moves)

    def lying(self, rpy_deg: Vec3) -> Surfaces:
        """The same in another orientation of its own frame, in degrees."""
        turn = Pose.from_rpy_deg(ORIGIN, rpy_deg)
        axes = np.array([turn.axis(index) for index in range(3)])
        return replace(
            self, triangles=self.triangles @ axes, center=turn.apply(self.center), turn=turn
        )

    @cached_property
    def low(self) -> Floats:
        """(3,) the smallest coordinates."""
        return np.asarray(self.triangles.min(axis=(0, 1)))

    @cached_property
    def high(self) -> Floats:
        """(3,) the largest coordinates."""
        return np.asarray(self.triangles.max(axis=(0, 1)))

    @property
    def size(self) -> Vec3:
        """Edge lengths of its bounding box, in metres."""
        x, y, z = (self.high - self.low).tolist()
        return x, y, z

    def hold(self, way: int, between: tuple[float, float] = (0.0, 1.0)) -> FingerHold | None:
        """The best place for fingers that close along a level axis, near the centre of mass.

        Args:
            way: The axis: 0 or 1, x or y as it lies.
            between: Range along the other axis to search, as shares of the size along it.
        """
        along = 1 - way
        low, high = self.low[along], self.high[along]
        first, last = (low + share * (high - low) for share in between)
        middle = self.center[along] if between == (0.0, 1.0) else (first + last) / 2.0
        best, least = None, math.inf
        for at in np.linspace(first, last, _PLACES).tolist():
            found = self._hold_at(way, at)
            if found is None:
                continue
            cost = found.opening + _OFF * abs(at - middle)
            if cost < least:
                best, least = found, cost
        return best

    def holds(self, widest: float = WIDEST_M) -> dict[str, FingerHold]:
        """Grasp points by name: one near the centre of mass, and two at the ends of what is long.

        There are none for an object with joints, whose links move apart.

        Args:
            widest: What a gripper opens at most, in metres.
        """
        if self.moves:
            return {}
        each = [hold for way in (1, 0) if (hold := self.hold(way)) and hold.opening <= widest]
        found = {"grasp": min(each, key=lambda hold: round(hold.opening, 2))} if each else {}
        along = 0 if self.size[0] >= self.size[1] else 1
        if self.size[along] >= _LONG_M:
            first, last = _ENDS
            parts = {"left_end": (first, last), "right_end": (1.0 - last, 1.0 - first)}
            for name, between in parts.items():
                hold = self.hold(1 - along, between)
                if hold is not None and hold.opening <= widest:
                    found[name] = hold
        return found

    def flat(self) -> Flat | None:
        """The largest level place on top, near the centre of mass; None if there is none."""
        found: list[Flat] = []
        for x in self.center[0] + np.linspace(-0.25, 0.25, 5) * self.size[0]:
            for y in self.center[1] + np.linspace(-0.25, 0.25, 5) * self.size[1]:
                found += self._flat_at(float(x), float(y))
        middle = self._own(self.center)
        return max(
            found, key=lambda one: one.radius - 0.2 * math.dist(one.at, middle), default=None
        )

    def _flat_at(self, x: float, y: float) -> Iterator[Flat]:
        (top,) = self._tops(np.array([[x, y]])).tolist()
        if not math.isfinite(top):
            return
        turns = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
        ring = np.column_stack([np.cos(turns), np.sin(turns)])
        points = np.array([x, y]) + np.array(_RADII)[:, None, None] * ring
        tops = self._tops(points.reshape(-1, 2)).reshape(len(_RADII), -1)
        if (tops[np.array(_RADII) <= _ROOM_M] > top + _WALL_M).any():
            return  # a cup does not get in between the walls of a mug
        level = (np.abs(tops - top) <= _FLAT_M).all(axis=1)
        count = len(level) if level.all() else int(np.argmin(level))
        if count:
            yield Flat(self._own((x, y, top)), _RADII[count - 1])

    def _tops(self, points: Floats) -> Floats:
        """(n,) height of the highest surface over (n, 2) points; minus infinity beside it."""
        a, b, c = (self.triangles[:, k, :] for k in range(3))
        tops = np.full(len(points), -math.inf)
        cross = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (
            c[:, 0] - a[:, 0]
        )
        level = np.abs(cross) > 1e-14
        a, b, c, cross = a[level], b[level], c[level], cross[level]
        for index, (x, y) in enumerate(points.tolist()):
            one = ((b[:, 0] - x) * (c[:, 1] - y) - (b[:, 1] - y) * (c[:, 0] - x)) / cross
            two = ((c[:, 0] - x) * (a[:, 1] - y) - (c[:, 1] - y) * (a[:, 0] - x)) / cross
            three = 1.0 - one - two
            over = (one >= -1e-9) & (two >= -1e-9) & (three >= -1e-9)
            if over.any():
                heights = one * a[:, 2] + two * b[:, 2] + three * c[:, 2]
                tops[index] = heights[over].max()
        return tops

    def _hold_at(self, way: int, at: float) -> FingerHold | None:
        """The place for fingers at a coordinate of the axis along which they do not close."""
        near = self._points[np.abs(self._points[:, 1 - way] - at) <= FINGER_M / 2.0]
        if len(near) < 4:
            return None
        top, bottom = float(near[:, 2].max()), float(self.low[2])
        height = max(bottom + TIP_M + _LIFT_M, top - _DEEPEST_M, (top + near[:, 2].min()) / 2.0)
        height = min(height, top + _OVER_M)
        touched = near[_touches(near, height)][:, way]
        beside = near[near[:, 2] >= height - TIP_M][:, way]
        if len(touched) < 4 or self._slant(near, way, at, height) > _STEEPEST:
            return None
        middle = float(touched.max() + touched.min()) / 2.0
        opening = 2.0 * max(float(beside.max()) - middle, middle - float(beside.min()))
        x, y = (at, middle) if way else (middle, at)
        place, width = self._own((x, y, float(height))), float(np.ptp(beside))
        return FingerHold(place, self._axis(way), width, opening + _SPARE_M, height - bottom)

    def _own(self, point: Vec3) -> Vec3:
        """A point in the frame of the object."""
        return self.turn.inverse().apply(point)

    def _axis(self, way: int) -> Axis:
        """The axis of the object that is nearly along a level one."""
        return max(_AXES, key=lambda axis: abs(self.turn.axis(_AXES.index(axis))[way]))

    def _slant(self, near: Floats, way: int, at: float, height: float) -> float:
        """By how much what a finger touches leans along the other axis, as a slope.

        It is infinite where it is not about as wide everywhere, such as at the edge of a disc.
        """
        level = near[_touches(near, height)]
        step = FINGER_M / _PARTS
        ends = []
        for number in range(_PARTS):
            past = level[:, 1 - way] - (at - FINGER_M / 2.0 + number * step)
            inside = level[(past >= 0.0) & (past <= step), way]
            if len(inside) < 2:
                return math.inf
            ends.append((float(inside.min()), float(inside.max())))
        widths = [high - low for low, high in ends]
        if max(widths) < _THINNEST_M or min(widths) < _EVEN * max(widths):
            return math.inf
        (low, high), (last_low, last_high) = ends[0], ends[-1]
        return abs(last_low + last_high - low - high) / 2.0 / (FINGER_M - step)

    @cached_property
    def _points(self) -> Floats:
        """(n, 3) points spread over the surfaces, and their corners."""
        a, b, c = (self.triangles[:, k, :] for k in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        rng = np.random.default_rng(0)
        chosen = rng.choice(len(areas), _SAMPLES, p=areas / areas.sum())
        one, two = rng.random((2, _SAMPLES))
        over = one + two > 1.0
        one[over], two[over] = 1.0 - one[over], 1.0 - two[over]
        spread = a[chosen] + one[:, None] * (b - a)[chosen] + two[:, None] * (c - a)[chosen]
        return np.concatenate([spread, self.triangles.reshape(-1, 3)])


_AXES: tuple[Axis, ...] = ("x", "y", "z")


def _touches(points: Floats, height: float) -> NDArray[np.bool_]:
    """Which points are where fingers press whose tcp is at a height."""
    below, above = _CONTACT_M
    return np.asarray((points[:, 2] >= height - below) & (points[:, 2] <= height + above))


def _pieces(model: ObjectModel) -> Iterator[tuple[Shape, Pose]]:
    """The shapes by which an object collides, in its frame."""
    main, spec = model.assets.main, as_placed(model.spec)
    if not isinstance(main, Urdf):
        for part in parts_of(spec, main, model.assets.collision).values():
            yield part.shape, part.pose
        return
    size = (spec.shape.scale if spec.shape else None) or 1.0
    starts = {
        joint.name: spec.joint(joint.name, turns=joint.type != "prismatic").begin or 0.0
        for joint in main.moving_joints
    }
    for link in main.links:
        frame = link_pose(main, main.root, link.name, starts)
        for shape in link.collisions or link.visuals:
            pose = frame @ shape.pose
            x, y, z = pose.position
            yield (
                _scaled(urdf_shape(shape), size),
                Pose((x * size, y * size, z * size), pose.quaternion),
            )


def _scaled(shape: Shape, size: float) -> Shape:
    if size == 1.0:
        return shape
    match shape:
        case BoxShape((x, y, z)):
            return BoxShape((x * size, y * size, z * size))
        case SphereShape(radius):
            return SphereShape(radius * size)
        case CylinderShape(radius, length):
            return CylinderShape(radius * size, length * size)
        case CapsuleShape(radius, length):
            return CapsuleShape(radius * size, length * size)
        case _:
            x, y, z = shape.scale
            return replace(shape, scale=(x * size, y * size, z * size))


def _placed(shape: Shape, pose: Pose) -> Floats:
    """(n, 3, 3) triangles of a shape, in the frame of the object."""
    own = _triangles(shape)
    axes = np.array([pose.axis(index) for index in range(3)])
    return np.asarray(own @ axes + np.array(pose.position))


def _triangles(shape: Shape) -> Floats:
    match shape:
        case BoxShape((x, y, z)):
            corners = np.array([(a * x, b * y, c * z) for a, b, c in _CORNERS]) / 2.0
            return np.asarray(corners[np.array(_FACES)])
        case SphereShape(radius):
            return _turned(_arc(radius, 0.0))
        case CylinderShape(radius, length):
            half = length / 2.0
            return _turned([(0.0, half), (radius, half), (radius, -half), (0.0, -half)])
        case CapsuleShape(radius, length):
            return _turned(_arc(radius, length / 2.0))
        case _:
            return mesh_corners(shape)


_CORNERS = [(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
_FACES = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
)  # fmt: skip


def _arc(radius: float, half: float) -> list[tuple[float, float]]:
    """Radius and height along a half circle whose halves are apart."""
    turns = np.linspace(0.0, math.pi, 17).tolist()
    return [
        (radius * math.sin(turn), radius * math.cos(turn) + math.copysign(half, math.cos(turn)))
        for turn in turns
    ]


def _turned(profile: Sequence[tuple[float, float]]) -> Floats:
    """(n, 3, 3) triangles of a profile of radius and height that is turned about z."""
    turns = np.linspace(0.0, 2.0 * math.pi, _TURNS + 1)
    radii, heights = np.array(profile).T
    grid = np.stack(
        [
            radii[:, None] * np.cos(turns),
            radii[:, None] * np.sin(turns),
            np.broadcast_to(heights[:, None], (len(radii), len(turns))),
        ],
        axis=-1,
    )
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    found = np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)])
    found = found.reshape(-1, 3, 3)
    area = np.linalg.norm(np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]), axis=1)
    return np.asarray(found[area > 1e-12])
