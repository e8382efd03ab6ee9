"""What is known about a robot description that was read and found good."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from taskbuilder.assets.markup import Element
from taskbuilder.errors import Finding, Location, UnknownNameError
from taskbuilder.geometry import Pose, Vec3
from taskbuilder.wording import quoted, suggestion

JointType = Literal["revolute", "continuous", "prismatic", "fixed"]
ShapeKind = Literal["box", "sphere", "cylinder", "capsule", "mesh"]


@dataclass(frozen=True, slots=True)
class UrdfShape:
    """One visual or collision geometry.

    Attributes:
        size: Edge lengths of a box, (radius,) of a sphere, (radius, length) of a cylinder or
            capsule, in metres; the scale of a mesh along x, y, z.
        pose: The shape in the frame of its link.
        mesh: Checked absolute path, for a mesh only.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    pose: Pose
    mesh: Path | None = None


@dataclass(frozen=True, slots=True)
class UrdfLink:
    """A rigid body, or a frame if it has neither mass nor shapes.

    Attributes:
        mass: In kg; None without ``<inertial>``, for which Bullet takes 1 kg if it has collision
            shapes.
    """

    name: str
    mass: float | None
    visuals: tuple[UrdfShape, ...]
    collisions: tuple[UrdfShape, ...]


@dataclass(frozen=True, slots=True)
class UrdfMimic:
    """Position = multiplier · position of ``joint`` + offset. PyBullet leaves it to the caller."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """The connection of a link to its parent.

    Attributes:
        origin: The joint, and so the child at position 0, in the frame of the parent.
        axis: Unit vector in the frame of the joint.
        lower: Least position in rad or m; None where there is no limit.
        upper: Greatest position.
        effort: Greatest torque or force in Nm or N; None if not given.
        velocity: Greatest speed in rad/s or m/s; None if not given.
    """

    name: str
    type: JointType
    parent: str
    child: str
    origin: Pose
    axis: Vec3
    lower: float | None
    upper: float | None
    effort: float | None
    velocity: float | None
    mimic: UrdfMimic | None = None

    @property
    def moves(self) -> bool:
        """Whether the joint has a degree of freedom."""
        return self.type != "fixed"


@dataclass(frozen=True)
class Urdf:
    """A robot description, all of it checked.

    Attributes:
        root: Name of the one link without a parent.
        links: In file order.
        joints: In file order, which is not the order of PyBullet's joint indices.
        meshes: Checked absolute paths, each once.
        textures: Checked absolute paths, each once.
        warnings: Findings that do not forbid the use of the file.
        files: The checked path of each reference, as it is written in the file.
        tree: The XML elements that are passed on.
    """

    path: Path
    name: str
    root: str
    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]
    meshes: tuple[Path, ...]
    textures: tuple[Path, ...]
    warnings: tuple[Finding, ...]
    files: Mapping[str, Path] = field(repr=False, hash=False)
    tree: Element = field(repr=False, compare=False)

    @property
    def moving_joints(self) -> tuple[UrdfJoint, ...]:
        """The joints with a degree of freedom, in file order."""
        return tuple(joint for joint in self.joints if joint.moves)

    def link(self, name: str) -> UrdfLink:
        """The link of a name.

        Raises:
            UnknownNameError: There is none.
        """
        found = {link.name: link for link in self.links}
        if name not in found:
            raise UnknownNameError(_no_such("link", name, self, list(found)))
        return found[name]

    def joint(self, name: str) -> UrdfJoint:
        """The joint of a name.

        Raises:
            UnknownNameError: There is none.
        """
        found = {joint.name: joint for joint in self.joints}
        if name not in found:
            raise UnknownNameError(_no_such("joint", name, self, list(found)))
        return found[name]

    def joint_above(self, link: str) -> UrdfJoint | None:
        """The joint whose child is the link; None for the root.

        Raises:
            UnknownNameError: There is no such link.
        """
        self.link(link)
        return next((joint for joint in self.joints if joint.child == link), None)

    def moving_joints_above(self, link: str) -> tuple[UrdfJoint, ...]:
        """The joints with a degree of freedom between a link and the root, the nearest first.

        Raises:
            UnknownNameError: There is no such link.
        """
        found = []
        joint = self.joint_above(link)
        while joint is not None:
            found += [joint] if joint.moves else []
            joint = self.joint_above(joint.parent)
        return tuple(found)

    def fixed_to(self, link: str) -> Iterator[tuple[str, Pose]]:
        """A link and all that fixed joints connect to it, with their poses in its frame."""
        poses = {link: Pose()}
        pending = [link]
        while pending:
            current = pending.pop()
            yield current, poses[current]
            for joint in self.joints:
                ends = (joint.parent, joint.child)
                if joint.moves or current not in ends:
                    continue
                other, step = (
                    (joint.child, joint.origin)
                    if current == joint.parent
                    else (joint.parent, joint.origin.inverse())
                )
                if other not in poses:
                    poses[other] = poses[current] @ step
                    pending.append(other)

    def place_of(self, link: str) -> Location:
        """Where the file describes a link.

        Raises:
            UnknownNameError: There is no such link.
        """
        self.link(link)
        element = next(each for each in self.tree.all("link") if each.get("name") == link)
        return Location(self.path, element.line, element.column)


def _no_such(kind: str, name: str, urdf: Urdf, names: list[str]) -> str:
    right = suggestion(name, names, what="it has")
    return f"{urdf.path.name} has no {kind} {quoted(name)}; {right}"
