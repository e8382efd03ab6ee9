"""Whether the joints of objects can get to where the description wants them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from taskbuilder.assets.model import Urdf
from taskbuilder.description.joints import JointAngle, JointPosition
from taskbuilder.description.logic import Once, Simultaneous, Sustained, Then
from taskbuilder.description.node import AllOf, Condition, walk
from taskbuilder.errors import Finding, Severity
from taskbuilder.schema.articulation import limited
from taskbuilder.schema.joints import JointSpec
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.task import Task

SLACK = 1e-4
"""Distance in rad or m from a limit within which a bound counts as reached; degrees are rounded."""

_EVERY = (AllOf, Then, Simultaneous, Sustained, Once)
"""Conditions that come true only if each of their parts does at some time."""


def check_joint_bounds(task: Task) -> Iterator[Finding]:
    """Conditions that can never hold, because the limits of their joint forbid it.

    They are errors where success needs them, and warnings elsewhere.
    """
    needed = set(_needed(task.description.success))
    for node in walk(tuple(task.description.conditions().values())):
        if not isinstance(node, JointAngle | JointPosition):
            continue
        for number, scene in enumerate(task.file.scenes):
            if problem := _never(task, scene, node):
                where = f"in variation {number}, " if number else ""
                name = f'{type(node).__name__}("{node.joint}", …)'
                severity: Severity = "error" if node in needed else "warning"
                yield Finding("TB302", where + problem, name, node.origin, severity)
                break


def _needed(node: Condition) -> Iterator[Condition]:
    """What must hold at some time so that a condition comes true."""
    yield node
    if isinstance(node, _EVERY):
        for part in node.parts:
            if isinstance(part, Condition):
                yield from _needed(part)


def _never(task: Task, scene: SceneSpec, node: JointAngle | JointPosition) -> str | None:
    """Why a condition on a joint can never hold, with the limit and its place; None if it can."""
    owner, _, inner = node.joint.partition(".")
    thing, urdf = scene.objects[owner], task.file.assets.get(owner)
    if not isinstance(urdf, Urdf):
        return None
    joint = limited(urdf.joint(inner), thing)
    low, high = node.bounds
    if joint.lower is None or joint.upper is None:
        return None
    if low is not None and low > joint.upper + SLACK:
        wanted, limit, most = low, joint.upper, "most"
    elif high is not None and high < joint.lower - SLACK:
        wanted, limit, most = high, joint.lower, "least"
    else:
        return None
    turns = joint.type != "prismatic"
    wanted, limit = (math.degrees(v) if turns else v for v in (wanted, limit))
    unit = "°" if turns else " m"
    return (
        f"can never hold: it needs {wanted:.4g}{unit}, and {node.joint} is at {most} "
        f"{limit:.4g}{unit}, by {_place_of_limit(task, thing, owner, inner)}"
    )


def _place_of_limit(task: Task, thing: ObjectSpec, owner: str, inner: str) -> str:
    """The file and line that limits a joint; of a URDF, the file."""
    joint = thing.joint_key(inner)
    written = None if joint is None else thing.joints[joint]
    if joint is not None and isinstance(written, JointSpec) and written.range is not None:
        key = "limits" if written.limits is not None else "limits_deg"
        at = task.file.source.locate(("scene", "objects", owner, "joints", joint, key))
        if at is not None:
            return f"{at.file.name}:{at.line}"
    asset = task.file.assets[owner]
    return asset.path.name
