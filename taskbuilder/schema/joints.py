"""Joints of articulated objects in task files: start, limits, spring, damping, friction, lock.

Positions of prismatic joints are in metres; those of revolute joints are in degrees, in keys that
end in ``_deg``. Stiffness and damping of revolute joints are per radian.
"""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.order import Condition
from taskbuilder.schema.values import Coordinate, Model

Resistance = Annotated[float, Field(ge=0.0, le=1e4)]


class Spring(Model):
    """A spring that pulls a joint to its rest position."""

    stiffness: Annotated[float, Field(gt=0.0, le=1e5)] = Field(
        description="In N/m, or N m/rad for a revolute joint."
    )
    rest: Coordinate | None = Field(
        None, description="Rest position of a prismatic joint, in metres; 0 by default."
    )
    rest_deg: float | None = Field(
        None, description="Rest position of a revolute joint, in degrees; 0 by default."
    )

    @model_validator(mode="after")
    def _one_unit(self) -> Spring:
        _at_most_one(self, "rest")
        return self

    @property
    def at(self) -> float:
        """The rest position, in rad or m."""
        return _si(self.rest, self.rest_deg) or 0.0


class Lock(Model):
    """Holds a joint at its position."""

    unless: Condition = Field(
        description="Condition of the description; the joint is free while it holds."
    )


class JointSpec(Model):
    """One joint of an articulated object."""

    start: Coordinate | None = Field(
        None, description="Initial position of a prismatic joint, in metres; 0 by default."
    )
    start_deg: float | None = Field(
        None, description="Initial position of a revolute joint, in degrees; 0 by default."
    )
    start_range: tuple[Coordinate, Coordinate] | None = Field(
        None,
        description="Minimum and maximum of the initial position of a prismatic joint, which is "
        "drawn at random in each episode; given instead of `start`.",
    )
    start_range_deg: tuple[float, float] | None = Field(
        None,
        description="Minimum and maximum of the initial position of a revolute joint, which is "
        "drawn at random in each episode; given instead of `start_deg`.",
    )
    limits: tuple[Coordinate, Coordinate] | None = Field(
        None,
        description="Minimum and maximum position of a prismatic joint, within the limits in the "
        "URDF; by default these limits.",
    )
    limits_deg: tuple[float, float] | None = Field(
        None,
        description="Minimum and maximum position of a revolute joint, within the limits in the "
        "URDF; by default these limits.",
    )
    spring: Spring | None = Field(
        None, description="A spring that pulls the joint to a rest position."
    )
    damping: Resistance | None = Field(
        None,
        description="Damping in N s/m, or N m s/rad for a revolute joint; by default as in the "
        "URDF.",
    )
    friction: Resistance = Field(
        0.5, description="Friction force in N, or friction torque in N m for a revolute joint."
    )
    lock: Lock | None = Field(
        None, description="Lock that holds the joint at its position while a condition is false."
    )

    @model_validator(mode="after")
    def _whole(self) -> JointSpec:
        _at_most_one(self, "start")
        _at_most_one(self, "start_range")
        _at_most_one(self, "limits")
        if self.start_between is not None and _si(self.start, self.start_deg) is not None:
            raise PydanticCustomError(
                "choice", "it has both a start and a range of starts; keep one"
            )
        for key in ("start_range", "start_range_deg", "limits", "limits_deg"):
            bounds = getattr(self, key)
            if bounds is not None and bounds[0] > bounds[1]:
                raise PydanticCustomError(
                    "order", "{key} is [least, greatest]; swap them", {"key": key}
                )
        return self

    @property
    def begin(self) -> float | None:
        """The initial position in rad or m, or the middle of its range; None if not given."""
        if self.start_between is not None:
            return sum(self.start_between) / 2.0
        return _si(self.start, self.start_deg)

    @property
    def start_between(self) -> tuple[float, float] | None:
        """The range of the initial position in rad or m; None if it is not drawn at random."""
        return _si_range(self.start_range, self.start_range_deg)

    @property
    def range(self) -> tuple[float, float] | None:
        """The limits in rad or m; None if not given."""
        return _si_range(self.limits, self.limits_deg)

    @classmethod
    def of(cls, written: JointSpec | float, *, turns: bool) -> JointSpec:
        """The joint as written; a number is its start, in degrees for a revolute joint."""
        if isinstance(written, JointSpec):
            return written
        return (
            cls.model_construct(start_deg=written) if turns else cls.model_construct(start=written)
        )


UNITS = {
    "start": "start_deg",
    "start_range": "start_range_deg",
    "limits": "limits_deg",
    "rest": "rest_deg",
}
"""Key of a prismatic joint -> key of a revolute joint."""


def _si(metres: float | None, degrees: float | None) -> float | None:
    return metres if degrees is None else math.radians(degrees)


def _si_range(
    metres: tuple[float, float] | None, degrees: tuple[float, float] | None
) -> tuple[float, float] | None:
    return metres if degrees is None else (math.radians(degrees[0]), math.radians(degrees[1]))


def _at_most_one(model: Model, key: str) -> None:
    if getattr(model, key) is not None and getattr(model, UNITS[key]) is not None:
        raise PydanticCustomError(
            "choice",
            "{key} is for a prismatic joint and {turning} for a revolute one; give one of them",
            {"key": key, "turning": UNITS[key]},
        )
