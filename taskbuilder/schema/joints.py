"""How the joints of articulated objects start, move and are held, as task files say it.

Metres where a joint slides, degrees where it turns, in keys that end in ``_deg``. What resists a
motion is in newtons and newton metres; what grows with it is for each metre, or each radian.
"""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.expert import Condition
from taskbuilder.schema.values import Coordinate, Model

Resistance = Annotated[float, Field(ge=0.0, le=1e4)]


class Spring(Model):
    """A spring that pulls a joint to where it rests."""

    stiffness: Annotated[float, Field(gt=0.0, le=1e5)] = Field(
        description="In N/m where the joint slides, N m/rad where it turns."
    )
    rest: Coordinate | None = Field(
        None, description="Position at which it does not pull, in metres; 0 by default."
    )
    rest_deg: float | None = Field(None, description="The same of a joint that turns.")

    @model_validator(mode="after")
    def _one_unit(self) -> Spring:
        _at_most_one(self, "rest")
        return self

    @property
    def at(self) -> float:
        """Where it does not pull, in rad or m."""
        return _si(self.rest, self.rest_deg) or 0.0


class Lock(Model):
    """What holds a joint where it is."""

    unless: Condition = Field(
        description="Condition of the description: while it holds, the joint is free."
    )


class JointSpec(Model):
    """One joint of an articulated object."""

    start: Coordinate | None = Field(
        None, description="Position when the episode begins, in metres; 0 by default."
    )
    start_deg: float | None = Field(None, description="The same of a joint that turns.")
    limits: tuple[Coordinate, Coordinate] | None = Field(
        None, description="Least and greatest position, within those of the URDF, in metres."
    )
    limits_deg: tuple[float, float] | None = Field(
        None, description="The same of a joint that turns."
    )
    spring: Spring | None = Field(None, description="What pulls it back.")
    damping: Resistance | None = Field(
        None, description="In N s/m or N m s/rad; the URDF's own where not given."
    )
    friction: Resistance = Field(
        0.5, description="What it takes to move it, in N or N m: keeps a drawer where it was left."
    )
    lock: Lock | None = Field(None, description="What holds it where it is.")

    @model_validator(mode="after")
    def _whole(self) -> JointSpec:
        _at_most_one(self, "start")
        _at_most_one(self, "limits")
        for key in ("limits", "limits_deg"):
            bounds = getattr(self, key)
            if bounds is not None and bounds[0] > bounds[1]:
                raise PydanticCustomError(
                    "order", "{key} is [least, greatest]; swap them", {"key": key}
                )
        return self

    @property
    def begin(self) -> float | None:
        """Where it starts, in rad or m, if that is said."""
        return _si(self.start, self.start_deg)

    @property
    def range(self) -> tuple[float, float] | None:
        """Its limits, in rad or m, if they are said."""
        if self.limits_deg is not None:
            return math.radians(self.limits_deg[0]), math.radians(self.limits_deg[1])
        return self.limits

    @classmethod
    def of(cls, written: JointSpec | float, *, turns: bool) -> JointSpec:
        """What a file says of a joint; a number is where it starts, in degrees if it turns."""
        if isinstance(written, JointSpec):
            return written
        return (
            cls.model_construct(start_deg=written) if turns else cls.model_construct(start=written)
        )


UNITS = {"start": "start_deg", "limits": "limits_deg", "rest": "rest_deg"}
"""Key of a joint that slides -> that of one that turns."""


def _si(metres: float | None, degrees: float | None) -> float | None:
    return metres if degrees is None else math.radians(degrees)


def _at_most_one(model: Model, key: str) -> None:
    if getattr(model, key) is not None and getattr(model, UNITS[key]) is not None:
        raise PydanticCustomError(
            "choice",
            "{key} is for a joint that slides and {turning} for one that turns; give one",
            {"key": key, "turning": UNITS[key]},
        )
