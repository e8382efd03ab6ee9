"""Meshes as taskbuilder reads them: OBJ files with materials, few triangles, the same bytes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from taskbuilder.extras import extra_needed
from taskbuilder.importing.mesh_files import Color, Piece
from taskbuilder.importing.surfaces import Floats, Integers, nearest, welded_mesh

_DIGITS = 7
_GREY: Color = (0.75, 0.75, 0.75, 1.0)


def decimated(pieces: Sequence[Piece], most: int) -> tuple[Piece, ...]:
    """Pieces with at most about so many triangles in all.

    Each keeps its share of them. Texture points are those of the nearest points of the original.
    """
    count = sum(len(piece.faces) for piece in pieces)
    if count <= most:
        return tuple(pieces)
    with extra_needed("import", "decimating meshes"):
        import fast_simplification
    kept = []
    for piece in pieces:
        goal = max(12, int(len(piece.faces) * most / count))
        if len(piece.faces) <= goal:
            kept.append(piece)
            continue
        welded, faces = welded_mesh(piece.points, piece.faces)
        points, faces = fast_simplification.simplify(
            welded.astype(np.float32), faces.astype(np.int32), target_count=goal
        )
        if not len(faces):
            continue
        points, faces = np.asarray(points, np.float64), np.asarray(faces, np.int64)
        uv = None if piece.uv is None else piece.uv[nearest(points, piece.points)]
        kept.append(replace(piece, points=points, faces=faces, uv=uv))
    return tuple(kept)


def obj_files(stem: str, pieces: Sequence[Piece]) -> dict[str, bytes]:
    """An OBJ file, with the material file and textures that it needs, by name."""
    files: dict[str, bytes] = {}
    looks = [(piece.color, piece.texture) for piece in pieces]
    plain = all(color is None and texture is None for color, texture in looks)
    lines = [] if plain else [f"mtllib {stem}.mtl"]
    materials: dict[tuple[Color | None, bytes | None], str] = {}
    after_points, after_uv = 1, 1
    for piece, look in zip(pieces, looks, strict=True):
        if not plain and look not in materials:
            materials[look] = f"look_{len(materials)}"
        lines += _rows("v", piece.points)
        if piece.uv is not None and piece.texture is not None:
            lines += _rows("vt", piece.uv)
        if not plain:
            lines.append(f"usemtl {materials[look]}")
        corners = piece.faces + after_points
        if piece.uv is not None and piece.texture is not None:
            texture = piece.faces + after_uv
            lines += [
                f"f {a}/{u} {b}/{v} {c}/{w}"
                for (a, b, c), (u, v, w) in zip(corners.tolist(), texture.tolist(), strict=True)
            ]
            after_uv += len(piece.uv)
        else:
            lines += [f"f {a} {b} {c}" for a, b, c in corners.tolist()]
        after_points += len(piece.points)
    files[f"{stem}.obj"] = ("\n".join(lines) + "\n").encode()
    if not plain:
        files[f"{stem}.mtl"] = "".join(_materials(stem, materials, files)).encode()
    return files


def compound_obj(parts: Sequence[tuple[Floats, Integers]]) -> bytes:
    """An OBJ file with one group per convex part, of which the physics engine makes a compound."""
    lines: list[str] = []
    after = 1
    for number, (points, faces) in enumerate(parts):
        lines.append(f"o part_{number}")
        lines += _rows("v", points)
        lines += [f"f {a} {b} {c}" for a, b, c in (faces + after).tolist()]
        after += len(points)
    return ("\n".join(lines) + "\n").encode()


def _rows(kind: str, values: Floats) -> Iterable[str]:
    rounded = np.round(values, _DIGITS) + 0.0
    return (f"{kind} " + " ".join(f"{number:.7g}" for number in row) for row in rounded.tolist())


def _materials(
    stem: str, materials: dict[tuple[Color | None, bytes | None], str], files: dict[str, bytes]
) -> Iterable[str]:
    for (color, texture), name in materials.items():
        red, green, blue, opacity = color or ((1.0,) * 4 if texture else _GREY)
        yield f"newmtl {name}\nKd {red:g} {green:g} {blue:g}\nd {opacity:g}\n"
        if texture is not None:
            picture = f"{stem}_{hashlib.sha256(texture).hexdigest()[:8]}.png"
            files[picture] = texture
            yield f"map_Kd {picture}\n"
