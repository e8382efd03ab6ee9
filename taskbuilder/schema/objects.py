"""The objects of a scene: their bodies, masses, grasp points and joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.arrangement import ARRANGEMENTS, MAX_COUNT, Arrangement
from taskbuilder.schema.joints import JointSpec
from taskbuilder.schema.placing import Placed
from taskbuilder.schema.shapes import SHAPES, PartSpec, Shape
from taskbuilder.schema.values import (
    Color,
    Friction,
    Mass,
    Model,
    Name,
    OrNumber,
    Position,
    Reference,
    exactly_one,
    frozen,
)

_KINDS = f"one of {', '.join(ARRANGEMENTS)}"


class Grasp(Model):
    """Where and how a gripper can take a body."""

    at: Position = Field(
        (0.0, 0.0, 0.0), description="Position of the point, in the frame of the object or `link`."
    )
    link: Reference | None = Field(
        None, description="Link of the URDF to which the point is fixed; by default the base link."
    )
    approach: Literal["down", "+x", "-x", "+y", "-y", "+z", "-z"] = Field(
        "down",
        description="Direction in which the tool approaches: `down` in the world, or along an axis "
        "of the frame in which `at` is given.",
    )
    across: Literal["x", "y", "z"] = Field(
        "y",
        description="Axis along which the fingers close, in the frame in which `at` is given.",
    )


class ObjectSpec(Placed):
    """A body: one shape, or a compound of named parts."""

    INSTEAD: ClassVar = {
        **{kind: f"it is a shape; write shape: {{{{{kind}: {{}}}}}}" for kind in SHAPES},
        "scale": "it goes with a mesh or urdf, inside shape: {{mesh: part.obj, scale: {}}}",
    }

    count: Annotated[int, Field(ge=1, le=MAX_COUNT)] | None = Field(
        None, description="Number of objects; an entry with this key is a group of objects."
    )
    arrange: Arrangement | None = Field(None, description="Arrangement of the objects of a group.")
    shape: Shape | None = None
    parts: Annotated[Mapping[Name, PartSpec], AfterValidator(frozen)] | None = None
    fixed: bool = Field(False, description="Whether the object is fixed to the world.")
    mass: Mass | None = Field(
        None,
        description="Mass of the object; not given for a URDF, which contains the masses of its "
        "links.",
    )
    friction: Friction = 0.8
    rolling_friction: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    color: Color = "gray"
    grasps: Annotated[Mapping[Name, Grasp], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen({})
    )
    joints: Annotated[
        Mapping[Reference, Annotated[JointSpec | float, OrNumber()]], AfterValidator(frozen)
    ] = Field(
        default_factory=lambda: frozen({}),
        description="Initial position, limits, spring, damping, friction and lock of URDF joints.",
    )

    def joint(self, name: str, *, turns: bool) -> JointSpec:
        """What the file says of a joint, or what holds where it says nothing."""
        return JointSpec.of(self.joints.get(name, JointSpec()), turns=turns)

    @property
    def urdf(self) -> str | None:
        """The URDF file, for an articulated object."""
        return self.shape.urdf if self.shape else None

    @model_validator(mode="after")
    def _whole(self) -> ObjectSpec:
        exactly_one("an object", self, "shape", "parts")
        if self.parts is not None and not self.parts:
            raise PydanticCustomError("choice", "parts is empty; name at least one")
        if self.urdf is not None and self.mass is not None:
            raise PydanticCustomError("choice", "mass does not go with urdf; the URDF has masses")
        if self.urdf is None and self.joints:
            raise PydanticCustomError("choice", "joints goes with urdf only")
        if self.urdf is None and not self.fixed and self.mass is None:
            raise PydanticCustomError("mass", "mass is missing; give kilograms, or fixed: true")
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
