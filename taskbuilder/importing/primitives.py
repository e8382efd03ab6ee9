"""Primitive shapes as triangles."""

from __future__ import annotations

import numpy as np

from taskbuilder.importing.description import ImportedShape
from taskbuilder.importing.fitting import hull_of
from taskbuilder.importing.surfaces import Floats, Part, placed


def primitive_part(shape: ImportedShape) -> Part:
    """A primitive as triangles in the frame of its link."""
    size = shape.size
    if shape.kind == "box":
        corners = box_corners(np.array([[-s / 2 for s in size], [s / 2 for s in size]]))
    else:
        angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
        ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(16)], axis=1) * size[0]
        if shape.kind == "sphere":
            rings = [ring, ring[:, [2, 0, 1]], ring[:, [0, 2, 1]]]
        else:
            half = size[1] / 2.0
            up = np.array([0.0, 0.0, half])
            rings = [ring + up, ring - up]
            if shape.kind == "capsule":
                tip = half + size[0]
                rings.append(np.array([[0.0, 0.0, tip], [0.0, 0.0, -tip]]))
        corners = np.concatenate(rings)
    points, faces = hull_of(corners)
    return placed(shape.pose, points), faces


def box_corners(low_high: Floats) -> Floats:
    """(8, 3) corners of a box from its (2, 3) lowest and highest corner."""
    (a, b, c), (x, y, z) = low_high
    return np.array([[i, j, k] for i in (a, x) for j in (b, y) for k in (c, z)])
