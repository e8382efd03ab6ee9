"""The sites of a scene: named frames without a body."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.placing import Place, Placed
from taskbuilder.schema.shapes import Cylinder
from taskbuilder.schema.values import (
    Color,
    Edges,
    Length,
    Model,
    exactly_one,
)


class Marker(Model):
    """How a site looks; its volume is what `Inside` means by being inside the site."""

    box: Edges | None = Field(None, description="Full edge lengths of a box.")
    sphere: Length | None = Field(None, description="Radius of a sphere.")
    cylinder: Cylinder | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Marker:
        exactly_one("a marker", self, "box", "sphere", "cylinder")
        return self


class SiteSpec(Placed):
    """A named frame without a body; it moves with the body it is `in`."""

    marker: Marker | None = None
    color: Color = "green"
    opacity: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None,
        description="Opacity of the marker; 1 is opaque. The default is 0.35 if the marker is "
        "thicker than 6 cm in every direction, and otherwise 1. The renderer `tiny` draws all "
        "markers with opacity 1.",
    )

    @model_validator(mode="after")
    def _no_clearance(self) -> SiteSpec:
        usual = Place.model_fields["clearance"].default
        if self.place is not None and self.place.clearance != usual:
            raise PydanticCustomError("choice", "a site has no body and keeps no clearance")
        return self
