"""From a z-buffer to a picture: colours, depths, translucent shapes and shadows.

Compiled by Numba; see `filling` for the buffers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster.kernels import kernel

Array = NDArray[Any]


@kernel()
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


@kernel()
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


@kernel()
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
            wx, wy, wz, _ = seen_point(row, column, keys[row, column], lens, world)
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


@kernel(inline="always")
def seen_point(
    row: int, column: int, key: float, lens: Array, world: Array
) -> tuple[float, float, float, float]:
    """The point in the world that a pixel shows, and its depth, m.

    Args:
        row: Of the pixel.
        column: Of the pixel.
        key: Of the pixel, in a z-buffer under perspective.
        lens: As for `filling.draw`.
        world: (3, 4) rotation and position of the camera in the world.
    """
    z = 1.0 / key
    x = (column + 0.5 - lens[1]) / lens[0] * z
    y = (row + 0.5 - lens[2]) / lens[0] * z
    return (
        world[0, 0] * x + world[0, 1] * y + world[0, 2] * z + world[0, 3],
        world[1, 0] * x + world[1, 1] * y + world[1, 2] * z + world[1, 3],
        world[2, 0] * x + world[2, 1] * y + world[2, 2] * z + world[2, 3],
        z,
    )


@kernel(inline="always")
def _along(view: Array, axis: int, x: float, y: float, z: float) -> float:
    return float(view[axis, 0] * x + view[axis, 1] * y + view[axis, 2] * z + view[axis, 3])
