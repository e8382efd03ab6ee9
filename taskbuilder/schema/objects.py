"""The objects of a scene: their bodies, masses, grasp points and joints."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.arrangement import ARRANGEMENTS, MAX_COUNT, Arrangement
from taskbuilder.schema.bodies import BodySpec
from taskbuilder.schema.placing import Placed
from taskbuilder.schema.values import (
    Text,
    exactly_one,
)

_KINDS = f"one of {', '.join(ARRANGEMENTS)}"


class ObjectSpec(Placed, BodySpec):
    """An object of a scene: a body of its own, or one of the catalogue."""

    object: Text | None = Field(
        None,
        description="An object of the catalogue, or the path of an object.yaml, given instead of "
        "`shape` and `parts`.",
    )
    count: Annotated[int, Field(ge=1, le=MAX_COUNT)] | None = Field(
        None, description="Number of objects; an entry with this key is a group of objects."
    )
    arrange: Arrangement | None = Field(None, description="Arrangement of the objects of a group.")
    fixed: bool = Field(False, description="Whether the object is fixed to the world.")

    @model_validator(mode="after")
    def _whole(self) -> ObjectSpec:
        exactly_one("an object", self, "object", "shape", "parts")
        own = self.object is None
        if own and self.urdf is None and self.joints:
            raise PydanticCustomError("choice", "joints goes with urdf only")
        unweighed = self.mass is None and self.density is None
        if own and self.urdf is None and not self.fixed and unweighed:
            raise PydanticCustomError("mass", "mass is missing; give kilograms, or fixed: true")
        if not self.fixed and self.shape is not None and self.shape.collide == "exact":
            raise PydanticCustomError("choice", _NOT_EXACT)
        self._grouped()
        return self

    def _grouped(self) -> None:
        if self.count is not None and self.arrange is None:
            raise PydanticCustomError(
                "choice",
                f"count needs an arrangement, such as arrange: {{line: 0.1}} ({_KINDS})",
            )
        if self.arrange is None:
            return
        if self.count is None:
            raise PydanticCustomError("choice", "arrange goes with count; how many are there?")
        if self.arrange.pile is not None and (self.fixed or self.urdf is not None):
            what = "fixed objects" if self.fixed else "URDFs"
            raise PydanticCustomError("choice", f"{what} make no pile; choose another arrangement")


_NOT_EXACT = (
    "collide: exact is for fixed objects, because the physics engine lets other surfaces through; "
    "write pieces, hull or boxes"
)
