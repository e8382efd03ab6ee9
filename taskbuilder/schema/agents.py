"""The robots of a scene, and what their actions mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from taskbuilder.extensions import ACTION_MODES
from taskbuilder.schema.postures import Base, Home, NamedPosture
from taskbuilder.schema.robot import GraspSpec
from taskbuilder.schema.values import (
    Model,
    Name,
    OneOf,
    Text,
    frozen,
)

ARM_MODES = (
    *("tcp_delta", "tcp_pose", "tcp_path"),
    *("joint_delta", "joint_position", "joint_velocity", "joint_torque"),
)
"""The library's own action modes."""


class ActionSpec(Model):
    """What an agent's action means."""

    arm: Annotated[str, OneOf(ARM_MODES, ACTION_MODES)] = "tcp_delta"
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
