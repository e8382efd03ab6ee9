"""The inner loops, compiled by Numba.

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
from numba import njit
from numpy.typing import NDArray

Array = NDArray[Any]

_HAIR = 1e-6
"""Width in pixels by which triangles overlap, so that no pixel between two of them stays empty."""


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _project(corner: Array, focal: float, across: float, down: float, made: Array) -> None:
    inverse = 1.0 / corner[2]
    made[0] = across + focal * corner[0] * inverse
    made[1] = down + focal * corner[1] * inverse
    made[2] = inverse
    made[3] = corner[3]
    made[4] = corner[2]


@njit(cache=True, nogil=True, inline="always")
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
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


@njit(cache=True, nogil=True)
def resolve(
    keys: Array,
    ids: Array,
    shades: Array,
    colors: Array,
    backdrop: Array,
    far: float,
    rgb: Array,
    depth: Array,
) -> None:
    """Colours and depths from a z-buffer.

    Args:
        keys: (h, w) float32.
        ids: (h, w) int32, -1 where nothing is.
        shades: (h, w) float32.
        colors: (s, 3) float32, 0 to 255.
        backdrop: (h, 3) uint8, what is behind everything, by row.
        far: Depth where nothing is, m.
        rgb: (h, w, 3) uint8, which is written.
        depth: (h, w) float32, which is written.
    """
    height, width = ids.shape
    for row in range(height):
        for column in range(width):
            s = ids[row, column]
            if s < 0:
                depth[row, column] = far
                for channel in range(3):
                    rgb[row, column, channel] = backdrop[row, channel]
            else:
                depth[row, column] = 1.0 / keys[row, column]
                shade = shades[row, column]
                for channel in range(3):
                    value = colors[s, channel] * shade + 0.5
                    rgb[row, column, channel] = np.uint8(min(255.0, value))


@njit(cache=True, nogil=True)
def blend(
    keys: Array, over_keys: Array, over_shades: Array, color: Array, opacity: float, rgb: Array
) -> None:
    """Paint a translucent shape over what is behind it."""
    height, width = keys.shape
    for row in range(height):
        for column in range(width):
            if over_keys[row, column] > keys[row, column]:
                shade = over_shades[row, column]
                for channel in range(3):
                    own = min(255.0, color[channel] * shade)
                    behind = rgb[row, column, channel]
                    rgb[row, column, channel] = np.uint8(
                        opacity * own + (1.0 - opacity) * behind + 0.5
                    )


@njit(cache=True, nogil=True)
def darken(
    keys: Array,
    ids: Array,
    shades: Array,
    world: Array,
    lens: Array,
    lamp_view: Array,
    lamp_lens: Array,
    lamp_keys: Array,
    ambient: float,
    bias: float,
    darkness: float,
) -> None:
    """Take the diffuse light from what the lamp does not reach.

    Args:
        keys: (h, w) of the picture.
        ids: (h, w) of the picture.
        shades: (h, w) of the picture, which are changed.
        world: (3, 4) rotation and position of the camera in the world.
        lens: As for `draw`.
        lamp_view: (3, 4) rotation and position of the world as the lamp sees it.
        lamp_lens: As for `draw`, orthographic.
        lamp_keys: (m, m) z-buffer of the lamp.
        ambient: Share of light that is left.
        bias: Depth by which a surface does not shade itself, m.
        darkness: Share of the diffuse light that a shadow takes away.
    """
    height, width = keys.shape
    size = lamp_keys.shape[0]
    for row in range(height):
        for column in range(width):
            if ids[row, column] < 0 or shades[row, column] <= ambient:
                continue
            z = 1.0 / keys[row, column]
            x = (column + 0.5 - lens[1]) / lens[0] * z
            y = (row + 0.5 - lens[2]) / lens[0] * z
            wx = world[0, 0] * x + world[0, 1] * y + world[0, 2] * z + world[0, 3]
            wy = world[1, 0] * x + world[1, 1] * y + world[1, 2] * z + world[1, 3]
            wz = world[2, 0] * x + world[2, 1] * y + world[2, 2] * z + world[2, 3]
            u = _along(lamp_view, 0, wx, wy, wz) * lamp_lens[0] + lamp_lens[1] - 0.5
            v = _along(lamp_view, 1, wx, wy, wz) * lamp_lens[0] + lamp_lens[2] - 0.5
            key = -_along(lamp_view, 2, wx, wy, wz) + bias
            left, top = math.floor(u), math.floor(v)
            if left < 1 or top < 1 or left >= size - 2 or top >= size - 2:
                continue
            # Of the sixteen texels around, weighted as if the middle nine were a soft square.
            right_share, low_share = u - left, v - top
            lit = 0.0
            for down in range(-1, 3):
                weight_y = 1.0
                if down == -1:
                    weight_y = 1.0 - low_share
                elif down == 2:
                    weight_y = low_share
                for across in range(-1, 3):
                    weight = weight_y
                    if across == -1:
                        weight *= 1.0 - right_share
                    elif across == 2:
                        weight *= right_share
                    if key >= lamp_keys[top + down, left + across]:
                        lit += weight
            left_over = 1.0 - darkness * (1.0 - lit / 9.0)
            shades[row, column] = ambient + (shades[row, column] - ambient) * left_over


@njit(cache=True, nogil=True, inline="always")
def _along(view: Array, axis: int, x: float, y: float, z: float) -> float:
    return float(view[axis, 0] * x + view[axis, 1] * y + view[axis, 2] * z + view[axis, 3])
