"""Types and tools for points and triangles as arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Part = tuple[Floats, Integers]
"""(n, 3) points and (m, 3) numbers of points."""


def welded_mesh(points: Floats, faces: Integers) -> tuple[Floats, Integers]:
    """The mesh with equal points made one, which decimation needs to keep it closed."""
    if not len(points):
        return points, faces
    size = float(np.ptp(points, axis=0).max(initial=0.0)) or 1.0
    first, inverse = same_rows(np.round((points - points.min(axis=0)) / (size * 1e-6)))
    faces = inverse[faces]
    a, b, c = faces.T
    return points[first], faces[(a != b) & (b != c) & (c != a)]


def same_rows(rows: Floats) -> tuple[Integers, Integers]:
    """The first of each group of equal rows, and the group of each row.

    By sorting, which takes a tenth of the time of `numpy.unique` along an axis.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    fresh = np.ones(len(rows), bool)
    fresh[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    inverse = np.empty(len(rows), np.int64)
    inverse[order] = np.cumsum(fresh) - 1
    return order[fresh], inverse


def placed(pose: Pose, points: Floats) -> Floats:
    """Points of a frame in the frame that its pose is in."""
    axes = np.array([pose.axis(index) for index in range(3)])
    return np.asarray(points @ axes + np.array(pose.position), np.float64)


def nearest(queries: Floats, points: Floats) -> Integers:
    """The number of the point that is nearest to each query, exactly where points are few."""
    found = np.zeros(len(queries), np.int64)
    step = max(1, 4_000_000 // max(1, len(points)))
    squares = (points * points).sum(axis=1)
    for start in range(0, len(queries), step):
        part = queries[start : start + step]
        found[start : start + step] = np.argmin(squares - 2.0 * part @ points.T, axis=1)
    return found


def distances(queries: Floats, points: Floats) -> Floats:
    """The distance of each query to the nearest of some points."""
    away: Floats = np.linalg.norm(queries - points[nearest(queries, points)], axis=1)
    return away


def volume(points: Floats, faces: Integers) -> float:
    """The volume that triangles enclose; below 0 if they face inwards."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def is_closed(faces: Integers) -> bool:
    """Whether each edge is shared by two triangles that run along it in opposite directions."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    size = int(faces.max(initial=0)) + 1
    keys, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    keys.sort()
    back.sort()
    return bool((keys[1:] != keys[:-1]).all() and np.array_equal(keys, back))


def sampled(points: Floats, faces: Integers, count: int) -> Floats:
    """Points spread evenly over a surface, the same for the same mesh."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    if not areas.sum() > 0.0:
        return points
    rng = np.random.default_rng(0)
    steps = (np.arange(count) + rng.random(count)) / count * areas.sum()
    chosen = np.minimum(np.searchsorted(np.cumsum(areas), steps), len(faces) - 1)
    u, v = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    spread = (1.0 - u) * a[chosen] + u * (1.0 - v) * b[chosen] + u * v * c[chosen]
    return np.asarray(spread, np.float64)


def components(faces: Integers) -> Integers:
    """The number of the part that each face belongs to; parts meet along no edge of two faces.

    Boxes that touch at corners, or along an edge that four faces share, are parts of their own.
    """
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    _, group = same_rows(edges.astype(np.float64))
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.argsort(group, kind="stable")
    sizes = np.bincount(group)
    starts = np.cumsum(sizes) - sizes
    two = starts[sizes == 2]
    first, second = owner[order[two]], owner[order[two + 1]]
    labels = np.arange(len(faces))
    while True:
        after = labels.copy()
        least = np.minimum(labels[first], labels[second])
        np.minimum.at(after, first, least)
        np.minimum.at(after, second, least)
        after = after[after]
        if np.array_equal(after, labels):
            return np.asarray(np.unique(labels, return_inverse=True)[1], np.int64).reshape(-1)
        labels = after
