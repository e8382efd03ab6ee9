"""Reading meshes, all of each, so that the physics engine is known to read them right.

Bullet ends the process on an OBJ whose face refers to a vertex that does not exist, and loads
an ASCII or empty STL as a body that nothing collides with. So every number is read here, which
takes about a second for the largest mesh allowed and a few milliseconds for a usual one. A file
is read once in a process for as long as it does not change.
"""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from taskbuilder.assets import codes
from taskbuilder.assets.obj import Obj, ObjError
from taskbuilder.assets.paths import AssetError, require_readable, resolve
from taskbuilder.geometry import Box, Vec3

MAX_TRIANGLES = 500_000
MAX_COORDINATE = 1e6
PLAUSIBLE_M = 1e3

# Bullet reads an OBJ into buffers of 8192 and names into buffers of 4096 characters.
_MAX_LINE = 4_000
_THINNEST_M = 1e-9
_UNIT_SCALE: Vec3 = (1.0, 1.0, 1.0)

_STL_HEADER_BYTES = 84
_STL_TRIANGLE_BYTES = 50  # a normal, three corners, an attribute
_STL_CORNERS = slice(12, 48)


@dataclass(frozen=True, slots=True)
class Mesh:
    """A mesh file that was read whole.

    Attributes:
        path: Absolute path of the file.
        points: x, y and z of one vertex after the other, in the units of the file.
        corners: Numbers of the three vertices of one triangle after the other, polygons split
            into fans; in an STL each triangle has vertices of its own.
        bounds: Smallest box around the vertices.
        texture_points: u and v of one texture point after the other; number 0 is (0, 0), for
            corners without one. Empty for an STL.
        texture_corners: Numbers of the texture points of the same corners. Empty for an STL.
        material_files: The material files that it names.
        materials: Names of the materials of faces; the first, "", is that of faces without one.
            Empty for an STL.
        face_materials: Number of each triangle's material among these. Empty for an STL.
        groups: Number of the first triangle of each group of faces; (0,) for an STL.
        warnings: What is odd about the file without forbidding its use.
    """

    path: Path
    points: array[float] = field(repr=False)
    corners: array[int] = field(repr=False)
    bounds: Box
    texture_points: array[float] = field(default_factory=lambda: array("d"), repr=False)
    texture_corners: array[int] = field(default_factory=lambda: array("I"), repr=False)
    material_files: tuple[str, ...] = ()
    materials: tuple[str, ...] = ()
    face_materials: array[int] = field(default_factory=lambda: array("I"), repr=False)
    groups: tuple[int, ...] = (0,)
    warnings: tuple[str, ...] = ()

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return len(self.corners) // 3


def read_mesh(path: Path) -> Mesh:
    """Reads an OBJ or binary STL file and checks all of it.

    Raises:
        AssetError: The file cannot be read, has another format, or would be misread by the
            physics engine.
    """
    require_readable(path, path.name)
    require_supported(path)
    absolute = path.resolve()
    status = absolute.stat()
    mesh = _read(absolute, status.st_mtime_ns, status.st_size)
    warnings = [w for name in mesh.material_files for w in _material_warnings(absolute, name)]
    return replace(mesh, warnings=tuple(warnings)) if warnings else mesh


@lru_cache(maxsize=128)
def _read(path: Path, _modified_ns: int, _size: int) -> Mesh:
    """Read a file once for as long as it does not change."""
    data = path.read_bytes()
    mesh = _read_stl(path, data) if _suffix(path) == ".stl" else _read_obj(path, data)
    if sum(half < _THINNEST_M for half in mesh.bounds.half) >= 2:
        raise _bad(path, "all its vertices lie on one line; a mesh needs an extent in two axes")
    return mesh


def require_supported(path: Path) -> None:
    """Checks by its name that a mesh has a format that can be read.

    Raises:
        AssetError: It has another.
    """
    if _suffix(path) not in (".obj", ".stl"):
        raise AssetError(
            codes.MESH_FORMAT,
            f"{path.name}: meshes of type {_suffix(path) or '(none)'} are not read; "
            "convert it to .obj or binary .stl",
        )


def size_warning(mesh: Mesh, scale: Vec3 = _UNIT_SCALE) -> str:
    """What is implausible about the size of a mesh loaded at some scale, or ""."""
    corners = (mesh.bounds.low, mesh.bounds.high)
    reach = max(abs(corner[axis] * scale[axis]) for corner in corners for axis in range(3))
    if reach <= PLAUSIBLE_M:
        return ""
    return (
        f"{mesh.path.name}: reaches {reach:,.0f} m from its origin; "
        "a mesh in millimetres needs scale 0.001 0.001 0.001"
    )


def _suffix(path: Path) -> str:
    return path.suffix.lower()


def _bad(path: Path, message: str, line: int = 0) -> AssetError:
    where = f"{path.name}:{line}" if line else path.name
    return AssetError(codes.BAD_MESH, f"{where}: {message}")


def _read_stl(path: Path, data: bytes) -> Mesh:
    count = _stl_triangle_count(path, data)
    starts = range(_STL_HEADER_BYTES, len(data), _STL_TRIANGLE_BYTES)
    records = (data[start : start + _STL_TRIANGLE_BYTES] for start in starts)
    points = array("f", b"".join(record[_STL_CORNERS] for record in records))
    return Mesh(path, points, array("I", range(3 * count)), _bounds(path, points))


def _stl_triangle_count(path: Path, data: bytes) -> int:
    """The number of triangles, where the length of the file agrees with it.

    Raises:
        AssetError: The file is an ASCII STL, or its length or number of triangles is wrong.
    """
    count = 0
    if len(data) >= _STL_HEADER_BYTES:
        count = int.from_bytes(data[_STL_HEADER_BYTES - 4 : _STL_HEADER_BYTES], "little")
    expected = _STL_HEADER_BYTES + count * _STL_TRIANGLE_BYTES
    # Some binary files begin with "solid" too; only the length tells them apart.
    if len(data) != expected and data.lstrip()[:5].lower() == b"solid":
        raise AssetError(
            codes.MESH_FORMAT,
            f"{path.name}: is an ASCII STL, which the physics engine loads as nothing; "
            "save it as binary STL or OBJ",
        )
    if len(data) != expected:
        raise _bad(
            path,
            f"has {len(data)} bytes where its {count} triangles need {expected}; export it again",
        )
    _require_count(path, count)
    return count


def _read_obj(path: Path, data: bytes) -> Mesh:
    _require_text(path, data)
    obj = Obj()
    try:
        obj.read(data)
    except ObjError as error:
        raise _bad(path, str(error), error.line) from None
    _require_count(path, len(obj.corners) // 3)
    return Mesh(
        path,
        obj.points,
        obj.corners,
        _bounds(path, obj.points),
        texture_points=obj.texture_points,
        texture_corners=obj.texture_corners,
        material_files=tuple(obj.material_files),
        materials=tuple(obj.materials),
        face_materials=obj.face_materials,
        groups=tuple(obj.groups),
    )


def _require_text(path: Path, data: bytes) -> None:
    """Checks that the engine would split a text file into the same lines and words.

    Raises:
        AssetError: It is not UTF-8, has control characters, or a line is too long.
    """
    try:
        data.decode()
    except UnicodeDecodeError as error:
        raise _bad(path, "is not UTF-8 text; export it again as a text file") from error
    if any(control in data for control in (b"\0", b"\v", b"\f")):
        raise _bad(path, "has control characters; export it again as a text file")
    for number, line in enumerate(data.split(b"\n"), start=1):
        if len(line) > _MAX_LINE:
            raise _bad(path, f"is longer than {_MAX_LINE} characters; break it up", number)


def _material_warnings(mesh: Path, name: str) -> list[str]:
    """What is odd about the textures of the material file that an OBJ names.

    A file that is missing is no harm: the mesh is then drawn in its link's colour.

    Raises:
        AssetError: The material file lies outside the folder of the mesh, or is no text.
    """
    path = _beside(mesh, name)
    if path is None:
        return []
    data = path.read_bytes()
    _require_text(path, data)
    warnings = []
    for line in data.decode().splitlines():
        words = line.split()
        if words and words[0].startswith("map_") and len(words) > 1:
            try:
                _beside(path, words[-1])
            except AssetError as error:
                # Public meshes often name an image on their author's machine.
                warnings.append(f"{path.name}: {error}")
    return warnings


def _beside(file: Path, name: str) -> Path | None:
    """The file that another one refers to, from its own folder down; None if there is none."""
    try:
        return resolve(name, file.parent, [file.parent])
    except AssetError as error:
        if error.code == codes.MISSING:
            return None
        raise


def _require_count(path: Path, triangles: int) -> None:
    if triangles == 0:
        raise _bad(path, "has no faces; export it with its surface")
    if triangles > MAX_TRIANGLES:
        raise _bad(path, f"has {triangles} triangles; simplify it to at most {MAX_TRIANGLES}")


def _bounds(path: Path, points: array[float]) -> Box:
    """The box around coordinates that are finite and bounded, at the speed of ``sum`` and ``max``.

    Raises:
        AssetError: One is not.
    """
    low, high = [0.0] * 3, [0.0] * 3
    for axis in range(3):
        values = points[axis::3]
        low[axis], high[axis] = min(values), max(values)
        # A sum is finite only if every term is; min and max alone would overlook a nan.
        if not math.isfinite(sum(values)) or max(high[axis], -low[axis]) > MAX_COORDINATE:
            raise _bad(path, f"has a coordinate that is not finite or beyond {MAX_COORDINATE:g}")
    return Box.around((low[0], low[1], low[2]), (high[0], high[1], high[2]))
