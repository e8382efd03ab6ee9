"""Reading OBJ files, by blocks of lines of one kind.

A block whose lines all have the same form is read as a whole, which takes a tenth of the time.
Any other is read line by line, and so is one with a mistake, to name its line.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import NamedTuple

_CORNER = re.compile(rb"-?\d{1,9}(?:/-?\d{1,9}|/(?:-?\d{1,9})?/-?\d{1,9})?")

_BLOCK = re.compile(rb"(\S+)[^\n]*(?:\n[^\S\n]*\1(?!\S)[^\n]*)*")
"""A line and the following that begin with the same word."""

_FORMS = {
    form: re.compile(rb"(?:" + form.replace(b"1", rb"\d{1,9}") + rb" )+")
    for form in (b"1", b"1/1", b"1//1", b"1/1/1")
}
"""The form of a corner -> that of many, each before a space."""


class ObjError(ValueError):
    """A line that the physics engine would misread.

    Attributes:
        line: Its number, from 1.
    """

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


class Block(NamedTuple):
    """Consecutive lines that begin with the same word.

    Attributes:
        kind: The word.
        first: Number of the first line, from 1.
        text: The lines.
    """

    kind: bytes
    first: int
    text: bytes

    def lines(self) -> list[list[bytes]]:
        """The words of each line but the first."""
        return [line.split()[1:] for line in self.text.split(b"\n")]

    def columns(self) -> list[list[bytes]]:
        """The first words after the kind, the second, and so on; [] if lines differ in length.

        A word that is the kind, too, is taken for the beginning of a line. It is for the caller to
        refuse it: it is no number.
        """
        words, count = self.text.split(), self.text.count(b"\n") + 1
        step, rest = divmod(len(words), count)
        if rest or words[::step].count(self.kind) != count:
            return []
        return [words[column::step] for column in range(1, step)]


class Obj:
    """An OBJ file as far as it is read.

    Attributes:
        points: x, y and z of one vertex after the other.
        corners: Numbers of the three vertices of one triangle after the other, from 0.
        texture_points: u and v of one texture point after the other; number 0 is (0, 0), for
            corners without one.
        texture_corners: Numbers of the texture points of the same corners.
        material_files: The material files that it names.
        materials: Names of the materials of faces; the first, "", is that of faces without one.
        face_materials: Number of each triangle's material among these.
        groups: Number of the first triangle of each group of faces: what stands below a line ``o``
            or ``g``. The physics engine makes a convex hull of each.
    """

    def __init__(self) -> None:
        self._normals = 0
        self._material = 0
        self.points = array("d")
        self.corners = array("I")
        self.texture_points = array("d", (0.0, 0.0))
        self.texture_corners = array("I")
        self.material_files: list[str] = []
        self.materials = [""]
        self.face_materials = array("I")
        self.groups: list[int] = []
        self._in_group = False

    def read(self, data: bytes) -> None:
        """Read all lines; unknown kinds are ignored, as the physics engine does.

        Raises:
            ObjError: A line would be misread.
        """
        for block in _blocks(data):
            match block.kind:
                case b"v":
                    self.points.extend(_numbers(block, at_least=3, kept=3))
                case b"vt":
                    self.texture_points.extend(_numbers(block, at_least=2, kept=2))
                case b"vn":
                    self._normals += len(_numbers(block, at_least=3, kept=3)) // 3
                case b"o" | b"g":
                    self._in_group = False
                case b"f":
                    if not self._in_group:
                        self.groups.append(len(self.face_materials))
                        self._in_group = True
                    self._faces(block)
                    added = len(self.corners) // 3 - len(self.face_materials)
                    self.face_materials.extend([self._material] * added)
                case b"usemtl":
                    self._use(b" ".join(block.lines()[-1]).decode())
                case b"mtllib":
                    self.material_files += [w.decode() for words in block.lines() for w in words]

    def _use(self, material: str) -> None:
        """Take a material for the faces that follow."""
        if material not in self.materials:
            self.materials.append(material)
        self._material = self.materials.index(material)

    def _faces(self, block: Block) -> None:
        # Only what came before counts: the engine may build the shape at the next group.
        known = (len(self.points) // 3, len(self.texture_points) // 2 - 1, self._normals)
        if not self._alike(block.columns(), known):
            for number, words in enumerate(block.lines(), start=block.first):
                self._face(words, known, number)

    def _alike(self, columns: list[list[bytes]], known: tuple[int, int, int]) -> bool:
        """Read faces that are alike: equally many corners of one form, of positive numbers."""
        size = len(columns)
        if size < 3:
            return False
        form = re.sub(rb"\d+", b"1", columns[0][0])
        joined = b" ".join([word for face in zip(*columns, strict=True) for word in face]) + b" "
        if form not in _FORMS or not _FORMS[form].fullmatch(joined):
            return False
        numbers = [int(number) for number in joined.replace(b"/", b" ").split()]
        parts = {b"1": (0,), b"1/1": (0, 1), b"1//1": (0, 2), b"1/1/1": (0, 1, 2)}[form]
        of_part = {part: numbers[i :: len(parts)] for i, part in enumerate(parts)}
        if any(min(column) < 1 or max(column) > known[n] for n, column in of_part.items()):
            return False
        self.corners.extend(_fans([number - 1 for number in of_part[0]], size))
        self.texture_corners.extend(_fans(of_part.get(1, [0] * len(of_part[0])), size))
        return True

    def _face(self, words: list[bytes], known: tuple[int, int, int], line: int) -> None:
        if len(words) < 3:
            raise ObjError(line, f"a face of {len(words)} corners; it needs three or more")
        corners = [_corner(word, known, line) for word in words]
        self.corners.extend(_fans([vertex - 1 for vertex, _ in corners], len(corners)))
        self.texture_corners.extend(_fans([texture for _, texture in corners], len(corners)))


def _blocks(data: bytes) -> Iterator[Block]:
    """Consecutive lines of one kind; empty lines end a block."""
    line, counted = 1, 0
    for found in _BLOCK.finditer(data):
        line += data.count(b"\n", counted, found.start())
        counted = found.start()
        yield Block(found[1], line, found[0])


def _numbers(block: Block, at_least: int, kept: int) -> list[float]:
    """The first numbers of each line."""
    columns = block.columns()
    if len(columns) >= at_least and b"_" not in block.text:
        with suppress(ValueError):
            numbers = [list(map(float, column)) for column in columns]
            return [number for row in zip(*numbers[:kept], strict=True) for number in row]
    lines = enumerate(block.lines(), start=block.first)
    return [n for line, words in lines for n in _floats(words, at_least, line)[:kept]]


def _floats(words: list[bytes], at_least: int, line: int) -> list[float]:
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    # Python reads 1_0 as ten, the physics engine as one.
    if len(numbers) < at_least or any(b"_" in word for word in words):
        raise ObjError(
            line, f"{_shown(words)} should be {at_least} or more numbers; decimals take a point"
        )
    return numbers


def _corner(word: bytes, known: tuple[int, int, int], line: int) -> tuple[int, int]:
    """Numbers of the vertex and of the texture point of a corner, from 1; 0 for none."""
    if not _CORNER.fullmatch(word):
        raise ObjError(line, f"{_shown([word])} is no corner of a face; write 1, 1/1 or 1/1/1")
    numbers = [0, 0, 0]
    for part, index in enumerate(word.split(b"/")):
        number, count = int(index or 0), known[part]
        if index and not 1 <= abs(number) <= count:
            raise ObjError(
                line,
                f"a face refers to item {number} of {count}; "
                "indices run from 1, or from -1 backwards, over the lines above",
            )
        numbers[part] = number if number >= 0 else count + 1 + number
    return numbers[0], numbers[1]


def _fans(corners: list[int], size: int) -> list[int]:
    """Polygons of equal size split into triangles around their first corners."""
    if size == 3:
        return corners
    faces = [corners[start : start + size] for start in range(0, len(corners), size)]
    return [n for first, *rest in faces for pair in pairwise(rest) for n in (first, *pair)]


def _shown(words: Sequence[bytes]) -> str:
    text = b" ".join(words).decode(errors="replace")
    return repr(text if len(text) <= 40 else text[:37] + "…")
