"""The robot as URDF."""

from __future__ import annotations

from collections.abc import Iterable

from ur5e_generator.figures import COLORS, PAD_FRICTION
from ur5e_generator.robot import Joint, Link, joints, links


def numbers(values: Iterable[float]) -> str:
    """Return numbers as URDF wants them, ten significant digits and no minus zero."""
    return " ".join(f"{value + 0.0:.10g}" for value in values)


def origin(xyz: Iterable[float], rpy: Iterable[float]) -> str:
    """Return an origin element."""
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'


def mesh_name(link: Link, color: str) -> str:
    """Return the file name of a link's parts of one colour."""
    return f"{link.name.removesuffix('_link')}_{color}.obj"


def link_lines(link: Link) -> list[str]:
    """Return a link's URDF."""
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    inertia = " ".join(f'{k}="{v:.9g}"' for k, v in zip(keys, link.inertia, strict=True))
    lines = [
        f'  <link name="{link.name}">',
        "    <inertial>",
        f"      {origin(link.center, link.rpy)}",
        f'      <mass value="{link.mass:g}"/>',
        f"      <inertia {inertia}/>",
        "    </inertial>",
    ]
    for color in dict.fromkeys(color for color, _ in link.parts):
        lines += [
            "    <visual>",
            f'      <geometry><mesh filename="meshes/{mesh_name(link, color)}"/></geometry>',
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
    return [*lines, "  </joint>"]


def urdf_text() -> str:
    """Return the whole robot as URDF."""
    lines = [
        '<?xml version="1.0"?>',
        "<!-- Written by generate.py; change it there. Metres, kilograms, radians. -->",
        '<robot name="ur5e">',
    ]
    for name, rgb in COLORS.items():
        lines.append(f'  <material name="{name}"><color rgba="{numbers(rgb)} 1"/></material>')
    for link in links():
        lines += link_lines(link)
    for joint in joints():
        lines += joint_lines(joint)
    return "\n".join([*lines, "</robot>"]) + "\n"
