"""Where a robot of a scene stands, and the configurations of its arm that have a name or a use."""

from __future__ import annotations

from pydantic import Field, model_validator

from taskbuilder.geometry import Pose
from taskbuilder.schema.values import Model, Position, RpyDeg, exactly_one


class Base(Model):
    """Where a robot stands."""

    position: Position
    rpy_deg: RpyDeg = (0.0, 0.0, 0.0)

    @property
    def pose(self) -> Pose:
        """The base frame in the world."""
        return Pose.from_rpy_deg(self.position, self.rpy_deg)


class TcpPose(Model):
    """A pose of the tool centre point in the world; z is the direction of approach."""

    position: Position
    rpy_deg: RpyDeg = (180.0, 0.0, 0.0)

    @property
    def pose(self) -> Pose:
        """The tcp frame in the world."""
        return Pose.from_rpy_deg(self.position, self.rpy_deg)


class Home(Model):
    """Where an arm starts."""

    tcp: TcpPose | None = None
    joints_deg: tuple[float, ...] | None = Field(
        None,
        description="One value per arm joint: degrees, or metres for a prismatic joint.",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Home:
        exactly_one("home", self, "tcp", "joints_deg")
        return self


class NamedPosture(Model):
    """A posture of an arm that its orders can name."""

    joints_deg: tuple[float, ...] = Field(
        description="One value per arm joint: degrees, or metres for a prismatic joint."
    )
