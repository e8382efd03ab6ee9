"""Collision shapes, and what follows from their geometry: volume, inertia and bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.mesh import Mesh, read_mesh
from taskbuilder.assets.paths import AssetError
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import ORIGIN, Ball, Box, Pose, Vec3, bounding_box, from_axes

RGBA = tuple[float, float, float, float]

AT_ORIGIN = Pose()


@dataclass(frozen=True)
class BoxShape:
    """A box of the given full edge lengths, centred."""

    size: Vec3


@dataclass(frozen=True)
class SphereShape:
    """A centred sphere."""

    radius: float


@dataclass(frozen=True)
class CylinderShape:
    """A centred cylinder about z."""

    radius: float
    length: float


@dataclass(frozen=True)
class CapsuleShape:
    """A centred capsule about z; the length is that of its straight part."""

    radius: float
    length: float


@dataclass(frozen=True)
class MeshShape:
    """A mesh file.

    Attributes:
        path: The file.
        scale: Factors of its coordinates.
        collide: How it collides: as the convex hull of each of its groups (``pieces``), as that of
            all of it (``hull``), as a box around each group (``boxes``), or as its surface
            (``exact``). By default ``exact`` on a body that never moves, and otherwise ``pieces``.
    """

    path: Path
    scale: Vec3 = (1.0, 1.0, 1.0)
    collide: Literal["pieces", "hull", "boxes", "exact"] | None = None


Shape = BoxShape | SphereShape | CylinderShape | CapsuleShape | MeshShape


@dataclass(frozen=True)
class Part:
    """A piece of a body: its shape, where it sits in the body's frame, and its colour.

    Attributes:
        color: Red, green, blue and opacity, each 0 to 1.
        look: What is drawn in place of the shape, or None for the shape itself. Bullet draws
            every body, if only as its collision shape.
    """

    shape: Shape
    pose: Pose = AT_ORIGIN
    color: RGBA = (0.6, 0.6, 0.6, 1.0)
    look: Shape | None = None


@dataclass(frozen=True)
class Solid:
    """How a shape of uniform density resists motion.

    Attributes:
        volume: In m³.
        principal: The principal frame in the shape's frame: centre of mass and main axes.
        inertia: Principal moments for a mass of 1 kg, in m².
    """

    volume: float
    principal: Pose
    inertia: Vec3


def check_shape(shape: Shape) -> None:
    """Refuse a shape without extent.

    Raises:
        SimulationError: A length is not a finite number above zero.
    """
    lengths: tuple[float, ...]
    match shape:
        case BoxShape(size):
            lengths = size
        case SphereShape(radius):
            lengths = (radius,)
        case CylinderShape(radius, length) | CapsuleShape(radius, length):
            lengths = (radius, length)
        case MeshShape(_, scale, _):
            lengths = scale
    if not all(math.isfinite(length) and length > 0.0 for length in lengths):
        raise SimulationError(f"{shape}: every length must be a finite number above 0")


def solid(shape: Shape) -> Solid:
    """Volume, centre of mass and inertia of a shape of uniform density."""
    match shape:
        case BoxShape((x, y, z)):
            moments = ((y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12)
            return Solid(x * y * z, Pose(), moments)
        case SphereShape(r):
            moment = 0.4 * r * r
            return Solid(4 / 3 * math.pi * r**3, Pose(), (moment, moment, moment))
        case CylinderShape(r, h):
            across = (3 * r * r + h * h) / 12
            return Solid(math.pi * r * r * h, Pose(), (across, across, r * r / 2))
        case CapsuleShape(r, h):
            return _capsule_solid(r, h)
        case MeshShape():
            return _mesh_solid(mesh_corners(shape))


def bounds(shape: Shape) -> Box:
    """The smallest box around a shape, in its own frame."""
    match shape:
        case BoxShape((x, y, z)):
            return Box(ORIGIN, (x / 2, y / 2, z / 2))
        case SphereShape(r):
            return Ball(ORIGIN, (r, r, r))
        case CylinderShape(r, h):
            return Box(ORIGIN, (r, r, h / 2))
        case CapsuleShape(r, h):
            return Box(ORIGIN, (r, r, h / 2 + r))
        case MeshShape():
            return placed_bounds(shape, Pose())


def placed_bounds(shape: Shape, pose: Pose) -> Box:
    """The smallest box around a shape that was turned and moved."""
    match shape:
        case BoxShape():
            return bounds(shape).seen_from(pose)
        case SphereShape(r):
            return Ball(pose.position, (r, r, r))
        case CylinderShape(r, h):
            axis = pose.axis(2)
            # A disc of radius r reaches r·sin(angle between its axis and the direction).
            x, y, z = (h / 2 * abs(a) + r * math.sqrt(max(0.0, 1.0 - a * a)) for a in axis)
            return Box(pose.position, (x, y, z))
        case CapsuleShape(r, h):
            x, y, z = (h / 2 * abs(a) + r for a in pose.axis(2))
            return Box(pose.position, (x, y, z))
        case MeshShape():
            points = np.unique(mesh_corners(shape).reshape(-1, 3), axis=0)
            return bounding_box([pose.apply((x, y, z)) for x, y, z in points.tolist()])


def mesh_corners(shape: MeshShape) -> NDArray[np.float64]:
    """(triangles, 3, 3) corner positions of a mesh's triangles, m.

    Raises:
        SimulationError: The file cannot be read, or the physics engine would misread it.
    """
    return _corners(_mesh(shape), shape.scale)


def mesh_groups(shape: MeshShape) -> list[NDArray[np.float64]]:
    """The (triangles, 3, 3) corner positions of each group of a mesh, m; one group for an STL.

    Raises:
        SimulationError: The file cannot be read, or the physics engine would misread it.
    """
    mesh = _mesh(shape)
    return np.split(_corners(mesh, shape.scale), mesh.groups[1:])


def _mesh(shape: MeshShape) -> Mesh:
    try:
        return read_mesh(shape.path)
    except AssetError as error:
        raise SimulationError(str(error)) from error


def _corners(mesh: Mesh, scale: Vec3) -> NDArray[np.float64]:
    points = np.asarray(mesh.points, dtype=np.float64).reshape(-1, 3) * np.asarray(scale)
    corners: NDArray[np.float64] = points[np.asarray(mesh.corners, dtype=np.intp).reshape(-1, 3)]
    return corners


def _capsule_solid(r: float, h: float) -> Solid:
    straight, ends = math.pi * r * r * h, 4 / 3 * math.pi * r**3
    volume = straight + ends
    along = (straight * r * r / 2 + ends * 0.4 * r * r) / volume
    # Each half ball: its own moment about the ball's centre, shifted to the capsule's.
    end_across = 0.4 * r * r + h * h / 4 + 3 / 8 * h * r
    across = (straight * (3 * r * r + h * h) / 12 + ends * end_across) / volume
    return Solid(volume, Pose(), (across, across, along))


def _mesh_solid(corners: NDArray[np.float64]) -> Solid:
    """Integrate over the tetrahedra that the triangles span with the origin.

    Blow and Binstock, "How to find the inertia tensor (or other mass properties) of a 3D solid
    body represented by a triangle mesh" (2004). A mesh that is not closed has no inside; its
    bounding box stands in.
    """
    if not _is_closed(corners):
        return _box_stand_in(corners)
    determinants = np.linalg.det(corners)
    volume = determinants.sum() / 6
    if abs(volume) < 1e-12:
        return _box_stand_in(corners)
    sums = corners.sum(axis=1)
    center = (determinants[:, None] * sums).sum(axis=0) / 24 / volume
    # ∫ x xᵀ over a tetrahedron with a corner at the origin: det/120 · (Σ cᵢcᵢᵀ + s sᵀ).
    second = np.einsum("t,tki,tkj->ij", determinants, corners, corners)
    second += np.einsum("t,ti,tj->ij", determinants, sums, sums)
    covariance = second / 120 / volume - np.outer(center, center)
    inertia = np.trace(covariance) * np.eye(3) - covariance
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1
    turn = from_axes(_vector(axes[:, 0]), _vector(axes[:, 1]), _vector(axes[:, 2]))
    return Solid(abs(float(volume)), Pose(_vector(center), turn), _vector(moments))


def _is_closed(corners: NDArray[np.float64]) -> bool:
    """Whether every edge is run through once in each direction."""
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = np.sort(edges[:, 0] * len(points) + edges[:, 1])
    backward = np.sort(edges[:, 1] * len(points) + edges[:, 0])
    return bool((forward == backward).all())


def _box_stand_in(corners: NDArray[np.float64]) -> Solid:
    points = corners.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    edges = _vector(np.maximum(high - low, 1e-4))
    box = solid(BoxShape(edges))
    return Solid(box.volume, Pose(_vector((low + high) / 2)), box.inertia)


def _vector(values: NDArray[np.float64]) -> Vec3:
    x, y, z = values.tolist()
    return (x, y, z)
