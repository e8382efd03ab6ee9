"""Fingers that the engine cannot move: too light to press, or damped until they fly."""

from __future__ import annotations

from dataclasses import replace

from taskbuilder.assets.model import Urdf
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody, ImportedJoint, Link
from taskbuilder.world.grip_force import LIGHT_KG, most_damping, turned_inertia
from taskbuilder.world.robot_proposal import Proposal

_HEAVIER_KG = 0.02


def with_steady_fingers(
    description: ImportedBody, proposal: Proposal, urdf: Urdf, changes: Changes
) -> ImportedBody:
    """The description with fingers of some weight, and with less damping where it is too much.

    Args:
        description: With masses.
        proposal: What its gripper is.
        urdf: The same robot.
        changes: Where changes are noted.
    """
    links = {}
    for finger in proposal.fingers:
        group = description.rigid_group(finger[0])
        mass = sum(_mass(description.link(name)) for name in group)
        link = description.link(finger[0])
        slides = any(j.child in group and j.type == "prismatic" for j in description.joints)
        if slides and mass < LIGHT_KG and link.inertial is not None:
            links[link.name] = _heavier(link, _HEAVIER_KG - mass, changes)
    description = description.with_links(links)
    joints = tuple(
        _undamped(joint, description, urdf, changes) if joint.name in proposal.gripper else joint
        for joint in description.joints
    )
    return replace(description, joints=joints)


def _mass(link: Link) -> float:
    return link.inertial.mass if link.inertial is not None else 0.0


def _heavier(link: Link, more: float, changes: Changes) -> Link:
    before = link.inertial
    if before is None:
        return link
    mass = float(f"{before.mass + more:.4g}")
    moments = before.moments
    if moments is not None and before.mass > 0.0:
        moments = tuple(float(f"{value * mass / before.mass:.6g}") for value in moments)
    changes.note(
        f"link {link.name}", "mass", f"{before.mass:.4g} kg", f"{mass:.4g} kg",
        "lighter fingers that slide press with less than their motors exert",
    )  # fmt: skip
    return replace(link, inertial=replace(before, mass=mass, moments=moments))


def _undamped(
    joint: ImportedJoint, description: ImportedBody, urdf: Urdf, changes: Changes
) -> ImportedJoint:
    if joint.type == "prismatic":
        inertia = sum(_mass(description.link(n)) for n in description.rigid_group(joint.child))
        of_what, unit = f"{inertia * 1000:.3g} g", "N s/m"
    else:
        inertia = turned_inertia(urdf, urdf.joint(joint.name))
        of_what, unit = f"{inertia:.2g} kg·m²", "Nm s/rad"
    most = most_damping(inertia)
    if joint.damping <= 2.0 * most:
        return joint
    damping = float(f"{most:.2g}")
    changes.note(
        f"joint {joint.name}", "damping", f"{joint.damping:g} {unit}", f"{damping:g} {unit}",
        f"too much for {of_what}: the engine would make it fly",
    )  # fmt: skip
    return replace(joint, damping=damping)
