"""The joints of a URDF, and the tree that they make of its links."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast, get_args

from taskbuilder.assets import codes
from taskbuilder.assets.links import as_vec3, read_pose
from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import JointType, UrdfJoint, UrdfMimic
from taskbuilder.assets.report import Report
from taskbuilder.assets.schema import number, numbers
from taskbuilder.geometry import Vec3, norm, unit
from taskbuilder.wording import quoted

_TYPES: tuple[str, ...] = get_args(JointType)
_LIMITED = ("revolute", "prismatic")
_DEFAULT_AXIS: Vec3 = (1.0, 0.0, 0.0)
_SHORTEST_AXIS = 1e-6
_MOST_TURNS = 6.0
"""Turns of a joint with limits; the arms that we know have at most two. More are degrees."""


def joint_moves(element: Element) -> bool:
    """Whether a ``<joint>`` lets its child move; a wrong type is reported elsewhere."""
    return element.get("type") != "fixed"


def read_joint(element: Element, report: Report) -> UrdfJoint | None:
    """A joint; None if it was reported as wrong in a way that leaves nothing to return."""
    name = element.get("name") or ""
    subject = f"joint {name}"
    parent = _end(element, "parent", subject, report)
    child = _end(element, "child", subject, report)
    kind = _type(element, subject, report)
    if kind is None:
        return None
    axis = _axis(element, kind, subject, report)
    lower, upper = _range(element, kind, subject, report)
    effort, velocity = _strength(element, kind, subject, report)
    return UrdfJoint(
        name,
        kind,
        parent,
        child,
        read_pose(element),
        axis,
        lower,
        upper,
        effort,
        velocity,
        _mimic(element, subject, report),
    )


def check_mimics(elements: Sequence[Element], report: Report) -> None:
    """Reports joints that mimic one that does not exist, is fixed, or is itself."""
    moving = {element.get("name") for element in elements if joint_moves(element)}
    for element in elements:
        mimic, name = element.first("mimic"), element.get("name")
        mimicked = mimic.get("joint") if mimic else None
        if mimic and mimicked and (mimicked not in moving or mimicked == name):
            message = f"mimics {quoted(mimicked)}, which is no other moving joint; name one"
            report.error(codes.JOINT, mimic, f"joint {name}", message)
        elif mimic and mimicked and name in _mimicked_by(mimicked, elements):
            message = f"mimics {quoted(mimicked)}, which mimics it; let one of them be free"
            report.error(codes.JOINT, mimic, f"joint {name}", message)


def _mimicked_by(name: str, elements: Sequence[Element]) -> list[str]:
    """The joints that a joint mimics, directly or by way of others."""
    named = {element.get("name"): element.first("mimic") for element in elements}
    followed: list[str] = []
    mimic = named.get(name)
    while mimic and (leader := mimic.get("joint")) and leader not in followed:
        followed.append(leader)
        mimic = named.get(leader)
    return followed


def _end(element: Element, tag: str, subject: str, report: Report) -> str:
    """The link that a joint names as its parent or child; "" if it names none."""
    end = element.first(tag)
    name = end.get("link") if end else None
    if not name:
        report.error(codes.JOINT, end or element, subject, f'needs <{tag} link="…"/>')
    return name or ""


def _type(element: Element, subject: str, report: Report) -> JointType | None:
    kind = element.get("type")
    if kind in _TYPES:
        return cast(JointType, kind)
    said = f"the type {quoted(kind)} is not supported" if kind else "has no type"
    report.error(codes.JOINT, element, subject, f"{said}; use one of {', '.join(_TYPES)}")
    return None


def _axis(element: Element, kind: JointType, subject: str, report: Report) -> Vec3:
    written = element.first("axis")
    axis = as_vec3(numbers(written, "xyz") or _DEFAULT_AXIS)
    if written and kind != "fixed" and norm(axis) < _SHORTEST_AXIS:
        report.error(codes.JOINT, written, subject, "the axis has no length; write such as 0 0 1")
    return unit(axis) if norm(axis) >= _SHORTEST_AXIS else _DEFAULT_AXIS


def _range(
    element: Element, kind: JointType, subject: str, report: Report
) -> tuple[float | None, float | None]:
    """The least and greatest position; None where there is none."""
    if kind not in _LIMITED:
        return (None, None)
    limit = element.first("limit")
    missing = [name for name in ("lower", "upper") if limit is None or limit.get(name) is None]
    if missing:
        message = f"a {kind} joint needs <limit {'=… '.join(missing)}=…/>"
        report.error(codes.LIMIT, limit or element, subject, message)
    lower, upper = number(limit, "lower"), number(limit, "upper")
    if limit and lower is not None and upper is not None and lower > upper:
        message = f"lower {lower:g} is above upper {upper:g}; exchange them"
        report.error(codes.LIMIT, limit, subject, message)
    elif limit and lower is not None and upper is not None and kind == "revolute":
        turns = (upper - lower) / math.tau
        if turns > _MOST_TURNS:
            message = (
                f"it turns from {lower:g} to {upper:g} rad, which are {turns:.0f} turns; write "
                "degrees as radians, and a joint that turns without end as continuous"
            )
            report.warning(codes.LIMIT, limit, subject, message)
    return (lower, upper)


def _strength(
    element: Element, kind: JointType, subject: str, report: Report
) -> tuple[float | None, float | None]:
    """The greatest effort and velocity; None where they are not given."""
    limit = element.first("limit")
    if limit is None or kind == "fixed":
        return (None, None)
    for name in ("effort", "velocity"):
        value = number(limit, name)
        if limit.get(name) is None:
            message = f"<limit> has no {name}, which Bullet takes for 0; write it"
            report.warning(codes.LIMIT, limit, subject, message)
        elif value is not None and value < 0:
            report.error(codes.LIMIT, limit, subject, f"{name} {value:g} is below 0")
    return (number(limit, "effort"), number(limit, "velocity"))


def _mimic(element: Element, subject: str, report: Report) -> UrdfMimic | None:
    mimic = element.first("mimic")
    if mimic is None:
        return None
    joint = mimic.get("joint")
    if not joint:
        report.error(codes.JOINT, mimic, subject, 'needs <mimic joint="…"/>')
        return None
    multiplier = number(mimic, "multiplier")
    if multiplier == 0.0:
        message = "mimics with a multiplier of 0, and so never moves; make it a fixed joint"
        report.error(codes.JOINT, mimic, subject, message)
        return None
    return UrdfMimic(joint, 1.0 if multiplier is None else multiplier, number(mimic, "offset") or 0)
