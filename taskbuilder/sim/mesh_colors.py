"""Colours of a mesh's faces, from the materials that its OBJ file names.

A face has the diffuse colour of its material or, if the material has a texture, the colour of the
texture at the middle of the face. Similar colours of a texture are made one. That is exact for
palettes, which is how robots are painted, and coarse for photographs.

Of a mesh that is painted, a texture keeps its pattern and not its hue: it becomes shades of grey,
by which the paint is multiplied. A cup that a task file makes orange is then orange in pictures.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
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
Texture = NDArray[np.uint8]


@dataclass(frozen=True)
class Material:
    """What an MTL file says of the look of faces.

    Attributes:
        color: Diffuse colour (Kd), 0 to 1; None if the file gives none.
        texture: Picture of the diffuse colour (map_Kd), or None.
    """

    color: Color | None = None
    texture: Path | None = None

    def shown(self, *, diffuse: bool) -> Path | Color:
        """The texture or, if there is none, the colour."""
        return self.texture or (self.color if diffuse else None) or WHITE


def face_colors(mesh: Mesh, *, diffuse: bool = True) -> tuple[list[Color], NDArray[np.intp]]:
    """The colours of a mesh's triangles.

    Args:
        mesh: The mesh.
        diffuse: Whether the colours of materials count. If not, as the mesh is painted, diffuse
            colours are left out, and textures are shades of grey.

    Returns:
        Colours from 0 to 1, and the number of each triangle's; white without a material.
    """
    count = mesh.triangles
    colors: list[Color] = []
    color_of = np.zeros(count, np.intp)
    used = np.asarray(mesh.face_materials, np.intp) if mesh.materials else np.zeros(count, np.intp)
    looks = materials_of(mesh)
    alike: dict[Path | Color, list[int]] = {}
    for number in np.unique(used):
        alike.setdefault(looks[number].shown(diffuse=diffuse) if looks else WHITE, []).append(
            number
        )
    for look, numbers in alike.items():
        own = np.isin(used, numbers)
        found, which = _from_texture(mesh, own, look) if isinstance(look, Path) else ([look], 0)
        color_of[own] = len(colors) + which
        if not diffuse:
            found = _shades(found, np.broadcast_to(which, own.sum()), _areas(mesh)[own])
        colors += found
    return colors, color_of


def materials_of(mesh: Mesh) -> tuple[Material, ...]:
    """The material of each name in the mesh's ``materials``.

    Faces without a material have the first one with a texture, as with Bullet.
    """
    known: dict[str, Material] = {}
    for file in mesh.material_files:
        known |= _read_materials(mesh.path, file)
    textured = (one for one in known.values() if one.texture)
    known.setdefault("", next(textured, Material()))
    return tuple(known.get(name, Material()) for name in mesh.materials)


def has_colors(mesh: Mesh) -> bool:
    """Whether a mesh's materials give it a look of its own."""
    return any(one.texture or one.color not in (None, WHITE) for one in materials_of(mesh))


def _from_texture(
    mesh: Mesh, chosen: NDArray[np.bool_], file: Path
) -> tuple[list[Color], NDArray[np.intp]]:
    """The colours of some triangles in a texture, and the number of each triangle's."""
    texture = _picture(file)
    if texture is None:
        return [WHITE], np.zeros(int(chosen.sum()), np.intp)
    points = np.asarray(mesh.texture_points).reshape(-1, 2)
    middles = points[np.asarray(mesh.texture_corners).reshape(-1, 3)[chosen]].mean(axis=1)
    height, width, _ = texture.shape
    columns = (np.mod(middles[:, 0], 1.0) * width).astype(np.intp) % width
    rows = (np.mod(1.0 - middles[:, 1], 1.0) * height).astype(np.intp) % height
    colors = texture[rows, columns]
    _, group = np.unique(colors // (256 // _LEVELS), axis=0, return_inverse=True)
    group = group.reshape(-1)
    return [_mean(colors[group == number]) for number in range(group.max() + 1)], group


def _shades(
    colors: list[Color], which: NDArray[np.intp], areas: NDArray[np.float64]
) -> list[Color]:
    """Colours as shades of grey, by their luma of ITU-R BT.601; from the mean on, they are white.

    Args:
        colors: The colours.
        which: (triangles,) number of the colour of each triangle.
        areas: (triangles,) by which the mean is weighted.
    """
    lumas = np.array(colors) @ (0.299, 0.587, 0.114)
    mean = float(np.average(lumas[which], weights=areas)) if areas.any() else 0.0
    shades = np.minimum(lumas / mean, 1.0) if mean else np.ones(len(colors))
    return [(shade, shade, shade) for shade in shades.tolist()]


def _areas(mesh: Mesh) -> NDArray[np.float64]:
    """(triangles,) areas."""
    corners = np.array(mesh.points).reshape(-1, 3)[np.array(mesh.corners).reshape(-1, 3)]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(np.linalg.norm(np.cross(first, second), axis=1) / 2.0)


def _mean(colors: Texture) -> Color:
    red, green, blue = (colors.mean(axis=0) / 255.0).tolist()
    return (red, green, blue)


def _read_materials(mesh: Path, file: str) -> Mapping[str, Material]:
    """The materials of an MTL file, by name; none if there is no such file."""
    found: dict[str, Material] = {}
    try:
        path = resolve(file, mesh.parent, [mesh.parent])
        text = path.read_text(encoding="utf-8", errors="replace")
    except (AssetError, OSError):
        return found  # it is drawn in its link's colour, as Bullet does
    name = ""
    for key, words in _statements(text):
        if key == "newmtl":
            name = " ".join(words)
            found[name] = Material()
        elif key == "Kd" and (color := _color(words)):
            found[name] = replace(found.get(name, Material()), color=color)
        elif key == "map_Kd" and words:
            try:
                picture = resolve(words[-1], mesh.parent, [mesh.parent])
            except AssetError:
                continue  # as above
            found[name] = replace(found.get(name, Material()), texture=picture)
    return found


def _statements(text: str) -> Iterator[tuple[str, list[str]]]:
    for line in text.splitlines():
        key, *words = line.split() or [""]
        yield key, words


def _color(words: list[str]) -> Color | None:
    """The colour of a line ``Kd r g b``, or of ``Kd r`` for grey; None for other forms."""
    try:
        parts = [min(1.0, max(0.0, float(word))) for word in words]
    except ValueError:
        return None
    if len(parts) == 1:
        return (parts[0], parts[0], parts[0])
    return (parts[0], parts[1], parts[2]) if len(parts) == 3 else None


def _picture(path: Path) -> Texture | None:
    """A texture, (h, w, 3) RGB; None if it cannot be read."""
    picture = cv2.imread(str(path))
    return None if picture is None else np.ascontiguousarray(picture[:, :, ::-1]).astype(np.uint8)
