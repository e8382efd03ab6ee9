"""Textures that are computed: each is a function of a point in the shape's frame.

No shape needs texture coordinates, and no picture is read. Compiled by Numba; see `filling` for
the buffers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster.finishing import seen_point
from taskbuilder.raster.kernels import kernel

Array = NDArray[Any]

KINDS = ("checks", "stripes", "grain", "speckles")
"""Names of the patterns; their places are their numbers."""

_LEAST_BLUR = 1e-3


@dataclass(frozen=True)
class Pattern:
    """A second colour, which alternates with the shape's own.

    Attributes:
        kind: One of `KINDS`.
        color: The second colour: red, green and blue, 0 to 1.
        period: Length after which the pattern repeats, or nearly so, m.
        angle: Direction of the pattern about the shape's z axis, rad.
    """

    kind: str
    color: tuple[float, float, float]
    period: float
    angle: float

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """Kind, period, and cosine and sine of the angle, for `paint`."""
        return (KINDS.index(self.kind), self.period, math.cos(self.angle), math.sin(self.angle))


@kernel()
def paint(
    keys: Array,
    ids: Array,
    shades: Array,
    world: Array,
    lens: Array,
    poses: Array,
    numbers: Array,
    colors: Array,
    seconds: Array,
    rgb: Array,
) -> None:
    """Colour the pixels of shapes that have a pattern.

    Args:
        keys: (h, w) of the picture.
        ids: (h, w) of the picture.
        shades: (h, w) of the picture.
        world: (3, 4) rotation and position of the camera in the world.
        lens: As for `filling.draw`.
        poses: (s, 3, 4) of the shapes in the world.
        numbers: (s, 4) of `Pattern.numbers`; a kind below 0 stands for no pattern.
        colors: (s, 3) float32, 0 to 255.
        seconds: (s, 3) float32, the second colours, 0 to 255.
        rgb: (h, w, 3) uint8, which is changed.
    """
    height, width = ids.shape
    for row in range(height):
        for column in range(width):
            s = ids[row, column]
            if s < 0 or numbers[s, 0] < 0.0:
                continue
            x, y, z, depth = seen_point(row, column, keys[row, column], lens, world)
            x, y, z = x - poses[s, 0, 3], y - poses[s, 1, 3], z - poses[s, 2, 3]
            px = poses[s, 0, 0] * x + poses[s, 1, 0] * y + poses[s, 2, 0] * z
            py = poses[s, 0, 1] * x + poses[s, 1, 1] * y + poses[s, 2, 1] * z
            pz = poses[s, 0, 2] * x + poses[s, 1, 2] * y + poses[s, 2, 2] * z
            period, cosine, sine = numbers[s, 1], numbers[s, 2], numbers[s, 3]
            u, v = (cosine * px + sine * py) / period, (cosine * py - sine * px) / period
            # Of a period, how much a pixel covers. Finer patterns than that are seen as their mean.
            blur = max(_LEAST_BLUR, depth / lens[0] / period)
            share = _share(int(numbers[s, 0]), u, v, pz / period, blur)
            share = 0.5 + (share - 0.5) / (1.0 + 16.0 * blur**4)
            for channel in range(3):
                own = colors[s, channel]
                value = (own + share * (seconds[s, channel] - own)) * shades[row, column] + 0.5
                rgb[row, column, channel] = np.uint8(min(255.0, value))


@kernel()
def _share(kind: int, u: float, v: float, w: float, blur: float) -> float:
    """The share of the second colour, from 0 to 1, at a point given in periods."""
    if kind == 0:  # a third of a period keeps the faces of boxes out of the planes between checks
        level = math.sin(math.pi * 2.0 * u) * math.sin(math.pi * 2.0 * v)
        return _sharp(level * math.sin(math.pi * 2.0 * (w + 0.3)), blur)
    if kind == 1:
        return _sharp(math.sin(math.pi * 2.0 * (u + w)), blur)
    if kind == 2:  # lines along u that waver, as the rings of a board do
        waver = _noise(0.3 * u, 0.9 * v, 0.9 * w)
        return 0.5 + 0.5 * math.sin(math.pi * 2.0 * (v + w + 1.5 * waver))
    spots = _noise(3.0 * u, 3.0 * v, 3.0 * w)
    return min(1.0, max(0.0, 6.0 * (spots - 0.55)))


@kernel(inline="always")
def _sharp(wave: float, blur: float) -> float:
    """A step at the zeros of a sine, as wide as a pixel."""
    return min(1.0, max(0.0, 0.5 + wave / (2.0 * math.pi * blur)))


@kernel()
def _noise(x: float, y: float, z: float) -> float:
    """Value noise: random numbers on a grid, with smooth transitions between them; 0 to 1."""
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    fx, fy, fz = x - i, y - j, z - k
    fx, fy, fz = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy), fz * fz * (3 - 2 * fz)
    total = 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (fx if a else 1 - fx) * (fy if b else 1 - fy) * (fz if c else 1 - fz)
                total += weight * _hash(int(i) + a, int(j) + b, int(k) + c)
    return total


@kernel(inline="always")
def _hash(i: int, j: int, k: int) -> float:
    """A number from 0 to 1 for each point of the grid."""
    mixed = (i * 73856093) ^ (j * 19349663) ^ (k * 83492791)
    mixed = (mixed ^ (mixed >> 13)) * 1274126177
    return float((mixed ^ (mixed >> 16)) & 0xFFFF) / 65535.0
