"""The robot file: about ten lines over a URDF."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import PydanticCustomError, core_schema

from taskbuilder.geometry import Pose
from taskbuilder.schema.values import (
    Friction,
    Model,
    Name,
    Position,
    Positive,
    RpyDeg,
    Text,
    frozen,
)

LinkName = Annotated[str, Field(min_length=1, max_length=200)]

MOST_JOINTS = 16
"""Joints that an arm may have."""


class Tcp(Model):
    """The tool centre point: a frame on a link, z the direction of approach, y that of closing."""

    link: LinkName
    position: Position = (0.0, 0.0, 0.0)
    rpy_deg: RpyDeg = (0.0, 0.0, 0.0)

    @property
    def pose(self) -> Pose:
        """The tcp frame in the link's frame."""
        return Pose.from_rpy_deg(self.position, self.rpy_deg)


class GripperJoint(Model):
    """Where a gripper joint is when the gripper is open and closed (m or rad)."""

    open: float
    closed: float


GraspRule = Literal["friction", "attach"]


class GraspSpec(Model):
    """How a gripper with fingers holds objects; files may write its rule alone."""

    rule: GraspRule | None = Field(
        None,
        description="`friction`: objects are held by the friction of the fingers. `attach`: when "
        "the gripper closes, the nearest object is fixed to it; when it opens, the object is let "
        "go. By default `friction`.",
    )
    distance: Annotated[float, Field(gt=0.0, le=0.2)] | None = Field(
        None,
        description="For `attach`: maximum distance from the tcp to the surface of an object that "
        "a closing gripper takes, in metres; by default 0.04.",
    )
    force: Positive | None = Field(
        None,
        description="For `attach`: force in newtons above which an object comes off; by default "
        "none, so that no load is too heavy.",
    )

    @model_validator(mode="before")
    @classmethod
    def _from_rule(cls, value: Any) -> Any:
        return {"rule": value} if isinstance(value, str) else value

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"enum": list(get_args(GraspRule))}, handler(schema)]}


class GripperSpec(Model):
    """A gripper of one degree of freedom: its joints move together from closed to open.

    A jaw that closes against a fixed one has one joint, and the fixed jaw is its second finger.
    """

    joints: Annotated[Mapping[LinkName, GripperJoint], Field(min_length=1), AfterValidator(frozen)]
    fingers: Annotated[
        tuple[Annotated[tuple[LinkName, ...], Field(min_length=1)], ...],
        Field(
            min_length=2,
            max_length=5,
            description="The links that touch held objects: one list of links per finger. One of "
            "the fingers may be a jaw that does not move.",
        ),
    ]
    stroke: Positive = Field(description="Opening between the pads when open, in metres.")
    force: Positive = Field(
        20.0, description="Force of each finger in N, or torque in N m for revolute joints."
    )
    friction: Friction = Field(1.2, description="Lateral friction coefficient of the finger links.")
    grasp: GraspSpec | None = Field(
        None, description="How it holds objects; by default by the friction of its fingers."
    )


class SuctionSpec(Model):
    """A suction cup at the tcp, whose z axis points out of its mouth."""

    cup: LinkName = Field(description="The link that touches what is held.")
    force: Positive = Field(description="Pull in newtons beyond which it lets go.")
    reach: Annotated[float, Field(gt=0.0, le=0.1)] = Field(
        0.005,
        description="Maximum distance from the tcp to a surface that the cup can take hold of, in "
        "metres.",
    )


class RobotSpec(Model):
    """An arm with a gripper, with suction, or with a tool that takes nothing, over a URDF."""

    robot: Name = Field(description="The name of its folder.")
    summary: Text
    urdf: Text = Field(description="Path relative to this file, or package://pybullet_data/….")
    arm: Annotated[tuple[LinkName, ...], Field(min_length=1, max_length=MOST_JOINTS)] = Field(
        description="The arm's joints, base to wrist."
    )
    tcp: Tcp = Field(description="The tool centre point, such as {link: tool}.")
    home_deg: tuple[float, ...] = Field(
        description="One value per arm joint: degrees, or metres for a prismatic joint."
    )
    gripper: GripperSpec | None = Field(
        None, description="Joints, fingers, stroke and force of the gripper."
    )
    suction: SuctionSpec | None = Field(
        None,
        description="Cup and force of suction. A robot with neither `gripper` nor `suction` can "
        "only push and press.",
    )

    @model_validator(mode="after")
    def _one_end(self) -> RobotSpec:
        if self.gripper is not None and self.suction is not None:
            raise PydanticCustomError(
                "choice", "a robot has gripper and suction; give one of them, or none"
            )
        return self
