"""Where objects and sites of a scene are: at a position, or placed at random.

Lengths in metres, angles in degrees where the key says ``_deg``. Orientations are roll, pitch and
yaw about fixed x, y, z, as in URDF.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.geometry import Pose
from taskbuilder.schema.names import Refers
from taskbuilder.schema.values import (
    Coordinate,
    Degrees,
    Extent,
    FrameOrWorld,
    Length,
    Model,
    Position,
    Reference,
    RpyDeg,
    exactly_one,
)


class Place(Model):
    """A region to be placed in at random: on a surface (x, y) or in the air (x, y, z)."""

    surface: Annotated[Reference, Refers("surface")] | None = Field(
        None, description="Object, part or link on which the object or site is placed."
    )
    frame: FrameOrWorld = Field(
        "world",
        alias="in",
        description="Frame in which the region and the orientation are given.",
    )
    center: Annotated[tuple[Coordinate, ...], Field(min_length=2, max_length=3)]
    size: Annotated[tuple[Extent, ...], Field(min_length=2, max_length=3)]
    yaw_deg: tuple[Degrees, Degrees] = Field(
        (0.0, 0.0), description="Minimum and maximum of the random yaw."
    )
    rpy_deg: RpyDeg = Field((0.0, 0.0, 0.0), description="Orientation, before the yaw is added.")
    clearance: Length = Field(
        0.005,
        description="Minimum distance to all bodies except the objects that `surface` and `in` "
        "name; not allowed for sites.",
    )

    @model_validator(mode="after")
    def _fits(self) -> Place:
        wanted = 3 if self.surface is None else 2
        if len(self.center) != wanted or len(self.size) != wanted:
            kind = "on a surface: [x, y]" if wanted == 2 else "without a surface: [x, y, z]"
            raise PydanticCustomError("length", f"center and size {kind}")
        if self.yaw_deg[0] > self.yaw_deg[1]:
            raise PydanticCustomError("order", "yaw_deg is [least, greatest]; swap them")
        return self


class Placed(Model):
    """Something that stands at a position or is placed at random."""

    position: Position | None = None
    rpy_deg: RpyDeg = (0.0, 0.0, 0.0)
    frame: FrameOrWorld = Field(
        "world",
        alias="in",
        description="Frame in which `position` and `rpy_deg` are given: the world, or a frame such "
        "as tray, goal or left.tcp.",
    )
    place: Place | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Placed:
        exactly_one("it", self, "position", "place")
        if self.place is not None and (self.frame != "world" or any(self.rpy_deg)):
            raise PydanticCustomError("choice", "in and rpy_deg stand inside place, not beside it")
        return self

    @property
    def pose(self) -> Pose:
        """The pose in its frame; for a placed thing, the orientation before placement."""
        if self.place is not None:
            return Pose.from_rpy_deg((0.0, 0.0, 0.0), self.place.rpy_deg)
        return Pose.from_rpy_deg(self.position or (0.0, 0.0, 0.0), self.rpy_deg)
