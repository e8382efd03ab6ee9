"""Filling a z-buffer with triangles, compiled by Numba.

Screen coordinates are in pixels from the upper left corner of the picture; the centre of the pixel
in column c and row r is at (c + 0.5, r + 0.5). A vertex's *key* grows towards the camera and is
linear on the screen: the inverse depth under perspective, the negative depth without. The z-buffer
holds keys, so that an empty pixel holds the key of the far plane.

No fast-math and no threads: the same numbers give the same picture.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster.kernels import kernel

Array = NDArray[Any]

_HAIR = 1e-6
"""Width in pixels by which triangles overlap, so that no pixel between two of them stays empty."""


@kernel()
def place(links: Array, link_of: Array, local: Array) -> Array:
    """Poses of shapes in the world.

    Args:
        links: (l, 7) position and quaternion (x, y, z, w) of each link in the world.
        link_of: (s,) the link of each shape.
        local: (s, 3, 4) rotation and position of each shape in its link.

    Returns:
        (s, 3, 4) rotation and position of each shape in the world.
    """
    made = np.empty((len(link_of), 3, 4))
    turn = np.empty((3, 3))
    last = -1
    for s in range(len(link_of)):
        link = link_of[s]
        if link != last:
            last = link
            x, y, z, w = links[link, 3], links[link, 4], links[link, 5], links[link, 6]
            turn[0, 0] = 1.0 - 2.0 * (y * y + z * z)
            turn[0, 1] = 2.0 * (x * y - z * w)
            turn[0, 2] = 2.0 * (x * z + y * w)
            turn[1, 0] = 2.0 * (x * y + z * w)
            turn[1, 1] = 1.0 - 2.0 * (x * x + z * z)
            turn[1, 2] = 2.0 * (y * z - x * w)
            turn[2, 0] = 2.0 * (x * z - y * w)
            turn[2, 1] = 2.0 * (y * z + x * w)
            turn[2, 2] = 1.0 - 2.0 * (x * x + y * y)
        for row in range(3):
            for column in range(4):
                made[s, row, column] = (
                    turn[row, 0] * local[s, 0, column]
                    + turn[row, 1] * local[s, 1, column]
                    + turn[row, 2] * local[s, 2, column]
                )
            made[s, row, 3] += links[link, row]
    return made


@kernel()
def draw(
    shapes: Array,
    spans: Array,
    bounds: Array,
    poses: Array,
    vertices: Array,
    normals: Array,
    triangles: Array,
    view: Array,
    lens: Array,
    light: Array,
    flat: bool,
    scratch: Array,
    keys: Array,
    ids: Array,
    shades: Array,
) -> None:
    """Draw shapes into a z-buffer.

    Args:
        shapes: Numbers of the shapes to draw.
        spans: (s, 4) uint64: first vertex and the one after the last, and the same of triangles.
        bounds: (s, 4) centre and radius of a ball around each shape, in its frame.
        poses: (s, 3, 4) of the shapes in the world.
        vertices: (v, 3) float32.
        normals: (v, 3) float32.
        triangles: (t, 3) uint32, numbers of vertices. Unsigned, as are the spans, because Numba
            looks whether a signed index counts from the end.
        view: (3, 4) rotation and position of the world in the camera: x right, y down, z forward.
        lens: Focal length, centre column, centre row (pixels), near, far (m).
        light: Direction towards the lamp in the world, then ambient and diffuse shares.
        flat: Orthographic; the focal length is then pixels per metre.
        scratch: (v, 5) float32: x and y on the screen, key, shade, depth.
        keys: (h, w) float32, the z-buffer.
        ids: (h, w) int32, the number of the nearest shape.
        shades: (h, w) float32, the share of light that it reflects.
    """
    height, width = keys.shape
    focal, across, down, near, far = lens[0], lens[1], lens[2], lens[3], lens[4]
    m = np.empty((3, 4))
    for s in shapes:
        for row in range(3):
            for column in range(4):
                m[row, column] = (
                    view[row, 0] * poses[s, 0, column]
                    + view[row, 1] * poses[s, 1, column]
                    + view[row, 2] * poses[s, 2, column]
                )
            m[row, 3] += view[row, 3]
        if _is_out(m, bounds[s], focal, across, down, near, far, width, height, flat):
            continue
        # The direction of the lamp in the shape's frame.
        lx = poses[s, 0, 0] * light[0] + poses[s, 1, 0] * light[1] + poses[s, 2, 0] * light[2]
        ly = poses[s, 0, 1] * light[0] + poses[s, 1, 1] * light[1] + poses[s, 2, 1] * light[2]
        lz = poses[s, 0, 2] * light[0] + poses[s, 1, 2] * light[1] + poses[s, 2, 2] * light[2]
        ambient, diffuse = light[3], light[4]
        for v in range(spans[s, 0], spans[s, 1]):
            x, y, z = vertices[v, 0], vertices[v, 1], vertices[v, 2]
            depth = m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3]
            right = m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]
            below = m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]
            facing = normals[v, 0] * lx + normals[v, 1] * ly + normals[v, 2] * lz
            scratch[v, 3] = ambient + diffuse * max(0.0, facing)
            scratch[v, 4] = depth
            if flat:
                scratch[v, 0] = across + focal * right
                scratch[v, 1] = down + focal * below
                scratch[v, 2] = -depth
            elif depth > near:
                inverse = 1.0 / depth
                scratch[v, 0] = across + focal * right * inverse
                scratch[v, 1] = down + focal * below * inverse
                scratch[v, 2] = inverse
            else:  # kept in metres, for clipping
                scratch[v, 0] = right
                scratch[v, 1] = below
        for t in range(spans[s, 2], spans[s, 3]):
            a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            if flat or (scratch[a, 4] > near and scratch[b, 4] > near and scratch[c, 4] > near):
                if _is_seen(scratch, a, b, c, width, height):
                    _fill(scratch, a, b, c, s, keys, ids, shades)
            elif scratch[a, 4] > near or scratch[b, 4] > near or scratch[c, 4] > near:
                _clip(scratch, a, b, c, lens, s, keys, ids, shades)


@kernel()
def _is_out(
    m: Array,
    ball: Array,
    focal: float,
    across: float,
    down: float,
    near: float,
    far: float,
    width: int,
    height: int,
    flat: bool,
) -> bool:
    """Whether a ball lies outside of what the camera takes in."""
    radius = ball[3]
    x = m[0, 0] * ball[0] + m[0, 1] * ball[1] + m[0, 2] * ball[2] + m[0, 3]
    y = m[1, 0] * ball[0] + m[1, 1] * ball[1] + m[1, 2] * ball[2] + m[1, 3]
    z = m[2, 0] * ball[0] + m[2, 1] * ball[1] + m[2, 2] * ball[2] + m[2, 3]
    if flat:
        return bool(
            across + focal * (x + radius) < 0.0
            or across + focal * (x - radius) > width
            or down + focal * (y + radius) < 0.0
            or down + focal * (y - radius) > height
        )
    if z + radius < near or z - radius > far:
        return True
    # Distances from the four planes through the camera and the edges of the picture.
    left, right = across / focal, (width - across) / focal
    top, bottom = down / focal, (height - down) / focal
    return bool(
        -x - left * z > radius * math.sqrt(1.0 + left * left)
        or x - right * z > radius * math.sqrt(1.0 + right * right)
        or -y - top * z > radius * math.sqrt(1.0 + top * top)
        or y - bottom * z > radius * math.sqrt(1.0 + bottom * bottom)
    )


@kernel()
def _clip(
    scratch: Array,
    a: int,
    b: int,
    c: int,
    lens: Array,
    s: int,
    keys: Array,
    ids: Array,
    shades: Array,
) -> None:
    """Draw the part of a triangle that lies beyond the near plane."""
    focal, across, down, near = lens[0], lens[1], lens[2], lens[3]
    corners = np.empty((3, 4))  # right, below, depth in metres, and shade
    for place_, v in enumerate((a, b, c)):
        depth = scratch[v, 4]
        if depth > near:
            corners[place_, 0] = (scratch[v, 0] - across) / focal * depth
            corners[place_, 1] = (scratch[v, 1] - down) / focal * depth
        else:
            corners[place_, 0] = scratch[v, 0]
            corners[place_, 1] = scratch[v, 1]
        corners[place_, 2] = depth
        corners[place_, 3] = scratch[v, 3]
    kept = np.empty((4, 5), np.float32)
    count = 0
    for place_ in range(3):
        one, two = corners[place_], corners[(place_ + 1) % 3]
        if one[2] > near:
            _project(one, focal, across, down, kept[count])
            count += 1
        if (one[2] > near) != (two[2] > near):
            share = (near - one[2]) / (two[2] - one[2])
            cut = one + share * (two - one)
            cut[2] = near
            _project(cut, focal, across, down, kept[count])
            count += 1
    _fill(kept, 0, 1, 2, s, keys, ids, shades)
    if count == 4:
        _fill(kept, 0, 2, 3, s, keys, ids, shades)


@kernel()
def _project(corner: Array, focal: float, across: float, down: float, made: Array) -> None:
    inverse = 1.0 / corner[2]
    made[0] = across + focal * corner[0] * inverse
    made[1] = down + focal * corner[1] * inverse
    made[2] = inverse
    made[3] = corner[3]
    made[4] = corner[2]


@kernel(inline="always")
def _is_seen(corners: Array, a: int, b: int, c: int, width: int, height: int) -> bool:
    """Whether a triangle faces the camera, and may cover the centre of a pixel."""
    xa, ya, xb, yb = corners[a, 0], corners[a, 1], corners[b, 0], corners[b, 1]
    xc, yc = corners[c, 0], corners[c, 1]
    if (xb - xa) * (yc - ya) >= (xc - xa) * (yb - ya):
        return False
    low_y, high_y = min(ya, yb, yc), max(ya, yb, yc)
    if math.floor(high_y + 0.5 + _HAIR) <= math.ceil(low_y - 0.5 - _HAIR):
        return False
    low_x, high_x = min(xa, xb, xc), max(xa, xb, xc)
    if math.floor(high_x + 0.5 + _HAIR) <= math.ceil(low_x - 0.5 - _HAIR):
        return False
    return bool(high_x >= 0.0 and high_y >= 0.0 and low_x <= width and low_y <= height)


@kernel(error_model="numpy")
def _fill(
    corners: Array,
    a: int,
    b: int,
    c: int,
    s: int,
    keys: Array,
    ids: Array,
    shades: Array,
) -> None:
    """Draw a triangle on the screen, from three rows of `draw`'s scratch."""
    height, width = keys.shape
    xa, ya = float(corners[a, 0]), float(corners[a, 1])
    xb, yb = float(corners[b, 0]), float(corners[b, 1])
    xc, yc = float(corners[c, 0]), float(corners[c, 1])
    area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
    if area >= 0.0:
        return
    top = max(0, math.ceil(min(ya, yb, yc) - 0.5 - _HAIR))
    bottom = min(height - 1, math.floor(max(ya, yb, yc) - 0.5 + _HAIR))
    left = max(0, math.ceil(min(xa, xb, xc) - 0.5 - _HAIR))
    right = min(width - 1, math.floor(max(xa, xb, xc) - 0.5 + _HAIR))
    # Key and shade are linear on the screen.
    ka, sa = float(corners[a, 2]), float(corners[a, 3])
    kb, kc = corners[b, 2] - ka, corners[c, 2] - ka
    sb, sc = corners[b, 3] - sa, corners[c, 3] - sa
    inverse = 1.0 / area
    key_x = (kb * (yc - ya) - kc * (yb - ya)) * inverse
    key_y = (kc * (xb - xa) - kb * (xc - xa)) * inverse
    shade_x = (sb * (yc - ya) - sc * (yb - ya)) * inverse
    shade_y = (sc * (xb - xa) - sb * (xc - xa)) * inverse
    # Where each edge crosses a row: an edge that goes down bounds it from one side.
    for row in range(top, bottom + 1):
        y = row + 0.5
        begin, end = float(left), float(right)
        begin, end = _bounded(begin, end, xa, ya, xb, yb, y)
        begin, end = _bounded(begin, end, xb, yb, xc, yc, y)
        begin, end = _bounded(begin, end, xc, yc, xa, ya, y)
        first, last = math.ceil(begin), math.floor(end)
        key = ka + key_x * (first + 0.5 - xa) + key_y * (y - ya)
        shade = sa + shade_x * (first + 0.5 - xa) + shade_y * (y - ya)
        for column in range(first, last + 1):
            if key > keys[row, column]:
                keys[row, column] = key
                ids[row, column] = s
                shades[row, column] = shade
            key += key_x
            shade += shade_x


@kernel(inline="always", error_model="numpy")
def _bounded(
    begin: float, end: float, x0: float, y0: float, x1: float, y1: float, y: float
) -> tuple[float, float]:
    """The columns of a row that lie on the inner side of an edge."""
    rise = y1 - y0
    if rise > 0.0:
        crossing = x0 + (y - y0) * (x1 - x0) / rise - 0.5 - _HAIR
        return max(begin, crossing), end
    if rise < 0.0:
        crossing = x0 + (y - y0) * (x1 - x0) / rise - 0.5 + _HAIR
        return begin, min(end, crossing)
    return begin, end
