"""The scene of a task file: robots, objects, sites and cameras.

Lengths in metres, masses in kilograms, angles in degrees where the key says ``_deg``. Boxes by
full edge lengths. Orientations are roll, pitch and yaw about fixed x, y, z, as in URDF.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.geometry import Pose
from taskbuilder.schema.arrangement import ARRANGEMENTS, MAX_COUNT, Arrangement
from taskbuilder.schema.bodies import BodySpec, Cylinder
from taskbuilder.schema.camera import CameraSpec
from taskbuilder.schema.names import Refers
from taskbuilder.schema.postures import Base, Home, NamedPosture
from taskbuilder.schema.robot import GraspSpec
from taskbuilder.schema.values import (
    Color,
    Coordinate,
    Degrees,
    Edges,
    Extent,
    FrameOrWorld,
    Length,
    Model,
    Name,
    Position,
    Reference,
    RpyDeg,
    Text,
    exactly_one,
    frozen,
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


_KINDS = f"one of {', '.join(ARRANGEMENTS)}"


class _Placed(Model):
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
    def _one_way(self) -> _Placed:
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


class ObjectSpec(_Placed, BodySpec):
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


class Marker(Model):
    """How a site looks; its volume is what `Inside` means by being inside the site."""

    box: Edges | None = Field(None, description="Full edge lengths of a box.")
    sphere: Length | None = Field(None, description="Radius of a sphere.")
    cylinder: Cylinder | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Marker:
        exactly_one("a marker", self, "box", "sphere", "cylinder")
        return self


class SiteSpec(_Placed):
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


class ActionSpec(Model):
    """What an agent's action means."""

    arm: Literal[
        "tcp_delta",
        "tcp_pose",
        "tcp_path",
        "joint_delta",
        "joint_position",
        "joint_velocity",
        "joint_torque",
    ] = "tcp_delta"
    frame: Literal["world", "base", "tcp"] = "world"
    max_step: Annotated[float, Field(gt=0.0, le=0.5)] = Field(
        0.05, description="Maximum translation in a control step, in metres."
    )
    turn: Literal["none", "yaw", "full"] = "yaw"
    max_turn_deg: Annotated[float, Field(gt=0.0, le=90.0)] = 15.0
    gripper: Literal["binary", "continuous"] = "binary"


class RobotEntry(Model):
    """A robot of the scene: an agent."""

    model: Text = Field(description="A robot of the catalogue, or the path of a robot.yaml.")
    base: Base = Field(description="Pose of its base, such as {position: [0, 0, 0.4]}.")
    home: Home | None = Field(
        None, description="Start configuration; by default the one in the robot.yaml of the model."
    )
    postures: Annotated[Mapping[Name, NamedPosture], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen({}),
        description="Named joint configurations for the expert, such as {tucked: {joints_deg: "
        "[...]}}.",
    )
    grasp: GraspSpec | None = Field(
        None,
        description="How its gripper holds objects; by default as in the robot.yaml of the model.",
    )
    action: ActionSpec = ActionSpec()


class SceneSpec(Model):
    """What is there."""

    robots: Annotated[Mapping[Name, RobotEntry], Field(min_length=1), AfterValidator(frozen)] = (
        Field(description="The agents, by name.")
    )
    objects: Annotated[Mapping[Name, ObjectSpec], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen({})
    )
    sites: Annotated[Mapping[Name, SiteSpec], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen({})
    )
    cameras: Annotated[Mapping[Name, CameraSpec], AfterValidator(frozen)] = Field(
        default_factory=lambda: frozen(
            {"front": CameraSpec(position=(0.0, -1.7, 1.35), look_at=(0.0, 0.0, 0.5))}
        )
    )
    floor: bool = Field(True, description="Whether there is a floor at z = 0.")
