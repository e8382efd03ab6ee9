"""Shapes of objects. Boxes are given by full edge lengths, lengths in metres."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.geometry import Pose
from taskbuilder.schema.values import (
    Color,
    Edges,
    Length,
    Model,
    Position,
    Positive,
    RpyDeg,
    Text,
    exactly_one,
)

Collide = Literal["pieces", "hull", "boxes", "exact"]
"""How a mesh collides."""


class Cylinder(Model):
    """A cylinder or capsule along z; a capsule's length is that of its straight part."""

    radius: Length
    length: Length


class Shape(Model):
    """One shape, chosen by its key."""

    box: Edges | None = Field(None, description="Full edge lengths of a box.")
    sphere: Length | None = Field(None, description="Radius of a sphere.")
    cylinder: Cylinder | None = None
    capsule: Cylinder | None = None
    mesh: Text | None = Field(None, description="Path of an OBJ or binary STL file.")
    urdf: Text | None = Field(None, description="Path of a URDF file.")
    scale: Positive | None = Field(None, description="Factor of all lengths of a mesh or URDF.")
    collision: Text | None = Field(
        None,
        description="Path of the OBJ or binary STL file by which a `mesh` collides; by default the "
        "mesh itself.",
    )
    collide: Collide | None = Field(
        None,
        description="How a `mesh` [collides](#collisions-of-meshes); by default `exact` if the "
        "object is `fixed`, and otherwise `pieces`.",
    )

    @property
    def kind(self) -> str:
        """The key that chose the shape."""
        return next(name for name in SHAPES if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_kind(self) -> Shape:
        exactly_one("a shape", self, *SHAPES)
        if self.scale is not None and self.mesh is None and self.urdf is None:
            raise PydanticCustomError("choice", "scale goes with mesh or urdf only")
        for key in ("collision", "collide"):
            if getattr(self, key) is not None and self.mesh is None:
                with_urdf = "; a URDF has its own <collision>" if self.urdf is not None else ""
                raise PydanticCustomError("choice", f"{key} goes with mesh only{with_urdf}")
        return self


SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh", "urdf")


class PartSpec(Model):
    """One primitive of a compound body, placed in the body's frame."""

    box: Edges | None = Field(None, description="Full edge lengths of a box.")
    sphere: Length | None = Field(None, description="Radius of a sphere.")
    cylinder: Cylinder | None = None
    capsule: Cylinder | None = None
    at: Position = (0.0, 0.0, 0.0)
    rpy_deg: RpyDeg = (0.0, 0.0, 0.0)
    color: Color | None = Field(
        None, description="Colour of the part; by default the colour of the object."
    )

    @property
    def kind(self) -> str:
        """The key that chose the shape."""
        return next(name for name in PRIMITIVES if getattr(self, name) is not None)

    @property
    def pose(self) -> Pose:
        """The part's frame in the body's."""
        return Pose.from_rpy_deg(self.at, self.rpy_deg)

    @model_validator(mode="after")
    def _one_kind(self) -> PartSpec:
        exactly_one("a part", self, *PRIMITIVES)
        return self


PRIMITIVES = SHAPES[:4]
