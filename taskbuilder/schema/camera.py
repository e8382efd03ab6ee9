"""Cameras of a task file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.schema.values import FrameName, Model, Pixels, Position


class CameraSpec(Model):
    """A camera that stands in the world or is mounted on a frame."""

    mount: FrameName | None = Field(
        None, description="Frame to which the camera is attached, such as left.tcp."
    )
    position: Position | None = None
    look_at: Position | None = None
    fov_deg: Annotated[float, Field(ge=5.0, le=150.0)] = 50.0
    size: tuple[Pixels, Pixels] = Field((640, 480), description="Width and height of the images.")

    @model_validator(mode="after")
    def _aims(self) -> CameraSpec:
        if self.mount is None and (self.position is None or self.look_at is None):
            raise PydanticCustomError("choice", "a camera has position and look_at, or a mount")
        if self.eye == self.aim:
            raise PydanticCustomError("choice", "position and look_at are the same point")
        return self

    @property
    def eye(self) -> Position:
        """Where the camera is, in the world or in its mount."""
        return self.position or (0.09, 0.0, -0.10)

    @property
    def aim(self) -> Position:
        """The point it looks at, in the world or in its mount."""
        return self.look_at or (0.0, 0.0, 0.06)
