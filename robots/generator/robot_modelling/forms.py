"""Forms: what a link looks like and what it touches, in one.

A form is a round or a square solid. It has a mesh to be drawn, a primitive to collide with, and a
share of the link's mass. Forms are written where they are while all joints are at zero, in the
frame of the module's root; `placed_in` brings them into the frame of their link.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robot_modelling.solids import Mesh, milled, rectangle, turned
from robot_modelling.urdf import ORIGIN, Inertia, Shape, Vec3

Matrix = NDArray[np.float64]

SEGMENTS, FEWER = 16, 12  # flat sides of a circle, and of one that is thin
THIN = 0.045  # m
ROUNDED_FROM = 0.0055  # how far edges are broken, in m, before a mesh is drawn for them
SMOOTH_FROM = 0.055  # radius in m from which the flat sides of the engine's cylinders are seen
CAPSULE_FROM = 1.25  # times its diameter a round form is long before a capsule touches for it


@dataclass(frozen=True)
class Form:
    """A solid of even density.

    Attributes:
        color: Name of its material.
        mesh: Its look, in its own frame.
        size: Radius and length along z of a round form, edges of a square one, in m.
        pose: Its frame, (4, 4), whose origin is its centre.
        touches: Whether it collides.
        is_plain: Whether it is drawn as a cylinder or box, without a mesh.
    """

    color: str
    mesh: Mesh
    size: tuple[float, ...]
    pose: Matrix
    touches: bool = True
    is_plain: bool = False

    def moved(self, by: Matrix) -> Form:
        """Return the form moved by a transform (4, 4)."""
        return replace(self, pose=by @ self.pose)

    @property
    def volume(self) -> float:
        """In m³."""
        if len(self.size) == 3:
            return math.prod(self.size)
        radius, length = self.size
        return math.pi * radius * radius * length

    @property
    def moments(self) -> Matrix:
        """Inertia (3, 3) about its centre for a mass of 1, along its link's axes."""
        if len(self.size) == 3:
            x, y, z = (edge * edge / 12.0 for edge in self.size)
            own = np.diag([y + z, x + z, x + y])
        else:
            radius, length = self.size
            across = (3.0 * radius**2 + length**2) / 12.0
            own = np.diag([across, across, radius**2 / 2.0])
        turn = self.pose[:3, :3]
        return np.asarray(turn @ own @ turn.T)

    @property
    def drawn(self) -> Shape:
        """The cylinder or box that is drawn for it."""
        if len(self.size) == 3:
            return self.shape
        radius, length = self.size
        geometry = f'<cylinder radius="{radius:g}" length="{round(length, 5):g}"/>'
        return Shape(geometry, position(self.pose), rpy(self.pose))

    @property
    def shape(self) -> Shape:
        """The primitive that touches for it."""
        if len(self.size) == 3:
            geometry = '<box size="{:g} {:g} {:g}"/>'.format(*(round(e, 5) for e in self.size))
        else:
            radius, length = self.size
            if length >= 2.0 * radius * CAPSULE_FROM:
                inner = round(length - 2.0 * radius, 5)
                geometry = f'<capsule radius="{radius:g}" length="{inner:g}"/>'
            else:
                geometry = f'<cylinder radius="{radius:g}" length="{round(length, 5):g}"/>'
        return Shape(geometry, position(self.pose), rpy(self.pose))


def transform(xyz: Sequence[float] = ORIGIN, turn: Sequence[float] = ORIGIN) -> Matrix:
    """Return a pose (4, 4) from a position and the fixed angles roll, pitch and yaw of URDF."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in turn)
    pose = np.eye(4)
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = xyz
    return pose


def position(pose: Matrix) -> Vec3:
    """Return the position of a pose, to a tenth of a micrometre."""
    x, y, z = (round(float(value), 7) + 0.0 for value in pose[:3, 3])
    return x, y, z


def rpy(pose: Matrix) -> Vec3:
    """Return roll, pitch and yaw of a pose."""
    m = pose[:3, :3]
    pitch = math.asin(max(-1.0, min(1.0, -float(m[2, 0]))))
    if abs(m[2, 0]) > 1.0 - 1e-9:
        roll, yaw = math.atan2(-m[1, 2], m[1, 1]), 0.0
    else:
        roll, yaw = math.atan2(m[2, 1], m[2, 2]), math.atan2(m[1, 0], m[0, 0])
    return round(roll, 7) + 0.0, round(pitch, 7) + 0.0, round(yaw, 7) + 0.0


def lathed(
    start: Vec3,
    end: Vec3,
    profile: Sequence[tuple[float, ...]],
    color: str,
    *,
    radius: float,
    touches: bool = True,
    caps: str = "both",
    is_plain: bool = False,
) -> Form:
    """Return a turned form along the way from ``start`` to ``end``.

    Args:
        start: Where the profile begins.
        end: Where it ends.
        profile: Corners (radius, distance from start) or (radius, distance, rounding), in m.
        color: Name of its material.
        radius: Of the primitive.
        touches: Whether it collides.
        caps: Which ends are closed: none, start, end or both.
        is_plain: Whether a cylinder is drawn in its place.
    """
    way = np.array(end) - np.array(start)
    length = float(np.linalg.norm(way))
    middle = (np.array(start) + np.array(end)) / 2.0
    turn = (0.0, math.atan2(math.hypot(way[0], way[1]), way[2]), math.atan2(way[1], way[0]))
    corners = [(corner[0], corner[1] - length / 2.0, *corner[2:]) for corner in profile]
    segments = FEWER if radius < THIN else SEGMENTS
    mesh = turned(corners, segments=segments, caps=caps)
    return Form(color, mesh, (radius, length), transform(middle, turn), touches, is_plain)


def bar(
    start: Vec3,
    end: Vec3,
    radius: float,
    color: str,
    *,
    to: float | None = None,
    lip: float = 0.004,
    touches: bool = True,
    caps: str = "both",
) -> Form:
    """Return a tube or housing with broken edges, which may taper to the radius ``to``.

    An end that lies inside another form is neither closed nor broken. If it is thin and has
    neither a taper nor round edges, it is drawn as a cylinder.
    """
    length = math.dist(start, end)
    last = radius if to is None else to
    lip = min(lip, length / 3.0, radius / 3.0)
    begin = [(radius - lip, 0.0), (radius, lip)] if caps in ("start", "both") else [(radius, 0.0)]
    finish = [(last, length - lip), (last - lip, length)] if caps in ("end", "both") else []
    profile = [*begin, *(finish or [(last, length)])]
    middle = (radius + last) / 2.0
    plain = to in (None, radius) and lip < ROUNDED_FROM and radius < SMOOTH_FROM
    return lathed(
        start, end, profile, color, radius=middle, touches=touches, caps=caps, is_plain=plain
    )


def dome(start: Vec3, end: Vec3, radius: float, color: str) -> Form:
    """Return a lid: a flat dome that rises from ``start`` to ``end``; it is only seen."""
    height = math.dist(start, end)
    profile = [(radius, 0.0), (radius * 0.97, height * 0.6), (radius * 0.8, height)]
    return lathed(start, end, profile, color, radius=radius, touches=False, caps="end")


def block(
    size: Vec3,
    at: Vec3,
    color: str,
    *,
    turn: Vec3 = ORIGIN,
    radius: float = 0.0,
    bevel: float = 0.0015,
    touches: bool = True,
) -> Form:
    """Return a box; ``radius`` rounds its edges along its z axis, ``bevel`` breaks the others."""
    x, y, z = (edge / 2.0 for edge in size)
    bevel = min(bevel, z / 2.0)
    mesh = milled(rectangle((-x, x), (-y, y), radius), -z, z, bevel=bevel)
    plain = max(radius, bevel) < ROUNDED_FROM
    return Form(color, mesh, size, transform(at, turn), touches, plain)


def plate(
    outline: Sequence[tuple[float, ...]],
    thickness: float,
    at: Vec3,
    color: str,
    *,
    turn: Vec3 = ORIGIN,
    bevel: float = 0.001,
    touches: bool = False,
) -> Form:
    """Return a convex outline (x, y[, rounding]), counter-clockwise, cut from a plate along z.

    Its primitive is the box around it.
    """
    points = np.array([corner[:2] for corner in outline])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    around = [(c[0] - middle[0], c[1] - middle[1], *c[2:]) for c in outline]
    mesh = milled(around, -thickness / 2.0, thickness / 2.0, bevel=bevel)
    pose = transform(at, turn) @ transform((float(middle[0]), float(middle[1]), 0.0))
    size = (float(high[0] - low[0]), float(high[1] - low[1]), thickness)
    return Form(color, mesh, size, pose, touches)


UPRIGHT_X: Vec3 = (math.pi / 2, 0.0, 0.0)  # of a plate whose outline is (x, z)
UPRIGHT_Y: Vec3 = (math.pi / 2, 0.0, math.pi / 2)  # of one whose outline is (y, z)


def hidden(form: Form) -> Form:
    """Return the form as a primitive that touches but is not drawn."""
    nothing = (np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    return replace(form, mesh=nothing, is_plain=False)


def placed_in(frame: Matrix, forms: Iterable[Form]) -> list[Form]:
    """Return forms of the root's frame in the frame of a link at ``frame``."""
    into: Matrix = np.asarray(np.linalg.inv(frame), np.float64)
    return [form.moved(into) for form in forms]


def seen(form: Form) -> Mesh:
    """Return the mesh of a form in its link's frame."""
    vertices, faces = form.mesh
    return vertices @ form.pose[:3, :3].T + form.pose[:3, 3], faces


def spread(forms: Sequence[Form], mass: float) -> tuple[Vec3, Inertia]:
    """Return the centre of mass, and the inertia about it, of forms of the same density."""
    volumes = np.array([form.volume for form in forms])
    shares = mass * volumes / volumes.sum()
    centers = np.array([form.pose[:3, 3] for form in forms])
    center = shares @ centers / mass
    total = np.zeros((3, 3))
    for form, share, at in zip(forms, shares, centers, strict=True):
        away = at - center
        total += share * (form.moments + (away @ away) * np.eye(3) - np.outer(away, away))
    i = [round(float(value), 10) for value in total[np.triu_indices(3)]]
    x, y, z = (round(float(value), 7) for value in center)
    return (x, y, z), (i[0], i[1], i[2], i[3], i[4], i[5])
