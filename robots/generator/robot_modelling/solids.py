"""Meshes of solids: lofts of outlines, turned and milled, and where they are placed.

A mesh is a pair of arrays: vertices (n, 3) in metres and triangles (m, 3) of vertex numbers. Every
solid is a loft: a stack of rings of equally many points, joined ring to ring. A turned part is a
loft of circles, a milled one a loft of outlines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triangles = NDArray[np.int64]
Mesh = tuple[Array, Triangles]
Corner = tuple[float, ...]  # (u, v) or (u, v, radius of the rounding)

ROUND_STEPS = 2


def rounded(corners: Sequence[Corner], *, closed: bool) -> list[tuple[float, float]]:
    """Replace every corner that names a radius by an arc of ``ROUND_STEPS`` chords.

    Args:
        corners: Points (u, v) or (u, v, radius) of a polyline.
        closed: Whether the last point joins the first.

    Returns:
        The points of the rounded polyline.
    """
    points: list[tuple[float, float]] = []
    for i, (u, v, *radius) in enumerate(corners):
        here = np.array([u, v])
        is_end = not closed and i in (0, len(corners) - 1)
        if not radius or radius[0] == 0 or is_end:
            points.append((u, v))
            continue
        back = np.array(corners[i - 1][:2]) - here
        ahead = np.array(corners[(i + 1) % len(corners)][:2]) - here
        back /= np.linalg.norm(back)
        ahead /= np.linalg.norm(ahead)
        half = math.acos(max(-1.0, min(1.0, float(back @ ahead)))) / 2
        middle = (back + ahead) / np.linalg.norm(back + ahead)
        center = here + middle * radius[0] / math.sin(half)
        start = here + back * radius[0] / math.tan(half) - center
        turn = math.pi - 2 * half
        sign = 1.0 if back[0] * ahead[1] - back[1] * ahead[0] < 0 else -1.0
        for step in range(ROUND_STEPS + 1):
            a = sign * turn * step / ROUND_STEPS
            c, s = math.cos(a), math.sin(a)
            x, y = center + np.array([c * start[0] - s * start[1], s * start[0] + c * start[1]])
            points.append((float(x), float(y)))
    return points


def loft(rings: Array, *, cap_start: bool, cap_end: bool) -> Mesh:
    """Join a stack of rings of points, counter-clockwise seen from its end.

    Args:
        rings: (k, n, 3) in metres; a ring may shrink to one repeated point.
        cap_start: Whether to close the first ring with a flat face. The ring must be convex.
        cap_end: The same for the last ring.

    Returns:
        The mesh, its faces turned outward.
    """
    k, n, _ = rings.shape
    faces: list[tuple[int, int, int]] = []
    for i in range(k - 1):
        for j in range(n):
            a, b = i * n + j, i * n + (j + 1) % n
            faces += [(a, b, b + n), (a, b + n, a + n)]
    if cap_start:
        faces += [(0, j + 1, j) for j in range(1, n - 1)]
    if cap_end:
        top = (k - 1) * n
        faces += [(top, top + j, top + j + 1) for j in range(1, n - 1)]
    return rings.reshape(-1, 3), np.array(faces, dtype=np.int64)


def turned(profile: Sequence[Corner], *, segments: int = 24, caps: str = "none") -> Mesh:
    """Turn a profile about the z axis, as on a lathe.

    Args:
        profile: Corners (radius, z) or (radius, z, rounding) from bottom to top.
        segments: Flat sides of the circle.
        caps: Which open ends to close: none, start, end or both. An end inside another part
            stays open and saves its triangles.
    """
    turn = 2 * math.pi / segments * np.arange(segments)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros(segments)], axis=1)
    rings = [circle * r + [0.0, 0.0, z] for r, z in rounded(profile, closed=False)]
    return loft(
        np.array(rings), cap_start=caps in ("start", "both"), cap_end=caps in ("end", "both")
    )


def inset(outline: Sequence[tuple[float, float]], distance: float) -> Array:
    """Move every side of a convex counter-clockwise outline inward."""
    points = np.array(outline)
    sides = np.roll(points, -1, axis=0) - points
    normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    before = np.roll(normals, 1, axis=0)
    mitre = (before + normals) / (1 + (before * normals).sum(axis=1))[:, None]
    moved_in: Array = points + distance * mitre
    return moved_in


def milled(
    outline: Sequence[Corner], bottom: float, top: float, *, bevel: float = 0.0, caps: str = "both"
) -> Mesh:
    """Raise a counter-clockwise outline (x, y) from z = bottom to top, its edges bevelled.

    The outline must lie open to view from its first corner, where the flat faces fan out.
    """
    points = rounded(outline, closed=True)
    stack = [(bevel, bottom), (0.0, bottom + bevel), (0.0, top - bevel), (bevel, top)]
    if bevel == 0:
        stack = [(0.0, bottom), (0.0, top)]
    if caps == "end":  # the bottom is hidden inside another part and stays sharp and open
        stack = [(0.0, bottom), *stack[-2:]] if bevel else stack
    rings = [
        np.column_stack([inset(points, distance), np.full(len(points), z)]) for distance, z in stack
    ]
    return loft(np.array(rings), cap_start=caps in ("start", "both"), cap_end=caps != "none")


def rectangle(x: tuple[float, float], y: tuple[float, float], radius: float = 0.0) -> list[Corner]:
    """Return the outline of a rectangle with rounded corners."""
    return [(x[0], y[0], radius), (x[1], y[0], radius), (x[1], y[1], radius), (x[0], y[1], radius)]


# Right-handed frames (columns) whose z axis is the named one: where a part's own z shall point.
FRAMES: dict[str, tuple[tuple[int, int, int], ...]] = {
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "+y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "+x": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "-x": ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
}


def placed(mesh: Mesh, axis: str, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """Turn a mesh so that its z axis points along ``axis``, then move it to ``at``."""
    vertices, faces = mesh
    return vertices @ np.array(FRAMES[axis], dtype=float).T + np.array(at), faces


def mirrored(mesh: Mesh) -> Mesh:
    """Mirror a mesh in y, its faces still turned outward."""
    vertices, faces = mesh
    return vertices * np.array([1.0, -1.0, 1.0]), faces[:, ::-1]
