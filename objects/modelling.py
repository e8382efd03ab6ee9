"""What the objects of the shelf are made of: surfaces to look at, and convex pieces to touch.

A surface is painted face by face: each face has one cell of a small picture, so that it looks the
same in renderers that interpolate textures and in those that give a face one colour.
"""

from __future__ import annotations

import itertools
import math
import struct
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Vec3 = tuple[float, float, float]
Point = Sequence[float]
Ring = list[Vec3]
Cell = tuple[int, int]
Floats = NDArray[np.float64]

CELL_PIXELS = 4
"""Edge of a cell in pixels, so that renderers that interpolate do not see its neighbours."""

MARGIN_M = 0.001
"""How far the engine's convex shapes reach beyond their points; pieces are drawn in by it."""


class Picture:
    """The texture of an object: a grid of cells of one colour each."""

    WIDTH = 16

    def __init__(self) -> None:
        self._drawn: list[list[str]] = []
        self._swatches: dict[str, Cell] = {}

    def swatch(self, color: str) -> Cell:
        """The cell of a colour, ``rrggbb``; rows of swatches follow the drawings."""
        number = len(self._swatches)
        cell = (number % self.WIDTH, -1 - number // self.WIDTH)
        return self._swatches.setdefault(color, cell)

    def drawing(self, rows: Sequence[str], colors: dict[str, str]) -> list[list[Cell]]:
        """A drawing, a letter for a cell; the cells row by row from the top."""
        first = len(self._drawn)
        self._drawn += [[colors[letter] for letter in row] for row in rows]
        return [[(j, first + i) for j in range(len(row))] for i, row in enumerate(rows)]

    @property
    def rows(self) -> list[list[str]]:
        """The colours, row by row."""
        colors = list(self._swatches)
        starts = range(0, len(colors), self.WIDTH)
        return [*self._drawn, *(colors[start : start + self.WIDTH] for start in starts)]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of cells."""
        return max(map(len, self.rows)), len(self.rows)

    def corners(self, cell: Cell) -> list[tuple[float, float]]:
        """U and v of the four corners of a cell, drawn in a little."""
        columns, rows = self.size
        column, row = cell
        row = row if row >= 0 else len(self._drawn) - 1 - row
        ends = [(0.2, 0.8), (0.8, 0.8), (0.8, 0.2), (0.2, 0.2)]
        return [((column + x) / columns, 1.0 - (row + y) / rows) for x, y in ends]

    def png(self) -> bytes:
        """The picture as a PNG file, with a palette and without compression."""
        columns, rows = self.size
        palette = sorted({color for row in self.rows for color in row})
        lines = bytearray()
        for row in self.rows:
            full = row + [row[-1]] * (columns - len(row))
            line = b"".join(bytes([palette.index(color)]) * CELL_PIXELS for color in full)
            lines += (b"\0" + line) * CELL_PIXELS
        header = struct.pack(">IIBBBBB", columns * CELL_PIXELS, rows * CELL_PIXELS, 8, 3, 0, 0, 0)
        chunks = [
            (b"IHDR", header),
            (b"PLTE", b"".join(bytes.fromhex(color) for color in palette)),
            (b"IDAT", zlib.compress(bytes(lines), 0)),
            (b"IEND", b""),
        ]
        return b"\x89PNG\r\n\x1a\n" + b"".join(map(_chunk, chunks))


def _chunk(chunk: tuple[bytes, bytes]) -> bytes:
    kind, data = chunk
    checksum = struct.pack(">I", zlib.crc32(kind + data))
    return struct.pack(">I", len(data)) + kind + data + checksum


Paint = Cell | Callable[[int, int], Cell]
"""A cell, or the cell of the face in a column and row of a surface."""


@dataclass
class Surface:
    """Faces to look at."""

    faces: list[tuple[list[Vec3], Cell]] = field(default_factory=list)

    def face(self, points: Sequence[Point], paint: Cell) -> None:
        """Add a polygon, counter-clockwise as seen from outside."""
        corners: list[Vec3] = []
        for x, y, z in points:
            corner = (round(x, 5) + 0.0, round(y, 5) + 0.0, round(z, 5) + 0.0)
            if corner not in corners:
                corners.append(corner)
        if len(corners) >= 3:
            self.faces.append((corners, paint))

    def loft(
        self, rings: Sequence[Ring], paint: Paint, *, caps: Cell | None = None, closed: bool = True
    ) -> None:
        """Skin rings of equally many points; each runs counter-clockwise seen from the last."""
        for i in range(len(rings) - 1):
            low, high = rings[i], rings[i + 1]
            count = len(low)
            for j in range(count if closed else count - 1):
                k = (j + 1) % count
                cell = paint(j, i) if callable(paint) else paint
                self.face((low[j], low[k], high[k], high[j]), cell)
        if caps is not None:
            self.face(rings[0][::-1], caps)
            self.face(rings[-1], caps)

    def lathe(self, profile: Sequence[tuple[float, float]], paint: Paint, count: int = 40) -> None:
        """Turn a profile of radii and heights about z; outside goes up, and inside down."""
        self.loft([circle(r, z, count) for r, z in profile], paint)

    def box(self, size: Point, at: Point, paint: Cell, *, top: Cell | None = None) -> None:
        """Add a box, with its top in another colour if one is given."""
        x, y, z = (edge / 2 for edge in size)
        low = [moved(p, at) for p in ((-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z))]
        high = [moved(p, at) for p in ((-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z))]
        self.loft([low, high], paint)
        self.face(low[::-1], paint)
        self.face(high, top if top is not None else paint)

    def sheet(
        self, corner: Point, along: Point, up: Point, cells: Sequence[Sequence[Cell]]
    ) -> None:
        """A drawing on a rectangle: from its lower left corner, along and up its edges."""
        a, u, v = np.array(corner), np.array(along), np.array(up)
        rows, columns = len(cells), len(cells[0])
        for i in range(rows):
            for j in range(columns):
                low, high = 1.0 - (i + 1) / rows, 1.0 - i / rows
                left, right = j / columns, (j + 1) / columns
                ends = ((left, low), (right, low), (right, high), (left, high))
                self.face([(a + s * u + t * v).tolist() for s, t in ends], cells[i][j])

    def tube(
        self, path: Sequence[Point], section: tuple[float, float], paint: Paint, *, count: int = 10
    ) -> None:
        """A round bar along a path in a plane of constant y; section: half in y, half in plane."""
        rings = sweep(path, section, count)
        cap = paint(0, 0) if callable(paint) else paint
        self.loft(rings, paint, caps=cap)

    def changed(self, change: Callable[[Vec3], Point]) -> None:
        """Move every corner."""
        self.faces = [
            ([_vec(change(corner)) for corner in corners], paint) for corners, paint in self.faces
        ]

    @property
    def triangles(self) -> int:
        """Number of triangles, polygons split into fans."""
        return sum(len(corners) - 2 for corners, _ in self.faces)

    def obj(self, name: str, picture: str, textures: Picture) -> str:
        """The surface as an OBJ file."""
        points = _numbers(corner for corners, _ in self.faces for corner in corners)
        cells = list(dict.fromkeys(paint for _, paint in self.faces))
        lines = [f"mtllib {picture}.mtl", f"o {name}"]
        lines += [f"v {shown(point)}" for point in points]
        lines += [f"vt {u:.4f} {v:.4f}" for cell in cells for u, v in textures.corners(cell)]
        lines.append("usemtl look")
        first = {cell: 4 * number for number, cell in enumerate(cells)}
        for corners, paint in self.faces:
            words = [
                f"{points[corner]}/{first[paint] + 1 + number % 4}"
                for number, corner in enumerate(corners)
            ]
            lines.append(f"f {' '.join(words)}")
        return "\n".join([*lines, ""])


@dataclass
class Pieces:
    """Convex pieces to touch, each a ring of points and another one above it."""

    pieces: list[tuple[Ring, Ring]] = field(default_factory=list)

    def loft(self, low: Ring, high: Ring) -> None:
        """A piece between two convex rings, counter-clockwise as seen from the second."""
        self.pieces.append((low, high))

    def box(self, size: Point, at: Point, turn: Callable[[Vec3], Point] | None = None) -> None:
        """A box, drawn in by the margin."""
        x, y, z = (max(edge / 2 - MARGIN_M, 0.0002) for edge in size)
        rings = []
        for height in (-z, z):
            corners = ((-x, -y, height), (x, -y, height), (x, y, height), (-x, y, height))
            ring = [moved(corner, at) for corner in corners]
            rings.append([_vec(turn(corner)) for corner in ring] if turn else ring)
        self.loft(rings[0], rings[1])

    def round(self, profile: Sequence[tuple[float, float]], count: int = 12) -> None:
        """Solids of revolution: one for each pair of radii and heights that follow each other."""
        for (r0, z0), (r1, z1) in itertools.pairwise(profile):
            up = MARGIN_M
            self.loft(
                circle(max(r0 - MARGIN_M, 0.0005), z0 + up, count),
                circle(max(r1 - MARGIN_M, 0.0005), z1 - up, count),
            )

    def wall(
        self,
        outer: tuple[float, float],
        inner: tuple[float, float],
        heights: tuple[float, float],
        count: int = 16,
    ) -> None:
        """A ring of walls: outer and inner radius below and above, between two heights."""
        z0, z1 = heights[0] + MARGIN_M, heights[1] - MARGIN_M
        for number in range(count):
            a, b = (2 * math.pi * (number + end) / count for end in (0.0, 1.0))
            rings = []
            for r_out, r_in, z in ((outer[0], inner[0], z0), (outer[1], inner[1], z1)):
                far = (r_out - MARGIN_M) / math.cos(math.pi / count) ** 0.5
                near = (r_in + MARGIN_M) / math.cos(math.pi / count)
                ring = [(near, a), (far, a), (far, b), (near, b)]
                rings.append([(r * math.cos(t), r * math.sin(t), z) for r, t in ring])
            self.loft(rings[0], rings[1])

    def bar(self, path: Sequence[Point], section: tuple[float, float]) -> None:
        """A bar along a path in a plane of constant y, a piece for each step."""
        y, across = section[0] - MARGIN_M, section[1] - MARGIN_M
        for a, b in itertools.pairwise(path):
            along = np.array(b, float) - np.array(a, float)
            along /= np.linalg.norm(along)
            side = np.array([-along[2], 0.0, along[0]])
            rings = []
            for end in (a, b):
                middle = np.array(end, float)
                corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
                rings.append(
                    [
                        _vec(middle + np.array([0.0, s * y, 0.0]) + t * across * side)
                        for s, t in corners
                    ]
                )
            self.loft(rings[0], rings[1])

    def triangles(self) -> list[list[tuple[Vec3, Vec3, Vec3]]]:
        """The outside of every piece, counter-clockwise."""
        return [_outside(low, high) for low, high in self.pieces]

    def obj(self) -> str:
        """The pieces as an OBJ file, a group each."""
        lines, count = [], 0
        for number, triangles in enumerate(self.triangles(), start=1):
            points = _numbers(corner for triangle in triangles for corner in triangle)
            lines.append(f"o piece_{number}")
            lines += [f"v {shown(point)}" for point in points]
            lines += [
                "f " + " ".join(str(count + points[corner]) for corner in triangle)
                for triangle in triangles
            ]
            count += len(points)
        return "\n".join([*lines, ""])


def _outside(low: Ring, high: Ring) -> list[tuple[Vec3, Vec3, Vec3]]:
    low, high = ([_vec(np.round(point, 5)) for point in ring] for ring in (low, high))
    count = len(low)
    faces: list[tuple[Vec3, Vec3, Vec3]] = []
    for j in range(count):
        k = (j + 1) % count
        faces += [(low[j], low[k], high[k]), (low[j], high[k], high[j])]
        if 0 < j < count - 1:
            faces += [(low[0], low[k], low[j]), (high[0], high[j], high[k])]
    volume = sum(float(np.linalg.det(np.array(face))) for face in faces)
    return [face[::-1] for face in faces] if volume < 0 else faces


@dataclass(frozen=True)
class Weight:
    """Mass, centre and inertia of pieces of uniform density."""

    mass: float
    center: Floats
    tensor: Floats


def weight(pieces: Pieces, mass: float) -> Weight:
    """How pieces of a mass weigh; see Blow and Binstock (2004) for the integrals."""
    corners = np.array([face for faces in pieces.triangles() for face in faces])
    dets = np.linalg.det(corners)
    sums = corners.sum(axis=1)
    volume = dets.sum() / 6
    center = (dets[:, None] * sums).sum(axis=0) / 24 / volume
    second = np.einsum("t,tki,tkj->ij", dets, corners, corners)
    second += np.einsum("t,ti,tj->ij", dets, sums, sums)
    covariance = second / 120 / volume - np.outer(center, center)
    tensor = mass * (np.trace(covariance) * np.eye(3) - covariance)
    # What symmetry makes zero is left over by rounding, which differs between processors.
    return Weight(mass, center, np.where(np.abs(tensor) < 1e-9 * np.trace(tensor), 0.0, tensor))


def circle(radius: float, z: float, count: int = 40) -> Ring:
    """A ring about z, counter-clockwise from above."""
    turns = [2 * math.pi * number / count for number in range(count)]
    return [(radius * math.cos(turn), radius * math.sin(turn), z) for turn in turns]


def rounded(x: float, y: float, z: float, radius: float, at: Point = (0, 0), n: int = 4) -> Ring:
    """A rectangle of half edges x and y with round corners, counter-clockwise from above."""
    ring: Ring = []
    for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        for step in range(n + 1):
            turn = math.pi / 2 * (quarter + step / n)
            ring.append(
                (
                    at[0] + sx * (x - radius) + radius * math.cos(turn),
                    at[1] + sy * (y - radius) + radius * math.sin(turn),
                    z,
                )
            )
    return ring


def sweep(path: Sequence[Point], section: tuple[float, float], count: int) -> list[Ring]:
    """Rings around the points of a path in a plane of constant y."""
    points = [np.array(point, float) for point in path]
    rings = []
    for i, point in enumerate(points):
        along = points[min(i + 1, len(points) - 1)] - points[max(i - 1, 0)]
        along /= np.linalg.norm(along)
        side = np.array([-along[2], 0.0, along[0]])
        turns = [2 * math.pi * number / count for number in range(count)]
        rings.append(
            [
                _vec(
                    point
                    + np.array([0.0, section[0] * math.cos(turn), 0.0])
                    + section[1] * math.sin(turn) * side
                )
                for turn in turns
            ]
        )
    return rings


def arc(
    center: tuple[float, float], radius: tuple[float, float], ends_deg: tuple[float, float], n: int
) -> list[Vec3]:
    """Points of an arc in the plane y = 0, from angle to angle; 0 is +x and 90 is up."""
    turns = np.radians(np.linspace(*ends_deg, n))
    return [
        (center[0] + radius[0] * math.cos(t), 0.0, center[1] + radius[1] * math.sin(t))
        for t in turns.tolist()
    ]


def moved(point: Point, by: Point) -> Vec3:
    """A point moved."""
    return (point[0] + by[0], point[1] + by[1], point[2] + by[2])


def _vec(values: Iterable[float]) -> Vec3:
    x, y, z = map(float, values)
    return (x, y, z)


def _numbers(points: Iterable[Vec3]) -> dict[Vec3, int]:
    found: dict[Vec3, int] = {}
    for point in points:
        found.setdefault(point, len(found) + 1)
    return found


def shown(values: Iterable[float]) -> str:
    """Numbers as files have them: to a hundredth of a millimetre."""
    return " ".join(f"{round(float(value), 5) + 0.0:.5g}" for value in values)
