"""Triangle meshes with vertex normals: primitive shapes, and meshes from files made light.

Faces that meet at a flat angle share smooth normals; sharp edges stay sharp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster.geometry import crease_normals, nearest

Floats = NDArray[np.float32]
Points = NDArray[np.float64]
Indices = NDArray[np.int32]

CREASE_DEG = 40.0
"""Faces that meet at a larger angle do not share a normal."""

INWARD = 0.25
"""How far towards the middle of a triangle its corners are looked up."""

LEAST_AREA = 0.8
"""Share of a mesh's surface that a simplified one has at least."""

ROUND = 32
"""Corners of a circle."""


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles with a normal at each vertex.

    Attributes:
        vertices: (v, 3) positions in metres.
        normals: (v, 3) unit vectors.
        triangles: (t, 3) numbers of vertices, counter-clockwise as seen from the side
            that is drawn.
    """

    vertices: Floats
    normals: Floats
    triangles: Indices


def mesh_of(points: Points, triangles: Indices) -> TriangleMesh:
    """A mesh from points and triangles.

    Args:
        points: (p, 3) positions in metres.
        triangles: (t, 3) numbers of points.
    """
    (mesh,) = parts_of(points, triangles, np.zeros(len(triangles), np.intp))
    return mesh


def parts_of(points: Points, triangles: Indices, part: NDArray[np.intp]) -> list[TriangleMesh]:
    """The parts of a mesh, which is as smooth where they meet as within.

    Args:
        points: (p, 3) positions in metres.
        triangles: (t, 3) numbers of points.
        part: (t,) number of each triangle's part, from 0; no number without triangles.
    """
    points, triangles, kept = _merged(points, triangles)
    if _is_closed(triangles) and _volume(points, triangles) < 0.0:  # inside out
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    normals = crease_normals(points, triangles, math.cos(math.radians(CREASE_DEG)))
    normals = normals.reshape(-1, 3, 3)
    part = part[kept]
    chosen = [part == number for number in range(part.max() + 1)]
    return [_part(points, triangles[own], normals[own]) for own in chosen]


def _part(points: Points, triangles: Indices, normals: NDArray[np.float64]) -> TriangleMesh:
    """A mesh whose corners with the same point and normal are one vertex."""
    numbers, corners = triangles.reshape(-1, 1), normals.reshape(-1, 3)
    keys = np.concatenate([numbers, np.round(corners * 1024.0).astype(np.int64)], axis=1)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return TriangleMesh(
        np.ascontiguousarray(points[numbers[first, 0]], dtype=np.float32),
        np.ascontiguousarray(corners[first], dtype=np.float32),
        inverse.reshape(-1, 3).astype(np.int32),
    )


def simplified(
    points: Points, triangles: Indices, most: int
) -> tuple[Points, Indices, NDArray[np.intp]]:
    """A mesh with fewer triangles, by quadric error (Garland and Heckbert, 1997).

    Args:
        points: (p, 3) positions in metres.
        triangles: (t, 3) numbers of points.
        most: Number of triangles; a mesh that has no more stays as it is. More are left where parts
            of the surface would be lost, as in meshes of many loose parts.

    Returns:
        Points, triangles, and (t, 3) for each corner of these the triangle that was there: those
            around a corner tell more of a large triangle than what is nearest to its middle, which
            may be a layer below.
    """
    from fast_simplification import simplify

    if len(triangles) <= most:
        return points, triangles, np.repeat(np.arange(len(triangles)), 3).reshape(-1, 3)
    joined, faces, _ = _merged(points, triangles)
    made, numbers = joined, faces
    while most < len(faces):
        share = 1.0 - most / len(faces)
        fewer, left = simplify(joined.astype(np.float32), faces, target_reduction=share)
        made, numbers = np.asarray(fewer, dtype=np.float64), np.asarray(left, dtype=np.int32)
        if _area(made, numbers) >= LEAST_AREA * _area(joined, faces):
            break
        made, numbers, most = joined, faces, 2 * most
    corners = made[numbers]
    within = (1.0 - INWARD) * corners + INWARD * corners.mean(axis=1, keepdims=True)
    before = nearest(within.reshape(-1, 3), points[triangles].mean(axis=1))
    return made, numbers, before.reshape(-1, 3)


def _area(points: Points, triangles: Indices) -> float:
    """The area of a mesh's triangles, in square metres."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def box(edges: tuple[float, float, float]) -> TriangleMesh:
    """A box around the origin."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [part for a, b, c, d in sides for part in ((a, b, c), (a, c, d))]
    return mesh_of(corners * np.array(edges) / 2.0, np.array(triangles, dtype=np.int32))


def cylinder(radius: float, length: float) -> TriangleMesh:
    """A cylinder along z around the origin."""
    half = length / 2.0
    return _turned([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])


def sphere(radius: float) -> TriangleMesh:
    """A sphere around the origin."""
    return _turned(_arc(radius, 0.0, -90.0, 90.0, ROUND // 2))


def capsule(radius: float, length: float) -> TriangleMesh:
    """A cylinder along z of this length, with half a sphere at each end."""
    half, count = length / 2.0, ROUND // 4
    low, high = _arc(radius, -half, -90.0, 0.0, count), _arc(radius, half, 0.0, 90.0, count)
    return _turned(low + high)


def _arc(
    radius: float, height: float, first_deg: float, last_deg: float, count: int
) -> list[tuple[float, float]]:
    """Radius and height of points on a half circle around a point of the axis."""
    angles = np.radians(np.linspace(first_deg, last_deg, count + 1))
    return [
        (max(0.0, radius * math.cos(angle)), height + radius * math.sin(angle)) for angle in angles
    ]


def _turned(profile: list[tuple[float, float]]) -> TriangleMesh:
    """A solid of revolution about z, from a profile of radii and heights, from below."""
    turns = np.linspace(0.0, 2.0 * math.pi, ROUND, endpoint=False)
    rings = [
        np.stack([r * np.cos(turns), r * np.sin(turns), np.full(ROUND, z)], axis=1)
        for r, z in profile
    ]
    index = np.arange(ROUND)
    after = (index + 1) % ROUND
    triangles = []
    for ring in range(len(profile) - 1):
        low, high = ring * ROUND, (ring + 1) * ROUND
        triangles += [
            np.stack([low + index, low + after, high + after], axis=1),
            np.stack([low + index, high + after, high + index], axis=1),
        ]
    return mesh_of(np.concatenate(rings), np.concatenate(triangles).astype(np.int32))


def _merged(points: Points, triangles: Indices) -> tuple[Points, Indices, NDArray[np.intp]]:
    """Points at the same place made one, and the triangles with an area, by number."""
    _, first, inverse = np.unique(
        np.round(points * 1e6).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    joined = inverse.reshape(-1)[triangles].astype(np.int32)
    a, b, c = joined.T
    (kept,) = np.nonzero((a != b) & (b != c) & (c != a))
    return np.ascontiguousarray(points[first], dtype=np.float64), joined[kept], kept


def _is_closed(triangles: Indices) -> bool:
    """Whether every edge is run through once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    forward = np.unique(edges, axis=0)
    backward = np.unique(edges[:, ::-1], axis=0)
    return len(forward) == len(edges) and bool(np.array_equal(forward, backward))


def _volume(points: Points, triangles: Indices) -> float:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
