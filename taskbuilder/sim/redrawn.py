"""Meshes written anew for Bullet's renderers, which draw three kinds of mesh wrong.

They draw a mesh with a negative scale inside out, or lit from the wrong side, they ignore the
diffuse colours of materials, and they keep the hue of a texture under paint. The rasteriser needs
none of this.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.looks import WHITE, MeshLook
from taskbuilder.assets.mesh import Mesh, read_mesh
from taskbuilder.sim.mesh_colors import face_colors, materials_of


def redrawn(look: MeshLook, folder: Path) -> tuple[MeshLook, ...]:
    """What Bullet draws right in place of a mesh: the mesh itself, or a mesh for each colour.

    Args:
        look: The mesh.
        folder: Where meshes are written.
    """
    mesh = read_mesh(look.file)
    unpainted = look.color in (None, WHITE)
    signs = np.sign(look.scale)
    mirrored = bool((signs < 0.0).any())
    materials = materials_of(mesh)
    textured = any(material.texture for material in materials)
    colored = any(material.color for material in materials)
    if not mirrored and (textured or not colored if unpainted else not textured):
        return (look,)
    tints, tint_of = face_colors(mesh, diffuse=unpainted)
    base = look.color or WHITE
    made = []
    for number, (red, green, blue) in enumerate(tints):
        file = folder / f"{len(list(folder.iterdir()))}-{look.file.stem}.obj"
        file.write_text(_obj(mesh, tint_of == number, signs), encoding="utf-8")
        color = (base[0] * red, base[1] * green, base[2] * blue, base[3])
        x, y, z = map(abs, look.scale)
        made.append(MeshLook(file, (x, y, z), color))
    return tuple(made)


def _obj(mesh: Mesh, chosen: NDArray[np.bool_], signs: NDArray[np.float64]) -> str:
    """Some triangles of a mesh as an OBJ file.

    Args:
        mesh: The mesh.
        chosen: (triangles,) which of them.
        signs: (3,) factors of the coordinates, 1 or -1.
    """
    points = np.array(mesh.points, np.float64).reshape(-1, 3) * signs
    triangles = np.array(mesh.corners, np.int64).reshape(-1, 3)[chosen]
    if signs.prod() < 0.0:  # a mirror image, in which triangles run the other way round
        triangles = triangles[:, ::-1]
    left, numbers = np.unique(triangles, return_inverse=True)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points[left].tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (numbers.reshape(-1, 3) + 1).tolist()]
    return "\n".join([*lines, ""])
