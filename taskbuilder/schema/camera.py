"""Cameras of a task file."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from taskbuilder.geometry import norm, subtract
from taskbuilder.schema.values import FrameName, Model, Pixels, Position

FAR_M = 10.0
"""How far a camera sees at least, unless its task says otherwise."""

NEAREST_M, FURTHEST_M = 0.001, 1000.0
"""Bounds of near and far planes; positions of a task file are at most 350 m apart."""


class CameraSpec(Model):
    """A camera that stands in the world or is mounted on a frame."""

    mount: FrameName | None = Field(
        None, description="Frame to which the camera is attached, such as left.tcp."
    )
    position: Position | None = None
    look_at: Position | None = None
    fov_deg: Annotated[float, Field(ge=5.0, le=150.0)] = 50.0
    size: tuple[Pixels, Pixels] = Field((640, 480), description="Width and height of the images.")
    near: Annotated[float, Field(ge=NEAREST_M, le=FURTHEST_M)] = Field(
        0.02, description="Distance of the near plane; nothing nearer is drawn."
    )
    far: Annotated[float, Field(ge=NEAREST_M, le=FURTHEST_M)] | None = Field(
        None,
        description="Distance of the far plane; nothing farther is drawn. By default 10, or twice "
        "the distance from `position` to `look_at` if that is more.",
    )

    @model_validator(mode="after")
    def _aims(self) -> CameraSpec:
        if self.mount is None and (self.position is None or self.look_at is None):
            raise PydanticCustomError("choice", "a camera has position and look_at, or a mount")
        if self.eye == self.aim:
            raise PydanticCustomError("choice", "position and look_at are the same point")
        if not self.near < self.far_plane:
            raise PydanticCustomError(
                "choice",
                "near is {near} m and far is {far} m; near must be less",
                {"near": f"{self.near:g}", "far": f"{self.far_plane:g}"},
            )
        if self.distance > self.far_plane:
            raise PydanticCustomError(
                "choice",
                "far is {far} m, but look_at is {distance} m away and so would not be drawn; "
                "make far larger, or leave it out",
                {"far": f"{self.far_plane:g}", "distance": f"{self.distance:.3g}"},
            )
        return self

    @property
    def eye(self) -> Position:
        """Where the camera is, in the world or in its mount."""
        return self.position or (0.09, 0.0, -0.10)

    @property
    def aim(self) -> Position:
        """The point it looks at, in the world or in its mount."""
        return self.look_at or (0.0, 0.0, 0.06)

    @property
    def distance(self) -> float:
        """From where it is to the point it looks at, m."""
        return norm(subtract(self.aim, self.eye))

    @property
    def far_plane(self) -> float:
        """Distance beyond which nothing is drawn, m."""
        return max(FAR_M, 2.0 * self.distance) if self.far is None else self.far
