"""Whether what a task file says of the links and joints of its objects fits their URDFs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.errors import Finding
from taskbuilder.schema.joints import UNITS, JointSpec, Spring
from taskbuilder.schema.robots import beyond_limits
from taskbuilder.schema.scene import ObjectSpec, SceneSpec
from taskbuilder.schema.source import Path_, Source, dotted
from taskbuilder.wording import suggestion


def check_object(
    source: Source, name: str, thing: ObjectSpec, asset: Mesh | Urdf | None
) -> Iterator[Finding]:
    """What an object's grasp points and joints say that its URDF does not have.

    Args:
        source: The task file.
        name: The object.
        thing: What the file says of it.
        asset: Its mesh or URDF; None where it has none, or where it could not be read.
    """
    yield from _check_grasps(source, name, thing, asset)
    if isinstance(asset, Urdf):
        yield from _check_joints(source, name, thing, asset)


def locks(scene: SceneSpec) -> Iterator[tuple[Path_, str]]:
    """Path and name of every condition of the description that opens a joint's lock."""
    for name, thing in scene.objects.items():
        for joint, written in thing.joints.items():
            if isinstance(written, JointSpec) and written.lock is not None:
                path = ("scene", "objects", name, "joints", joint, "lock", "unless")
                yield path, written.lock.unless


def _check_grasps(
    source: Source, name: str, thing: ObjectSpec, asset: Mesh | Urdf | None
) -> Iterator[Finding]:
    for grasp, point in thing.grasps.items():
        path: Path_ = ("scene", "objects", name, "grasps", grasp, "link")
        if point.link is None:
            continue
        if thing.urdf is None:
            message = f"{name} is no URDF and has no links; leave link out"
            yield Finding("TB106", message, dotted(path), source.locate(path, key=True))
        elif isinstance(asset, Urdf) and point.link not in (links := [x.name for x in asset.links]):
            message = f'the URDF has no link "{point.link}"; '
            message += suggestion(point.link, links, what="it has")
            yield Finding("TB301", message, dotted(path), source.locate(path))


def _check_joints(source: Source, name: str, thing: ObjectSpec, urdf: Urdf) -> Iterator[Finding]:
    moving = {joint.name: joint for joint in urdf.moving_joints}
    size = (thing.shape.scale if thing.shape else None) or 1.0
    for key, written in thing.joints.items():
        path: Path_ = ("scene", "objects", name, "joints", key)
        if key not in moving:
            message = f'the URDF has no joint "{key}" that moves; '
            message += suggestion(key, moving, what="it has")
            yield Finding("TB301", message, dotted(path), source.locate(path, key=True))
            continue
        joint = _scaled(moving[key], size)
        wrong = list(_wrong_units(source, path, joint, written))
        yield from wrong or _beyond(source, path, joint, written)


def _scaled(joint: UrdfJoint, size: float) -> UrdfJoint:
    """A joint of a URDF that is loaded larger or smaller than it is written."""
    if joint.type != "prismatic" or joint.lower is None or joint.upper is None:
        return joint
    return replace(joint, lower=joint.lower * size, upper=joint.upper * size)


def _wrong_units(
    source: Source, path: Path_, joint: UrdfJoint, written: JointSpec | float
) -> Iterator[Finding]:
    """Keys in metres of a joint that turns, and in degrees of one that slides."""
    if not isinstance(written, JointSpec):
        return
    models: tuple[tuple[Path_, JointSpec | Spring | None], ...] = (
        (path, written),
        ((*path, "spring"), written.spring),
    )
    slides = joint.type == "prismatic"
    for place, model in models:
        for sliding, turning in UNITS.items():
            wrong, right = (turning, sliding) if slides else (sliding, turning)
            if getattr(model, wrong, None) is not None:
                how = f"slides; write {right}, in metres"
                how = how if slides else f"turns; write {right}, in degrees"
                at = (*place, wrong)
                location = source.locate(at, key=True)
                yield Finding("TB110", f"{joint.name} {how}", dotted(at), location)


def _beyond(
    source: Source, path: Path_, joint: UrdfJoint, written: JointSpec | float
) -> Iterator[Finding]:
    """Limits wider than those of the URDF, and a start outside the limits."""
    turns = joint.type != "prismatic"
    spec = JointSpec.of(written, turns=turns)
    suffix = "_deg" if turns else ""
    if spec.range is not None:
        place = (*path, f"limits{suffix}")
        problems = [p for bound in spec.range if (p := beyond_limits(joint, bound))]
        yield from _findings(source, place, problems[:1])
        if problems:
            return
        joint = replace(joint, lower=spec.range[0], upper=spec.range[1])
    if spec.begin is not None:
        place = (*path, f"start{suffix}") if isinstance(written, JointSpec) else path
        problem = beyond_limits(joint, spec.begin)
        yield from _findings(source, place, [problem] if problem else [])
    elif spec.range is not None and (problem := beyond_limits(joint, 0.0)):
        message = f"it starts at 0, and {problem}; write start{suffix}"
        yield from _findings(source, (*path, f"limits{suffix}"), [message])


def _findings(source: Source, path: Path_, problems: Sequence[str]) -> Iterator[Finding]:
    for problem in problems:
        yield Finding("TB302", problem, dotted(path), source.locate(path))
