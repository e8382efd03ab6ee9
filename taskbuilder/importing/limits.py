"""Efforts and speeds that a source leaves out or writes as 0."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

from taskbuilder.geometry import ORIGIN, Pose, norm
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody, ImportedJoint

SPEED_RAD_S, SPEED_M_S = 2.0, 0.2
_GRAVITY = 9.81
_SPARE = 2.5  # times what gravity asks for with the arm stretched out
_SLACK = 1e-3
_LEAST_NM, _LEAST_N = 1.0, 20.0


def with_limits(description: ImportedBody, changes: Changes) -> ImportedBody:
    """The description with an effort and a speed above 0 for every joint that moves."""
    return replace(
        description, joints=tuple(_limited(j, description, changes) for j in description.joints)
    )


def with_followers(description: ImportedBody, changes: Changes) -> ImportedBody:
    """The description with limits of mimic joints that allow what they mimic.

    Makers get the signs of followers wrong, and no program of theirs looks at their limits.
    """
    named = {joint.name: joint for joint in description.joints}
    joints = []
    for joint in description.joints:
        leader = named.get(joint.mimic.joint) if joint.mimic else None
        ends = (leader.lower, leader.upper) if leader else (None, None)
        if joint.mimic is None or None in ends or joint.lower is None or joint.upper is None:
            joints.append(joint)
            continue
        follows = [joint.mimic.multiplier * (end or 0.0) + joint.mimic.offset for end in ends]
        low, high = min(joint.lower, *follows), max(joint.upper, *follows)
        if low < joint.lower - _SLACK or high > joint.upper + _SLACK:
            changes.note(
                f"joint {joint.name}", "limits", f"{joint.lower:.4g} to {joint.upper:.4g}",
                f"{low:.4g} to {high:.4g}", f"they exclude what it mimics of {joint.mimic.joint}",
            )  # fmt: skip
            joint = replace(joint, lower=low, upper=high)
        joints.append(joint)
    return replace(description, joints=tuple(joints))


def _limited(joint: ImportedJoint, description: ImportedBody, changes: Changes) -> ImportedJoint:
    if not joint.moves:
        return joint
    subject = f"joint {joint.name}"
    slides = joint.type == "prismatic"
    if joint.lower is not None and joint.lower == joint.upper:
        changes.note(subject, "type", joint.type, "fixed", f"its limits are both {joint.lower:g}")
        return held(joint, joint.lower)
    if not joint.velocity:
        speed = SPEED_M_S if slides else SPEED_RAD_S
        unit = "m/s" if slides else "rad/s"
        changes.note(subject, "velocity", _said(joint.velocity), f"{speed:g} {unit}", "a default")
        joint = replace(joint, velocity=speed)
    if not joint.effort:
        effort = _needed(joint, description)
        unit = "N" if slides else "Nm"
        changes.note(
            subject, "effort", _said(joint.effort), f"{effort:g} {unit}",
            f"{_SPARE:g} times what the masses beyond it weigh, stretched out",
        )  # fmt: skip
        joint = replace(joint, effort=effort)
    return joint


def held_as_unused(
    description: ImportedBody, joints: Collection[str], changes: Changes, reason: str
) -> ImportedBody:
    """The description with some joints fixed, at zero or as near to it as they get.

    Args:
        description: It.
        joints: Names of the joints; those that do not move are left as they are.
        changes: Where changes are noted.
        reason: Why they are fixed.
    """
    kept = []
    for joint in description.joints:
        if joint.name in joints and joint.moves:
            position = 0.0
            if joint.lower is not None and joint.upper is not None:
                position = min(max(0.0, joint.lower), joint.upper)
            changes.note(
                f"joint {joint.name}", "type", joint.type, f"fixed at {position:g}", reason
            )
            joint = held(joint, position)
        kept.append(joint)
    return replace(description, joints=tuple(kept))


def held(joint: ImportedJoint, position: float) -> ImportedJoint:
    """A joint that is fixed at a position, in rad or m."""
    x, y, z = joint.axis
    if joint.type == "prismatic":
        moved = Pose((x * position, y * position, z * position))
    else:
        sine = math.sin(position / 2.0)
        moved = Pose(ORIGIN, (x * sine, y * sine, z * sine, math.cos(position / 2.0)))
    return replace(
        joint, type="fixed", pose=joint.pose @ moved, lower=None, upper=None, effort=None,
        velocity=None, damping=0.0, friction=0.0, mimic=None,
    )  # fmt: skip


def _needed(joint: ImportedJoint, description: ImportedBody) -> float:
    """The force or torque that gravity asks for beyond a joint, and some more."""
    slides = joint.type == "prismatic"
    total = 0.0
    pending = [(joint.child, 0.0)]
    while pending:
        link, away = pending.pop()
        inertial = description.link(link).inertial
        if inertial is not None:
            arm = away + norm(inertial.pose.position)
            total += inertial.mass * _GRAVITY * (1.0 if slides else arm)
        pending += [
            (other.child, away + norm(other.pose.position))
            for other in description.joints
            if other.parent == link
        ]
    return float(f"{max(_SPARE * total, _LEAST_N if slides else _LEAST_NM):.2g}")


def _said(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"
