"""Joints of articulated objects: what they move, and where to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.geometry import Pose, Vec3, rotate, scale, subtract
from taskbuilder.world.world import World


def joints_above(world: World, owner: str, link: str) -> tuple[UrdfJoint, ...]:
    """The joints that move between an articulated object's base and a link, the nearest first."""
    urdf = world.task.assets.get(owner)
    return urdf.moving_joints_above(link) if isinstance(urdf, Urdf) else ()


@dataclass(frozen=True)
class Joint:
    """A joint of an articulated object.

    Attributes:
        world: The world it is in.
        name: Its name, such as ``chest.hinge``.
    """

    world: World
    name: str

    @property
    def owner(self) -> str:
        """The object."""
        return self.name.partition(".")[0]

    @cached_property
    def urdf(self) -> UrdfJoint:
        """The joint in the URDF of its object."""
        asset = self.world.task.assets[self.owner]
        if not isinstance(asset, Urdf):
            raise TypeError(f"{self.owner} has no joints")
        return asset.joint(self.name.partition(".")[2])

    @property
    def slides(self) -> bool:
        """Whether it is prismatic."""
        return self.urdf.type == "prismatic"

    @property
    def child(self) -> str:
        """The link that it moves, as ``chest.lid``."""
        return f"{self.owner}.{self.urdf.child}"

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest position, in rad or m."""
        built = self.world.objects[self.owner].body.joints[self.urdf.name]
        return built.lower, built.upper

    @property
    def below(self) -> tuple[str, ...]:
        """All links that move with it, as ``chest.lid``."""
        return tuple(
            f"{self.owner}.{link}"
            for link in self.world.objects[self.owner].boxes
            if self.urdf in joints_above(self.world, self.owner, link)
        )

    def axis(self, child: Pose) -> Vec3:
        """Its axis in the world, where its child is at a pose."""
        return rotate(child.quaternion, self.urdf.axis)

    def shift(self, child: Pose, by: float) -> Pose:
        """How points of the world on its links are displaced, as it moves by rad or m."""
        return displaced(self.urdf, child, by)


def displaced(joint: UrdfJoint, child: Pose, by: float) -> Pose:
    """How the world's points on a link move as its joint does.

    Args:
        joint: The joint above the link.
        child: Pose of the link in the world.
        by: How far the joint moves, in rad or m.
    """
    axis = rotate(child.quaternion, joint.axis)
    if joint.type == "prismatic":
        return Pose(scale(axis, by))
    turn = (*scale(axis, math.sin(by / 2.0)), math.cos(by / 2.0))
    return Pose(subtract(child.position, rotate(turn, child.position)), turn)
