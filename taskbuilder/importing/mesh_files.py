"""Reading meshes of any format: their triangles, colours and textures, unit and up axis."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from taskbuilder.assets import codes
from taskbuilder.assets.paths import AssetError
from taskbuilder.extras import extra_needed
from taskbuilder.importing.packages import MAX_BYTES, Packages
from taskbuilder.importing.surfaces import Floats, Integers, same_rows

Up = Literal["x", "y", "z"]
Color = tuple[float, float, float, float]

FORMATS = (".dae", ".glb", ".gltf", ".ply", ".obj", ".stl", ".off")
MOST_SOURCE_TRIANGLES = 3_000_000
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
_ARCHIVES = (".zip", ".gz", ".tar", ".tgz", ".7z", ".rar", ".zae", ".bz2", ".xz")
_FARTHEST = 1e12  # beyond which a coordinate is no measure, whatever its unit
_LEAST_DETERMINANT = 1e-12


@dataclass(frozen=True, eq=False)
class Piece:
    """Triangles that look alike.

    Attributes:
        points: (n, 3), in metres once the unit is known.
        faces: (m, 3) numbers of points.
        uv: (n, 2) texture points, or None.
        color: Red, green, blue and opacity, or None.
        texture: PNG bytes of its texture, or None.
    """

    points: Floats
    faces: Integers
    uv: Floats | None = None
    color: Color | None = None
    texture: bytes | None = None


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh as it was read.

    Attributes:
        path: The file.
        pieces: Its triangles by look.
        unit_m: Metres of one unit, where the format states it; None where it does not.
        up: The up axis that the format states; None where it states none.
        oddities: What was mended while reading, in words.
    """

    path: Path
    pieces: tuple[Piece, ...]
    unit_m: float | None
    up: Up | None
    oddities: tuple[str, ...] = ()

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return sum(len(piece.faces) for piece in self.pieces)

    @property
    def bounds(self) -> Floats:
        """(2, 3): the smallest and greatest coordinates."""
        points = np.concatenate([piece.points for piece in self.pieces])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def soup(self) -> tuple[Floats, Integers]:
        """All triangles as one mesh: (n, 3) points and (m, 3) faces."""
        offsets = np.cumsum([0, *(len(piece.points) for piece in self.pieces)])
        faces = [piece.faces + offset for piece, offset in zip(self.pieces, offsets, strict=False)]
        return np.concatenate([piece.points for piece in self.pieces]), np.concatenate(faces)

    def moved(self, matrix: Floats) -> MeshFile:
        """The same under a linear map or an affine one; mirrored triangles keep facing outwards."""
        linear, shift = matrix[:3, :3], matrix[:3, 3] if matrix.shape == (4, 4) else np.zeros(3)
        turned = np.linalg.det(linear) < 0.0
        pieces = tuple(
            replace(
                piece,
                points=piece.points @ linear.T + shift,
                faces=piece.faces[:, ::-1] if turned else piece.faces,
            )
            for piece in self.pieces
        )
        return replace(self, pieces=pieces)


def load_mesh(path: Path, packages: Packages) -> MeshFile:
    """Read a mesh.

    Args:
        path: The file, which is known to lie inside the import root.
        packages: Where the files that it names may lie.

    Raises:
        AssetError: It cannot be read, holds nothing, or has another format.
        UsageError: The extra is not installed.
    """
    suffix = path.suffix.lower()
    if suffix in _ARCHIVES:
        raise AssetError(codes.NOT_IMPORTED, f"{path.name} is an archive; unpack it first")
    if suffix not in FORMATS:
        raise AssetError(
            codes.MESH_FORMAT,
            f"{path.name}: meshes of type {suffix or '(none)'} are not read; "
            f"save it as one of {', '.join(FORMATS)}",
        )
    with extra_needed("import", "importing meshes"):
        import trimesh
    data = path.read_bytes()
    if len(data) > MAX_BYTES:
        raise AssetError(codes.NOT_READABLE, f"{path.name} has more than {MAX_BYTES >> 20} MB")
    if data[:4] == b"PK\x03\x04":
        raise AssetError(codes.NOT_IMPORTED, f"{path.name} is an archive; unpack it first")
    if suffix == ".dae" and (b"<!ENTITY" in data or b"<!DOCTYPE" in data):
        raise AssetError(
            codes.XML, f"{path.name} has a document type declaration, which is not read; delete it"
        )
    if data.startswith(b"version https://git-lfs"):
        raise AssetError(
            codes.NOT_READABLE,
            f"{path.name} is a pointer of Git LFS, not the file; run git lfs pull",
        )
    _require_few(path, _stated_count(suffix, data))  # before minutes are spent on reading it
    resolver: Any = _Resolver(path, packages)
    try:
        with np.errstate(all="ignore"), extra_needed("import", f"reading {suffix} files"):
            scene = trimesh.load_scene(
                io.BytesIO(data),
                file_type=suffix[1:],
                resolver=resolver,
                process=False,
            )
    except (AssetError, MemoryError):
        raise
    except Exception as error:
        if type(error).__name__ == "UsageError":
            raise
        _require_unpacked(path, data)
        raise AssetError(
            codes.BAD_MESH, f"{path.name} cannot be read ({type(error).__name__}: {error}); "
            "export it again",
        ) from error  # fmt: skip
    oddities: list[str] = []
    pieces = tuple(_pieces(scene, oddities))
    if not pieces:
        _require_unpacked(path, data)
        raise AssetError(
            codes.BAD_MESH, f"{path.name}: has no triangles; export it with its surface"
        )
    _require_few(path, sum(len(piece.faces) for piece in pieces))
    unit, up = _stated(suffix, data)
    return MeshFile(path, pieces, unit, up, tuple(oddities))


_PACKED = {b"KHR_draco_mesh_compression": "Draco", b"EXT_meshopt_compression": "meshopt"}
"""Extensions of glTF that compress triangles."""


def _require_unpacked(path: Path, data: bytes) -> None:
    for name, how in _PACKED.items():
        if name in data:
            said = f"is compressed ({how}), which is not read; export it without compression"
            raise AssetError(codes.BAD_MESH, f"{path.name}: {said}")


def _stated_count(suffix: str, data: bytes) -> int:
    """About how many triangles a file says that it has; 0 where that takes reading it."""
    if suffix == ".stl":
        stated = int.from_bytes(data[80:84], "little")
        return stated if len(data) == 84 + 50 * stated else data.count(b"endfacet")
    if suffix == ".obj":
        return data.count(b"\nf ")
    if suffix == ".dae":
        lists = re.findall(rb"<(?:triangles|polylist)\b[^>]*\bcount=\"(\d{1,12})\"", data)
        return sum(int(count) for count in lists)
    stated_faces = re.search(rb"element face (\d{1,12})", data[:4000])
    return int(stated_faces[1]) if suffix == ".ply" and stated_faces else 0


def _require_few(path: Path, count: int) -> None:
    if count > MOST_SOURCE_TRIANGLES:
        raise AssetError(
            codes.BAD_MESH,
            f"{path.name}: has {count:,} triangles; reduce it below {MOST_SOURCE_TRIANGLES:,}",
        )


class _Resolver:
    """Gives readers the files that a mesh names, from inside the import root."""

    def __init__(self, mesh: Path, packages: Packages) -> None:
        self._folder, self._packages = mesh.parent, packages

    def get(self, name: str) -> bytes:
        """The content of a file beside the mesh."""
        try:
            return self._packages.locate(name.strip(), self._folder).read_bytes()
        except AssetError as error:
            raise FileNotFoundError(str(error)) from None

    __getitem__ = get

    def namespaced(self, _namespace: str) -> _Resolver:
        """Part of the interface of trimesh's resolvers."""
        return self


def _stated(suffix: str, data: bytes) -> tuple[float | None, Up | None]:
    """Unit in metres and up axis that a file states."""
    if suffix in (".glb", ".gltf"):
        return 1.0, "y"
    if suffix == ".dae":
        head = data[:20_000].decode(errors="replace")
        axis = re.search(r"<up_axis>\s*([XYZ])_UP", head)
        unit = re.search(r"<unit[^>]*\bmeter=\"([0-9.eE+-]+)\"", head)
        letter: Any = axis[1].lower() if axis else "y"
        return float(unit[1]) if unit else 1.0, letter
    return None, None


def _pieces(scene: Any, oddities: list[str]) -> Iterator[Piece]:
    """The triangles of a scene in its own frame, without those that are no triangles."""
    for node in sorted(scene.graph.nodes_geometry):
        transform, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not hasattr(geometry, "faces") or not len(geometry.faces):
            continue
        matrix = np.asarray(transform, np.float64)
        points = np.asarray(geometry.vertices, np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        faces = np.asarray(geometry.faces, np.int64)
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            faces = faces[:, ::-1]
        finite = np.isfinite(points) & (np.abs(points) < _FARTHEST)
        whole = np.asarray(finite.all(axis=1))[faces].all(axis=1)
        a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
        with np.errstate(all="ignore"):
            flat = ~(np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0)
        if not whole.all():
            oddities.append(f"{(~whole).sum()} triangles with coordinates that are not finite")
        faces = faces[whole & ~flat]
        if len(faces):
            uv, color, texture = _look(geometry)
            yield _compacted(Piece(points, faces, uv, color, texture))


def _compacted(piece: Piece) -> Piece:
    """The same with only the points that faces use, equal ones made one."""
    used = np.flatnonzero(np.bincount(piece.faces.reshape(-1), minlength=len(piece.points)))
    keys = piece.points[used].astype(np.float32).astype(np.float64)
    rows = keys if piece.uv is None else np.concatenate([keys, piece.uv[used]], axis=1)
    first, inverse = same_rows(rows)
    number = np.zeros(len(piece.points), np.int64)
    number[used] = inverse
    faces = number[piece.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    chosen = used[first]
    uv = None if piece.uv is None else piece.uv[chosen]
    return replace(piece, points=piece.points[chosen], faces=faces, uv=uv)


def _look(geometry: Any) -> tuple[Floats | None, Color | None, bytes | None]:
    """Texture points, colour and texture of a geometry."""
    visual = geometry.visual
    material = getattr(visual, "material", None)
    if visual.kind == "texture" and material is not None:
        factor = getattr(material, "baseColorFactor", None)
        picture = getattr(material, "baseColorTexture", None)
        if factor is None and picture is None:
            picture = getattr(material, "image", None)
            factor = getattr(material, "diffuse", None)
        uv = getattr(visual, "uv", None)
        color = _color(factor)
        if picture is not None and uv is not None and len(uv) == len(geometry.vertices):
            return np.asarray(uv, np.float64)[:, :2], color, _png(picture)
        if uv is not None and len(uv) == len(geometry.vertices):
            return np.asarray(uv, np.float64)[:, :2], color, None
        return None, color, None
    if visual.kind == "face":
        return None, _color(np.median(visual.face_colors, axis=0)), None
    if visual.kind == "vertex":
        return None, _color(np.median(visual.vertex_colors, axis=0)), None
    return None, None, None


def _color(values: Any) -> Color | None:
    if values is None:
        return None
    numbers = np.asarray(values, np.float64).reshape(-1)
    if np.asarray(values).dtype.kind in "ui" or numbers.max(initial=0.0) > 1.0:
        numbers = numbers / 255.0
    red, green, blue, *rest = (round(float(n), 4) for n in np.clip(numbers, 0.0, 1.0))
    return (red, green, blue, rest[0] if rest and rest[0] > 0.0 else 1.0)


def textured(mesh: MeshFile, picture: bytes | None) -> MeshFile:
    """The mesh with a texture where it has texture points and no texture of its own.

    Args:
        mesh: The mesh.
        picture: PNG bytes; None to drop texture points that no texture uses.
    """
    pieces = (
        piece
        if piece.texture is not None or piece.uv is None
        else replace(piece, texture=picture, uv=None if picture is None else piece.uv)
        for piece in mesh.pieces
    )
    return replace(mesh, pieces=tuple(pieces))


def load_picture(path: Path) -> bytes:
    """The PNG bytes of a picture.

    Raises:
        AssetError: It is none, or it is too large.
    """
    with extra_needed("import", "textures"):
        from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a picture that is too large is only warned of
            with Image.open(path) as picture:
                return _png(picture)
    except Exception as error:
        message = f"{path.name} cannot be read as a picture ({type(error).__name__})"
        raise AssetError(codes.NOT_READABLE, message) from error


def _png(picture: Any, most: int = 1024) -> bytes:
    """The bytes of a texture as a PNG of at most some pixels along a side."""
    picture = picture.convert("RGB")
    if max(picture.size) > most:
        picture.thumbnail((most, most))
    buffer = io.BytesIO()
    picture.save(buffer, "PNG")
    return buffer.getvalue()
