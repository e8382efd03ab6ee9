"""How experts do a task: stages, each a barrier, with an order for each robot that acts in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.spec.values import (
    Coordinate,
    Extent,
    Model,
    Name,
    Reference,
    Shorthand,
    exactly_one,
)

VERBS = ("grasp", "reach", "bring", "retreat", "release")


class Order(Model):
    """One robot's part of a stage: exactly one verb, and what goes with it."""

    grasp: Reference | None = Field(
        None, description="Grasp point to take, such as stick.left_end."
    )
    reach: Reference | None = Field(None, description="Grasp point or frame to go to.")
    bring: Reference | None = Field(None, description="Held object to bring somewhere.")
    retreat: Extent | None = Field(None, description="Metres to back off against the approach.")
    release: Literal[True] | None = Field(None, description="Open the gripper.")
    to: Reference | None = Field(None, description="Frame that the brought object goes to.")
    above: Coordinate = Field(0.0, description="Metres above the named frame.")

    @property
    def verb(self) -> str:
        """The key that says what to do."""
        return next(name for name in VERBS if getattr(self, name) is not None)

    @model_validator(mode="after")
    def _one_verb(self) -> Order:
        exactly_one("an order", self, *VERBS)
        if (self.bring is None) != (self.to is None):
            raise PydanticCustomError(
                "choice", "bring and to go together: {bring: stick, to: goal}"
            )
        return self


class Together(Model):
    """One load held by several grippers, moved as one and kept level."""

    together: Annotated[tuple[Name, ...], Field(min_length=2)]
    bring: Reference
    to: Reference
    above: Coordinate = 0.0


Stage = Mapping[Name, Annotated[Order, Shorthand("release", {"release": True})]]
