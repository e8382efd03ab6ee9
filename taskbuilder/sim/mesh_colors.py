"""Colours of a mesh's faces, from the texture that its material file names.

A face has the colour of the texture at its middle, and similar colours are made one. That is exact
for palettes, which is how robots are painted, and coarse for photographs.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.paths import AssetError, resolve

WHITE = (1.0, 1.0, 1.0)
_LEVELS = 16
"""Shades of a channel that count as different colours."""

Color = tuple[float, float, float]


def face_colors(mesh: Mesh) -> tuple[list[Color], NDArray[np.intp]]:
    """The colours of a mesh's triangles.

    Args:
        mesh: The mesh.

    Returns:
        Colours from 0 to 1, and the number of each triangle's; white without a texture.
    """
    texture = _texture(mesh.path, mesh.material_files)
    if texture is None:
        return [WHITE], np.zeros(mesh.triangles, np.intp)
    points = np.asarray(mesh.texture_points).reshape(-1, 2)
    middles = points[np.asarray(mesh.texture_corners).reshape(-1, 3)].mean(axis=1)
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


def _texture(mesh: Path, material_files: Sequence[str]) -> NDArray[np.uint8] | None:
    """The picture that the last material file names, (h, w, 3) RGB; None if there is none."""
    if not material_files:
        return None
    try:
        materials = resolve(material_files[-1], mesh.parent, [mesh.parent])
        for line in materials.read_text(encoding="utf-8", errors="replace").splitlines():
            words = line.split()
            if len(words) > 1 and words[0] == "map_Kd":
                picture = cv2.imread(str(resolve(words[-1], mesh.parent, [mesh.parent])))
                if picture is not None:
                    return np.ascontiguousarray(picture[:, :, ::-1]).astype(np.uint8)
    except (AssetError, OSError):
        return None  # it is drawn in its link's colour, as Bullet does
    return None
