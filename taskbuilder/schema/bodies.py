"""What a body is made of, apart from where it stands: shapes, masses, grasp points and joints.

Lengths in metres, masses in kilograms, angles in degrees where the key says ``_deg``. Boxes by
full edge lengths. Orientations are roll, pitch and yaw about fixed x, y, z, as in URDF.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.geometry import Pose
from taskbuilder.schema.joints import JointSpec
from taskbuilder.schema.values import (
    Color,
    Edges,
    Friction,
    Length,
    Mass,
    Model,
    Name,
    OrNumber,
    Position,
    Positive,
    Reference,
    RpyDeg,
    Text,
    exactly_one,
    frozen,
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
    def _one_body(self) -> BodySpec:
        if self.parts is not None and not self.parts:
            raise PydanticCustomError("choice", "parts is empty; name at least one")
        if self.mass is not None and self.density is not None:
            raise PydanticCustomError("choice", "it has both mass and density; keep one")
        return self
