"""Convex hulls of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


def hull_triangles(points: Floats) -> Integers:
    """The (t, 3) triangles of the convex hull of points, facing outwards.

    They are found by adding one point after the other, which is quick for up to a thousand points.

    Args:
        points: (p, 3) points, which span a volume.
    """
    center_free = points - points.mean(axis=0)
    size = float(np.abs(center_free).max()) or 1.0
    jitter = np.random.default_rng(0).normal(scale=size * 1e-7, size=points.shape)
    cloud = center_free + jitter  # no four points of a plane
    first = _first_four(cloud)
    inside = cloud[first].mean(axis=0)
    faces = [_outwards(cloud, inside, face) for face in _faces_of(first)]
    for index in range(len(cloud)):
        if index in first:
            continue
        corners = np.array(faces)
        a = cloud[corners[:, 0]]
        normal = np.cross(cloud[corners[:, 1]] - a, cloud[corners[:, 2]] - a)
        seen = np.einsum("ij,ij->i", cloud[index] - a, normal) > 0.0
        if not seen.any():
            continue
        edges = {(int(face[i]), int(face[(i + 1) % 3])) for face in corners[seen] for i in range(3)}
        rim = sorted(edge for edge in edges if (edge[1], edge[0]) not in edges)
        faces = [face for face, visible in zip(faces, seen, strict=True) if not visible]
        faces += [(a_, b_, index) for a_, b_ in rim]
    return np.array(faces, np.int64)


def _faces_of(four: list[int]) -> list[tuple[int, int, int]]:
    a, b, c, d = four
    return [(a, b, c), (a, b, d), (a, c, d), (b, c, d)]


def _outwards(cloud: Floats, inside: Floats, face: tuple[int, int, int]) -> tuple[int, int, int]:
    a, b, c = face
    normal = np.cross(cloud[b] - cloud[a], cloud[c] - cloud[a])
    return face if normal @ (cloud[a] - inside) > 0.0 else (a, c, b)


def _first_four(cloud: Floats) -> list[int]:
    """Four points that span a volume."""
    a = int(np.argmin(cloud[:, 0]))
    b = int(np.argmax(np.linalg.norm(cloud - cloud[a], axis=1)))
    along = (cloud[b] - cloud[a]) / max(float(np.linalg.norm(cloud[b] - cloud[a])), 1e-30)
    off = cloud - cloud[a]
    c = int(np.argmax(np.linalg.norm(off - np.outer(off @ along, along), axis=1)))
    normal = np.cross(cloud[b] - cloud[a], cloud[c] - cloud[a])
    d = int(np.argmax(np.abs(off @ normal)))
    return [a, b, c, d]
