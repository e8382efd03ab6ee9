"""The scene of a task file: robots, objects, sites and cameras."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import AfterValidator, Field

from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.camera import CameraSpec
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.sites import SiteSpec
from taskbuilder.schema.values import (
    Model,
    Name,
    frozen,
)


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
