"""What a body is made of, apart from where it stands: shapes, masses, grasp points and joints.

Lengths in metres, masses in kilograms, angles in degrees where the key says ``_deg``. Boxes by
full edge lengths. Orientations are roll, pitch and yaw about fixed x, y, z, as in URDF.
"""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.joints import JointSpec
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
    frozen,
)


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
    inside: bool = Field(
        False,
        description="Hold it from inside, as a cup: the fingers go in closed, and open to hold it. "
        "Only for grippers that hold by friction; others take it as usual.",
    )


class BodySpec(Model):
    """A body without its place: one shape, or a compound of named parts."""

    INSTEAD: ClassVar = {
        **{kind: f"it is a shape; write shape: {{{{{kind}: {{}}}}}}" for kind in SHAPES},
        "scale": "it goes with a mesh or urdf, inside shape: {{mesh: part.obj, scale: {}}}",
        "collide": "it goes with a mesh, inside shape: {{mesh: part.obj, collide: {}}}",
    }

    shape: Shape | None = None
    parts: Annotated[Mapping[Name, PartSpec], AfterValidator(frozen)] | None = None
    mass: Mass | None = Field(
        None,
        description="Mass of the object. The masses of the links of a URDF are scaled to add up to "
        "it; by default they are as in the file.",
    )
    density: Annotated[float, Field(gt=0.0, le=1e5)] | None = Field(
        None,
        description="Density in kg/m³, given instead of `mass`; the volume is that of the shape, "
        "the parts, or the `<collision>` shapes of each link of a URDF.",
    )
    inertia: Literal["shape"] | None = Field(
        None,
        description="`shape`: the moments of inertia and the centre of mass of each link of a URDF "
        "are those of its `<collision>` shapes with uniform density, whatever the file says. Those "
        "of other objects always are.",
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
        description="Initial position, limits, spring, damping, friction and lock of URDF joints. "
        "The key `bend_*` stands for all joints whose names begin with bend_ and that have no key "
        "of their own.",
    )

    def joint(self, name: str, *, turns: bool) -> JointSpec:
        """What the file says of a joint, or what holds where it says nothing."""
        key = self.joint_key(name)
        return JointSpec.of(JointSpec() if key is None else self.joints[key], turns=turns)

    def joint_key(self, name: str) -> str | None:
        """The key that speaks of a joint: its name, or else the first pattern that fits."""
        if name in self.joints:
            return name
        return next((key for key in self.joints if "*" in key and fnmatchcase(name, key)), None)

    @property
    def urdf(self) -> str | None:
        """The URDF file, for an articulated object."""
        return self.shape.urdf if self.shape else None

    @model_validator(mode="after")
    def _one_body(self) -> BodySpec:
        if self.parts is not None and not self.parts:
            raise PydanticCustomError("choice", "parts is empty; name at least one")
        if self.mass is not None and self.density is not None:
            raise PydanticCustomError("choice", "it has both mass and density; keep one")
        return self
