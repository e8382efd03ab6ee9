"""Colours of a mesh's faces, from the texture that its material file names.

A face has the colour of the texture at its middle, and similar colours are made one. That is exact
for palettes, which is how robots are painted, and coarse for photographs.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.paths import AssetError, resolve

WHITE = (1.0, 1.0, 1.0)
_LEVELS = 16
"""Shades of a channel that count as different colours."""

Color = tuple[float, float, float]


def face_colors(path: Path, count: int) -> tuple[list[Color], NDArray[np.intp]]:
    """The colours of a mesh's triangles.

    Args:
        path: A mesh file that was read by `read_mesh`.
        count: Number of its triangles.

    Returns:
        Colours from 0 to 1, and the number of each triangle's; white without a texture.
    """
    plain = [WHITE], np.zeros(count, np.intp)
    if path.suffix.lower() != ".obj":
        return plain
    middles, material_file = _middles(path)
    texture = _texture(path, material_file)
    if texture is None or len(middles) != count:
        return plain
    height, width, _ = texture.shape
    columns = (np.mod(middles[:, 0], 1.0) * width).astype(np.intp) % width
    rows = (np.mod(1.0 - middles[:, 1], 1.0) * height).astype(np.intp) % height
    colors = texture[rows, columns]
    _, group = np.unique(colors // (256 // _LEVELS), axis=0, return_inverse=True)
    group = group.reshape(-1)
    return [_mean(colors[group == number]) for number in range(group.max() + 1)], group


def _mean(colors: NDArray[np.uint8]) -> Color:
    red, green, blue = (colors.mean(axis=0) / 255.0).tolist()
    return (red, green, blue)


def _middles(path: Path) -> tuple[NDArray[np.float64], str]:
    """Texture coordinates of the middles of triangles, and the name of the material file."""
    points = [(0.0, 0.0)]  # of corners without texture coordinates, as in Bullet
    corners: list[tuple[int, int, int]] = []
    material_file = ""
    for line in path.read_bytes().split(b"\n"):
        words = line.split()
        if not words:
            continue
        if words[0] == b"vt":
            points.append((float(words[1]), float(words[2])))
        elif words[0] == b"mtllib" and len(words) > 1:
            material_file = words[1].decode(errors="replace")
        elif words[0] == b"f":
            numbers = [[*word.split(b"/"), b""][1] for word in words[1:]]
            first, *others = [int(number or 0) for number in numbers]  # 1 is the first, -1 the last
            corners += [(first, *pair) for pair in pairwise(others)]
    middles = np.array(points)[np.array(corners, np.intp).reshape(-1, 3)].mean(axis=1)
    return middles, material_file


def _texture(mesh: Path, material_file: str) -> NDArray[np.uint8] | None:
    """The picture that the material file names, (h, w, 3) RGB; None if there is none."""
    if not material_file:
        return None
    try:
        materials = resolve(material_file, mesh.parent, [mesh.parent])
        for line in materials.read_text(encoding="utf-8", errors="replace").splitlines():
            words = line.split()
            if len(words) > 1 and words[0] == "map_Kd":
                picture = cv2.imread(str(resolve(words[-1], mesh.parent, [mesh.parent])))
                if picture is not None:
                    return np.ascontiguousarray(picture[:, :, ::-1]).astype(np.uint8)
    except (AssetError, OSError):
        return None  # it is drawn in its link's colour, as Bullet does
    return None
