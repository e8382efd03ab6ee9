"""Triangle meshes from OBJ and STL files: just enough to weigh and bound them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Vec3

STL_HEADER_BYTES = 80
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh.

    Attributes:
        corners: (triangles, 3, 3) corner positions in metres, in the mesh's frame.
    """

    corners: NDArray[np.float64]

    def scaled(self, scale: Vec3) -> Mesh:
        """The mesh stretched along its axes."""
        return Mesh(self.corners * np.asarray(scale))


def read_mesh(path: Path) -> Mesh:
    """Read an OBJ or binary STL file.

    Raises:
        SimulationError: The file is of another kind, cannot be read, or holds no triangle.
    """
    readers = {".obj": _read_obj, ".stl": _read_stl}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise SimulationError(f"{path.name}: meshes are .obj or .stl files")
    try:
        corners = reader(path)
    except (OSError, ValueError, IndexError) as error:
        raise SimulationError(f"{path.name}: not a mesh that can be read: {error}") from error
    if not len(corners):
        raise SimulationError(f"{path.name}: the mesh has no triangles")
    if not np.isfinite(corners).all():
        raise SimulationError(f"{path.name}: the mesh has corners that are not finite numbers")
    return Mesh(corners)


def _read_obj(path: Path) -> NDArray[np.float64]:
    vertices: list[tuple[float, ...]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        keyword, *fields = line.split() or [""]
        if keyword == "v":
            vertices.append(tuple(map(float, fields[:3])))
        elif keyword == "f":
            corners = [_obj_index(field, len(vertices)) for field in fields]
            triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    positions = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    return positions[np.array(triangles, dtype=np.intp).reshape(-1, 3)]


def _obj_index(field: str, vertices: int) -> int:
    """A face's corner, counted from 1 or backwards from the vertices so far, as an index."""
    number = int(field.partition("/")[0])
    index = number - 1 if number > 0 else vertices + number
    if not 0 <= index < vertices:
        raise ValueError(f"a face names vertex {number}; there are {vertices}")
    return index


def _read_stl(path: Path) -> NDArray[np.float64]:
    content = path.read_bytes()[STL_HEADER_BYTES:]
    count = int.from_bytes(content[:4], "little")
    if len(content) != 4 + count * STL_TRIANGLE.itemsize:
        raise ValueError("its length does not match; only binary STL is read, not ASCII")
    return np.frombuffer(content[4:], STL_TRIANGLE)["corners"].astype(np.float64)
