"""How the members of a group stand: in a line, a grid, a ring or a pile.

An arrangement has a frame of its own. It lies in the x-y plane around the middle, except a pile,
which rises from there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, model_validator

from taskbuilder.geometry import Box, Pose, Vec3
from taskbuilder.schema.values import Edges, Length, Model, RpyDeg, exactly_one

MAX_COUNT = 200
LOOSE = 1.05
"""Edge of a pile's cells, in diameters of what is in them: room to lie a little askew."""

_TOUCHING = 1e-9  # metres; sums of decimals


@dataclass(frozen=True)
class Outline:
    """How much room a member takes.

    Attributes:
        box: Bounding box in its own frame.
        diameter: Diameter in metres of the sphere around its origin that holds it.
        upright_round: Whether it is as wide in every level direction.
    """

    box: Box
    diameter: float
    upright_round: bool = False


class Grid(Model):
    """Rows and columns."""

    columns: Annotated[int, Field(ge=1, le=MAX_COUNT)] = Field(
        description="Number of objects along x."
    )
    spacing: tuple[Length, Length] = Field(
        description="Distances between their centres along x and y."
    )


class Arrangement(Model):
    """How the objects stand, chosen by its key."""

    line: Length | None = Field(
        None,
        description="A line along x, with this distance between the centres of neighbouring "
        "objects.",
    )
    grid: Grid | None = Field(
        None, description="A grid: each row runs along x, and the rows lie side by side."
    )
    ring: Length | None = Field(
        None, description="A ring with this radius. The x axis of each object points outwards."
    )
    pile: Edges | None = Field(
        None,
        description="A heap. The objects are first stacked loosely in a box with these edges; they "
        "then fall and come to rest. The box must be large enough to give each object a cubic cell "
        "whose edge is 1.05 times the diameter of the object's bounding sphere.",
    )

    @property
    def kind(self) -> str:
        """The key that chose the arrangement."""
        return next(name for name in ARRANGEMENTS if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_kind(self) -> Arrangement:
        exactly_one("an arrangement", self, *ARRANGEMENTS)
        return self

    def places(
        self, count: int, rpy_deg: RpyDeg, outline: Outline | None
    ) -> tuple[tuple[Vec3, RpyDeg], ...]:
        """Position and orientation in degrees of each member in the arrangement's frame.

        Args:
            count: Number of members.
            rpy_deg: Roll and pitch of every member; the yaw is that of the arrangement.
            outline: The room that a member takes; needed for a pile.
        """
        roll, pitch, _ = rpy_deg
        if self.ring is None:
            return tuple((at, (roll, pitch, 0.0)) for at in self._positions(count, outline))
        angles = [360.0 * i / count for i in range(count)]
        return tuple((_round(self.ring, angle), (roll, pitch, angle)) for angle in angles)

    def _positions(self, count: int, outline: Outline | None) -> Iterator[Vec3]:
        if self.line is not None:
            yield from (((i - (count - 1) / 2) * self.line, 0.0, 0.0) for i in range(count))
        elif self.grid is not None:
            columns = min(self.grid.columns, count)
            rows = math.ceil(count / columns)
            x, y = self.grid.spacing
            for i in range(count):
                row, column = divmod(i, columns)
                yield (column - (columns - 1) / 2) * x, ((rows - 1) / 2 - row) * y, 0.0
        elif self.pile is not None and outline is not None:
            nx, ny, _ = _cells(self.pile, outline)
            for i in range(count):
                layer, cell = divmod(i, nx * ny)
                row, column = divmod(cell, nx)
                x = (column - (nx - 1) / 2) * self.pile[0] / nx
                y = (row - (ny - 1) / 2) * self.pile[1] / ny
                yield x, y, (layer + 0.5) * LOOSE * outline.diameter

    def slack(self, outline: Outline) -> tuple[float, float]:
        """How far a member of a pile may lie from the middle of its cell along x and y."""
        if self.pile is None:
            return 0.0, 0.0
        nx, ny, _ = _cells(self.pile, outline)
        x, y, _ = self.pile
        return (x / nx - outline.diameter) / 2, (y / ny - outline.diameter) / 2

    def problem(self, count: int, rpy_deg: RpyDeg, outline: Outline) -> str | None:
        """Why so many do not fit, and what would do.

        Args:
            count: Number of members.
            rpy_deg: Orientation of every member.
            outline: The room that a member takes.
        """
        turned = outline.box.seen_from(Pose.from_rpy_deg((0.0, 0.0, 0.0), (*rpy_deg[:2], 0.0)))
        is_round = outline.upright_round and not any(rpy_deg[:2])
        wide, deep, _ = (2.0 * half for half in turned.half)
        if self.line is not None and count > 1 and self.line < wide - _TOUCHING:
            return f"line: {self.line:g} is less than their width; at least {_up(wide)} is needed"
        if self.grid is not None:
            return _crowded_grid(self.grid, count, wide, deep)
        if self.ring is not None and (least := _ring(count, wide, deep, is_round)) > self.ring:
            return f"{count} need a ring with a radius of at least {_up(least)}"
        if self.pile is not None:
            return _overfull(self.pile, count, outline)
        return None


def _round(radius: float, angle_deg: float) -> Vec3:
    angle = math.radians(angle_deg)
    return (radius * math.cos(angle), radius * math.sin(angle), 0.0)


ARRANGEMENTS = tuple(Arrangement.model_fields)


def _cells(pile: Edges, outline: Outline) -> tuple[int, int, int]:
    """How many members fit into a pile's box along x, y and z, however they are turned."""
    cell = LOOSE * outline.diameter
    x, y, z = (math.floor(edge / cell + _TOUCHING) for edge in pile)
    return x, y, z


def _crowded_grid(grid: Grid, count: int, wide: float, deep: float) -> str | None:
    columns = min(grid.columns, count)
    x, y = grid.spacing
    narrow = (columns > 1 and x < wide - _TOUCHING) or (count > columns and y < deep - _TOUCHING)
    if not narrow:
        return None
    needed = f"[{_up(wide)}, {_up(deep)}]"
    return f"grid: spacing [{x:g}, {y:g}] is less than their width; at least {needed} is needed"


def _ring(count: int, wide: float, deep: float, is_round: bool) -> float:
    """The smallest radius of a ring in which neighbours do not overlap."""
    if count == 1:
        return 0.0
    # Neighbours meet with their inner edges first.
    apart = math.pi / count
    inner = wide / 2 + (deep / 2 / math.tan(apart) if count > 2 else 0.0)
    across = wide if is_round else math.hypot(wide, deep)
    return min(inner, across / (2.0 * math.sin(apart))) - _TOUCHING


def _overfull(pile: Edges, count: int, outline: Outline) -> str | None:
    x, y, z = _cells(pile, outline)
    if x * y * z >= count:
        return None
    larger = pile
    while math.prod(_cells(larger, outline)) < count:
        larger = (1.05 * larger[0], 1.05 * larger[1], 1.05 * larger[2])
    cell_cm = 100 * LOOSE * outline.diameter
    room = f"{count} do not fit into pile: {_sizes(pile)}, as each takes {cell_cm:.1f} cm"
    return f"{room}; {_sizes(larger)} would do"


def _sizes(edges: Edges) -> str:
    return f"[{', '.join(map(_up, edges))}]"


def _up(length: float) -> str:
    """A length in metres, rounded up to tenths of a millimetre."""
    return f"{math.ceil(length * 1e4 - 1e-6) / 1e4:g}"
