"""Links and joints, and robots made of them as URDF and OBJ files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from robot_modelling.solids import Mesh
from robot_modelling.wavefront import merged, obj_text

Vec3 = tuple[float, float, float]
Inertia = tuple[float, float, float, float, float, float]
Part = tuple[str, Mesh]  # (colour, mesh)

ORIGIN: Vec3 = (0.0, 0.0, 0.0)
PAD_FRICTION = 1.2


@dataclass(frozen=True)
class Shape:
    """A collision primitive: what it is in URDF, and where it lies in its link."""

    geometry: str
    xyz: Vec3 = ORIGIN
    rpy: Vec3 = ORIGIN


@dataclass(frozen=True)
class Link:
    """A link: its mass and inertia about the centre of mass, its shapes and its look."""

    name: str
    mass: float  # kg
    inertia: Inertia  # kg m²: xx, xy, xz, yy, yz, zz
    center: Vec3 = ORIGIN
    rpy: Vec3 = ORIGIN  # of the inertia's axes
    shapes: tuple[Shape, ...] = ()
    parts: list[Part] = field(default_factory=list)
    is_pad: bool = False
    folder: str = "meshes"  # of its meshes, relative to the URDF
    plain: tuple[tuple[str, Shape], ...] = ()  # primitives that are drawn, by colour
    digits: tuple[int, int] = (5, 3)  # of points and normals of its meshes


@dataclass(frozen=True)
class Joint:
    """A joint between two links; fixed where it has no axis."""

    name: str
    parent: str
    child: str
    xyz: Vec3
    rpy: Vec3 = ORIGIN
    kind: str = "fixed"
    axis: Vec3 = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    speed: float = 0.0
    mimic: tuple[str, float] | None = None


def following(joint: Joint, leader: str, multiplier: float = 1.0) -> Joint:
    """Return the joint as one that moves with another; the leader itself stays as it is."""
    return joint if joint.name == leader else replace(joint, mimic=(leader, multiplier))


def revolute(
    name: str,
    between: tuple[str, str],
    xyz: Vec3,
    rpy: Vec3,
    limits: tuple[float, float],
    effort: float,
    speed: float,
    axis: Vec3 = (0.0, 0.0, 1.0),
) -> Joint:
    """Return a joint that turns between a parent and its child: rad, N m and rad/s."""
    return Joint(name, *between, xyz, rpy, "revolute", axis, *limits, effort, speed)


def prismatic(
    name: str,
    between: tuple[str, str],
    xyz: Vec3,
    axis: Vec3,
    limits: tuple[float, float],
    effort: float,
    speed: float,
    rpy: Vec3 = ORIGIN,
) -> Joint:
    """Return a joint that slides between a parent and its child: m, N and m/s."""
    return Joint(name, *between, xyz, rpy, "prismatic", axis, *limits, effort, speed)


def numbers(values: Iterable[float]) -> str:
    """Return numbers as URDF wants them, ten significant digits and no minus zero."""
    return " ".join(f"{value + 0.0:.10g}" for value in values)


def origin(xyz: Iterable[float], rpy: Iterable[float]) -> str:
    """Return an origin element."""
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'


def colors(link: Link) -> list[str]:
    """Return the colours of a link's parts, in their order."""
    return list(dict.fromkeys(color for color, _ in link.parts))


def mesh_name(link: Link, color: str) -> str:
    """Return the file name of a link's parts of one colour."""
    return f"{link.name.removesuffix('_link')}_{color}.obj"


def mesh_files(link: Link) -> dict[str, str]:
    """Return a link's meshes, one a colour, by their paths relative to the URDF."""
    files = {}
    for color in colors(link):
        mesh = merged(mesh for c, mesh in link.parts if c == color)
        files[f"{link.folder}/{mesh_name(link, color)}"] = obj_text(
            mesh, f"{link.name}, {color}", link.digits
        )
    return files


def link_lines(link: Link) -> list[str]:
    """Return a link's URDF."""
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    inertia = " ".join(f'{k}="{v + 0.0:.9g}"' for k, v in zip(keys, link.inertia, strict=True))
    lines = [
        f'  <link name="{link.name}">',
        "    <inertial>",
        f"      {origin(link.center, link.rpy)}",
        f'      <mass value="{link.mass:g}"/>',
        f"      <inertia {inertia}/>",
        "    </inertial>",
    ]
    for color in colors(link):
        mesh = f"{link.folder}/{mesh_name(link, color)}"
        lines += [
            "    <visual>",
            f'      <geometry><mesh filename="{mesh}"/></geometry>',
            f'      <material name="{color}"/>',
            "    </visual>",
        ]
    for color, shape in link.plain:
        lines += [
            "    <visual>",
            f"      {origin(shape.xyz, shape.rpy)}",
            f"      <geometry>{shape.geometry}</geometry>",
            f'      <material name="{color}"/>',
            "    </visual>",
        ]
    if link.is_pad:
        # An anchored friction holds what it grips; without it a grasp creeps by a millimetre and
        # two degrees a second, because the solver stops short of convergence.
        lines += [
            "    <contact>",
            f'      <lateral_friction value="{PAD_FRICTION:g}"/>',
            "      <friction_anchor/>",
            "    </contact>",
        ]
    for shape in link.shapes:
        lines += [
            "    <collision>",
            f"      {origin(shape.xyz, shape.rpy)}",
            f"      <geometry>{shape.geometry}</geometry>",
            "    </collision>",
        ]
    return [*lines, "  </link>"]


def joint_lines(joint: Joint) -> list[str]:
    """Return a joint's URDF."""
    lines = [
        f'  <joint name="{joint.name}" type="{joint.kind}">',
        f"    {origin(joint.xyz, joint.rpy)}",
        f'    <parent link="{joint.parent}"/>',
        f'    <child link="{joint.child}"/>',
    ]
    if joint.kind != "fixed":
        lines += [
            f'    <axis xyz="{numbers(joint.axis)}"/>',
            f'    <limit lower="{joint.lower:.10g}" upper="{joint.upper:.10g}"'
            f' effort="{joint.effort:g}" velocity="{joint.speed:.10g}"/>',
        ]
    if joint.mimic:
        leader, multiplier = joint.mimic
        lines.append(f'    <mimic joint="{leader}" multiplier="{multiplier:g}"/>')
    return [*lines, "  </joint>"]


def robot_text(
    name: str,
    note: str,
    materials: Mapping[str, Vec3],
    links: Iterable[Link],
    joints: Iterable[Joint],
) -> str:
    """Return a whole robot as URDF.

    Args:
        name: Of the robot.
        note: A comment at the beginning.
        materials: Colours (red, green, blue), 0 to 1, by name.
        links: Base first.
        joints: Between them.
    """
    lines = ['<?xml version="1.0"?>', f"<!-- {note} -->", f'<robot name="{name}">']
    for color, rgb in materials.items():
        lines.append(f'  <material name="{color}"><color rgba="{numbers(rgb)} 1"/></material>')
    for link in links:
        lines += link_lines(link)
    for joint in joints:
        lines += joint_lines(joint)
    return "\n".join([*lines, "</robot>"]) + "\n"
