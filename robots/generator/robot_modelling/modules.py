"""Modules: arms and grippers, and grippers mounted on arms."""

from __future__ import annotations

import os.path
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from robot_modelling.forms import Form, Matrix, placed_in, seen, spread, transform
from robot_modelling.urdf import ORIGIN, Inertia, Joint, Link, Vec3, mesh_files, robot_text

DIGITS = (4, 2)
"""Decimals of points and normals: a tenth of a millimetre is less than a pixel."""


@dataclass(frozen=True)
class Piece:
    """A link as it is written: with its forms where they are while all joints are at zero.

    Attributes:
        name: Of the link.
        mass: In kg.
        center: Centre of mass in the link's frame; by default that of the forms.
        inertia: About the centre of mass, along the link's axes; by default that of the forms.
        forms: In the frame of the module's root.
        turn: Roll, pitch and yaw of the axes of the inertia.
        is_pad: Whether it holds objects.
    """

    name: str
    mass: float
    center: Vec3 | None = None
    inertia: Inertia | None = None
    forms: tuple[Form, ...] = ()
    turn: Vec3 = ORIGIN
    is_pad: bool = False


@dataclass(frozen=True)
class Module:
    """An arm or a gripper; the first of its links is its root."""

    links: tuple[Link, ...]
    joints: tuple[Joint, ...]


def module(pieces: Sequence[Piece], joints: Sequence[Joint], folder: str = "meshes") -> Module:
    """Return a module whose forms are in the frames of their links."""
    frames: dict[str, Matrix] = {pieces[0].name: transform()}
    for joint in joints:
        frames[joint.child] = frames[joint.parent] @ transform(joint.xyz, joint.rpy)
    return Module(
        tuple(_link(piece, frames[piece.name], folder) for piece in pieces), tuple(joints)
    )


def _link(piece: Piece, frame: Matrix, folder: str) -> Link:
    forms = placed_in(frame, piece.forms)
    center, inertia = piece.center, piece.inertia
    if inertia is None:
        middle, inertia = spread(forms, piece.mass)
        center = middle if center is None else center
    return Link(
        piece.name,
        piece.mass,
        inertia,
        ORIGIN if center is None else center,
        piece.turn,
        tuple(form.shape for form in forms if form.touches),
        [(form.color, seen(form)) for form in forms if len(form.mesh[0]) and not form.is_plain],
        piece.is_pad,
        folder,
        tuple((form.color, form.drawn) for form in forms if form.is_plain),
        DIGITS,
    )


def tcp(parent: str, xyz: Vec3, rpy: Vec3 = ORIGIN) -> tuple[Link, Joint]:
    """Return a frame without a body, and the joint that fixes it.

    PyBullet gives a link without an inertial a mass of 1 kg, so it says that it weighs next to
    nothing.
    """
    link = Link("tcp", 0.001, (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6))
    return link, Joint("tcp_joint", parent, "tcp", xyz, rpy)


def with_tcp(bare: Module, parent: str, xyz: Vec3, rpy: Vec3 = ORIGIN) -> Module:
    """Return a module with a tool centre point."""
    link, joint = tcp(parent, xyz, rpy)
    return Module((*bare.links, link), (*bare.joints, joint))


def mounted(
    arm: Module, gripper: Module, on: str, xyz: Vec3 = ORIGIN, rpy: Vec3 = ORIGIN
) -> Module:
    """Return an arm with a gripper fixed to one of its links."""
    joint = Joint("gripper_mount", on, gripper.links[0].name, xyz, rpy)
    return Module((*arm.links, *gripper.links), (*arm.joints, joint, *gripper.joints))


def robot_files(
    name: str, maker: str, materials: Mapping[str, Vec3], robot: Module
) -> dict[str, str]:
    """Return a robot's URDF and meshes by their paths relative to the folder of all robots.

    Args:
        name: Of the robot and its folder.
        maker: Who publishes the figures.
        materials: Colours by name; those that no link has are left out.
        robot: All of it.
    """
    note = (
        f"Written by robots/generate.py; change it there. Metres, kilograms, radians. Kinematics, "
        f"limits and masses are those that {maker} publishes; the shapes are this project's own."
    )
    used = {color for link in robot.links for color, _ in (*link.parts, *link.plain)}
    shown = {color: rgb for color, rgb in materials.items() if color in used}
    files = {f"{name}.urdf": robot_text(name, note, shown, robot.links, robot.joints)}
    for link in robot.links:
        files |= mesh_files(link)
    return {os.path.normpath(f"{name}/{path}"): text for path, text in files.items()}
