"""A robot or object as it is read from any format, before it is written as a URDF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from taskbuilder.assets.model import JointType, ShapeKind, UrdfMimic
from taskbuilder.errors import Location
from taskbuilder.geometry import Pose, Vec3

Rgba = tuple[float, float, float, float]
Role = Literal["visual", "collision"]


@dataclass(frozen=True)
class ImportedShape:
    """One visual or collision shape.

    Attributes:
        kind: Its kind.
        size: Sizes as in a URDF, in metres; of a mesh its scale along x, y and z.
        pose: The shape in the frame of its link.
        place: Where the source describes it.
        mesh: Reference to a mesh file as the source writes it, relative to ``folder``.
        color: Red, green, blue and opacity, or None.
        texture: Reference to an image, or "".
        file: The mesh that is written, relative to the URDF; "" until then.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    pose: Pose
    place: Location
    mesh: str = ""
    color: Rgba | None = None
    texture: str = ""
    file: str = ""


@dataclass(frozen=True)
class Inertial:
    """Mass and moments of a link.

    Attributes:
        mass: In kg.
        pose: The frame of the moments, with its origin in the centre of mass.
        moments: ixx, ixy, ixz, iyy, iyz, izz in kg·m²; None if the source gives none.
    """

    mass: float
    pose: Pose
    moments: tuple[float, ...] | None


@dataclass(frozen=True)
class Link:
    """A rigid body or a frame."""

    name: str
    inertial: Inertial | None
    visuals: tuple[ImportedShape, ...]
    collisions: tuple[ImportedShape, ...]
    place: Location


@dataclass(frozen=True)
class ImportedJoint:
    """A connection of two links; like that of a URDF, with what opposes its motion."""

    name: str
    type: JointType
    parent: str
    child: str
    pose: Pose
    axis: Vec3
    place: Location
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    mimic: UrdfMimic | None = None

    @property
    def moves(self) -> bool:
        """Whether it has a degree of freedom."""
        return self.type != "fixed"


@dataclass(frozen=True)
class ImportedBody:
    """A tree of links and joints.

    Attributes:
        file: The file that was read.
        folder: The folder to which references to meshes are relative.
        name: Its name.
        links: In file order.
        joints: In file order.
        postures: Name -> joint positions (rad or m), as the file itself names them.
    """

    file: Path
    folder: Path
    name: str
    links: tuple[Link, ...]
    joints: tuple[ImportedJoint, ...]
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def link(self, name: str) -> Link:
        """The link of a name."""
        return next(link for link in self.links if link.name == name)

    def joint_above(self, link: str) -> ImportedJoint | None:
        """The joint whose child a link is; None for the root."""
        return next((joint for joint in self.joints if joint.child == link), None)

    @property
    def root(self) -> str:
        """The link without a parent."""
        children = {joint.child for joint in self.joints}
        return next(link.name for link in self.links if link.name not in children)

    def rigid_group(self, link: str) -> frozenset[str]:
        """A link and all that fixed joints connect to it."""
        group, pending = {link}, [link]
        while pending:
            current = pending.pop()
            for joint in self.joints:
                if joint.moves or current not in (joint.parent, joint.child):
                    continue
                other = joint.child if current == joint.parent else joint.parent
                if other not in group:
                    group.add(other)
                    pending.append(other)
        return frozenset(group)

    def with_links(self, links: Mapping[str, Link]) -> ImportedBody:
        """The same with some links replaced."""
        return replace(self, links=tuple(links.get(link.name, link) for link in self.links))


def links_without_collision(description: ImportedBody) -> list[str]:
    """Links that can be seen and that move, in rigid groups of which nothing collides."""
    children = {joint.child for joint in description.joints if joint.moves}
    needy: list[str] = []
    for link in description.links:
        if link.name not in children:
            continue
        group = description.rigid_group(link.name)
        members = [one for one in description.links if one.name in group]
        if not any(one.collisions for one in members):
            needy += [one.name for one in members if one.visuals]
    return needy
