"""Loops over the triangles of a mesh, compiled by Numba."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster.kernels import kernel

Array = NDArray[Any]


@kernel()
def crease_normals(points: Array, triangles: Array, cosine: float) -> Array:
    """Normals at the corners of triangles: the mean over faces around a point that meet smoothly.

    Args:
        points: (p, 3).
        triangles: (t, 3).
        cosine: Of the largest angle between faces that share a normal.

    Returns:
        (3 t, 3) unit vectors, one for each corner.
    """
    count = len(triangles)
    areas = np.empty((count, 3))
    faces = np.empty((count, 3))
    for t in range(count):
        a, b, c = points[triangles[t, 0]], points[triangles[t, 1]], points[triangles[t, 2]]
        areas[t] = np.cross(b - a, c - a)
        length = math.sqrt(np.sum(areas[t] * areas[t]))
        faces[t] = areas[t] / length if length > 0.0 else areas[t]
    starts = np.zeros(len(points) + 1, np.int64)
    for t in range(count):
        for corner in range(3):
            starts[triangles[t, corner] + 1] += 1
    starts = np.cumsum(starts)
    around = np.empty(3 * count, np.int64)
    filled = starts[:-1].copy()
    for t in range(count):
        for corner in range(3):
            point = triangles[t, corner]
            around[filled[point]] = t
            filled[point] += 1
    normals = np.empty((3 * count, 3))
    for t in range(count):
        for corner in range(3):
            point = triangles[t, corner]
            total = np.zeros(3)
            for place in range(starts[point], starts[point + 1]):
                other = around[place]
                if np.sum(faces[t] * faces[other]) >= cosine:
                    total += areas[other]
            length = math.sqrt(np.sum(total * total))
            normals[3 * t + corner] = total / length if length > 0.0 else faces[t]
    return normals


@kernel()
def nearest(points: Array, others: Array) -> Array:
    """The nearest of other points to each point: (p,) of (p, 3) and (o, 3)."""
    order = np.argsort(others[:, 0])
    ordered = others[order]
    starts = np.searchsorted(ordered[:, 0], points[:, 0])
    found = np.empty(len(points), np.intp)
    for p in range(len(points)):
        least = math.inf
        # From the start in both directions, until x alone is farther away than the nearest.
        for place, stop, step in ((starts[p], len(others), 1), (starts[p] - 1, -1, -1)):
            for o in range(place, stop, step):
                dx = ordered[o, 0] - points[p, 0]
                if dx * dx > least:
                    break
                dy, dz = ordered[o, 1] - points[p, 1], ordered[o, 2] - points[p, 2]
                distance = dx * dx + dy * dy + dz * dz
                if distance < least or (distance == least and order[o] < found[p]):
                    least = distance
                    found[p] = order[o]
    return found
