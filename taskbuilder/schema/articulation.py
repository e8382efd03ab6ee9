"""Whether what a task file says of the links and joints of its objects fits their URDFs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from taskbuilder.assets import codes
from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.errors import Finding
from taskbuilder.schema.expert import ExpertStage, each_order
from taskbuilder.schema.joints import UNITS, JointSpec, Spring
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.order import Order
from taskbuilder.schema.robots import beyond_limits
from taskbuilder.schema.scene import SceneSpec
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
        yield from _check_collisions(name, thing, asset)


def check_surfaces(
    source: Source, scene: SceneSpec, assets: Mapping[str, Mesh | Urdf]
) -> Iterator[Finding]:
    """Surfaces without collision shapes, through which everything falls.

    Args:
        source: The task file.
        scene: Its scene.
        assets: Meshes and URDFs of its objects.
    """
    for group, things in (("objects", scene.objects), ("sites", scene.sites)):
        for name, thing in things.items():
            surface = (thing.place.surface if thing.place else None) or ""
            owner, _, link = surface.partition(".")
            urdf = assets.get(owner)
            if not isinstance(urdf, Urdf) or (link and link not in [x.name for x in urdf.links]):
                continue
            links = [urdf.link(link)] if link else urdf.links
            if not any(each.collisions for each in links):
                path: Path_ = ("scene", group, name, "place", "surface")
                solid = [f"{owner}.{each.name}" for each in urdf.links if each.collisions]
                mend = f"name one that has: {', '.join(solid)}" if solid else _ADD
                message = f"{surface} has no collision shape, so nothing can stand on it; {mend}"
                yield Finding(codes.NO_COLLISION, message, dotted(path), source.locate(path))


_ADD = "add <collision> to a link of its URDF, usually with the geometry of <visual>"


def locks(scene: SceneSpec) -> Iterator[tuple[Path_, str]]:
    """Path and name of every condition of the description that opens a joint's lock."""
    for name, thing in scene.objects.items():
        for joint, written in thing.joints.items():
            if isinstance(written, JointSpec) and written.lock is not None:
                path = ("scene", "objects", name, "joints", joint, "lock", "unless")
                yield path, written.lock.unless


def pressed(urdf: Urdf, link: str) -> UrdfJoint | None:
    """The joint that moves when a link is pressed: the nearest above it, if that is prismatic.

    Args:
        urdf: The object.
        link: The link; "" for the object, of which the only prismatic joint moves.
    """
    if link:
        above = urdf.moving_joints_above(link)
        return above[0] if above and above[0].type == "prismatic" else None
    sliding = [joint for joint in urdf.moving_joints if joint.type == "prismatic"]
    return sliding[0] if len(sliding) == 1 else None


def check_orders(
    source: Source,
    stages: Sequence[ExpertStage],
    scene: SceneSpec,
    assets: Mapping[str, Mesh | Urdf],
) -> Iterator[Finding]:
    """Check the joints and postures that the expert's orders name.

    Args:
        source: The task file.
        stages: Its expert.
        scene: Its scene.
        assets: Meshes and URDFs of its objects.
    """
    for path, robot, order in each_order(stages):
        if order.posture is not None and robot in scene.robots:
            yield from _check_posture(source, (*path, "posture"), order.posture, scene, robot)
        if order.joint is not None:
            yield from _check_moved(source, path, order, scene, assets)
        elif order.press is not None and order.to is not None:
            yield from _check_pressed(source, path, order, scene, assets)


def _check_posture(
    source: Source, path: Path_, name: str, scene: SceneSpec, robot: str
) -> Iterator[Finding]:
    known = scene.robots[robot].postures
    if name in known:
        return
    has = suggestion(name, known, what="it has") if known else "it has none"
    message = f'{robot} has no posture "{name}"; {has}; write scene.robots.{robot}.postures'
    yield Finding("TB201", message, dotted(path), source.locate(path))


def _check_moved(
    source: Source, path: Path_, order: Order, scene: SceneSpec, assets: Mapping[str, Mesh | Urdf]
) -> Iterator[Finding]:
    name = order.joint or ""
    owner, _, inner = name.partition(".")
    asset = assets.get(owner)
    moving = {j.name: j for j in asset.moving_joints} if isinstance(asset, Urdf) else {}
    if inner not in moving:
        return  # which has been reported
    slides = moving[inner].type == "prismatic"
    if slides != (order.slide is not None):
        how = f"slides; write slide: {name}, and to in metres"
        how = how if slides else f"turns; write turn: {name}, and to_deg in degrees"
        place = (*path, order.verb)
        yield Finding("TB110", f"{name} {how}", dotted(place), source.locate(place, key=True))
        return
    key = "to" if slides else "to_deg"
    yield from _out_of_range(source, (*path, key), order, moving[inner], scene.objects[owner])


def _check_pressed(
    source: Source, path: Path_, order: Order, scene: SceneSpec, assets: Mapping[str, Mesh | Urdf]
) -> Iterator[Finding]:
    frame = order.press or ""
    while frame in scene.sites:
        frame = scene.sites[frame].frame
    owner, _, link = frame.partition(".")
    thing, asset = scene.objects.get(owner), assets.get(owner)
    if thing is not None and link in thing.grasps:
        link = thing.grasps[link].link or ""
    joint = pressed(asset, link) if isinstance(asset, Urdf) else None
    if thing is None or joint is None:
        place = (*path, "to")
        message = (
            f"{order.press} is not on one prismatic joint, so no position can be given; "
            "name a link that slides, or write depth, in metres"
        )
        yield Finding("TB106", message, dotted(place), source.locate(place, key=True))
        return
    yield from _out_of_range(source, (*path, "to"), order, joint, thing)


def _out_of_range(
    source: Source, path: Path_, order: Order, joint: UrdfJoint, thing: ObjectSpec
) -> Iterator[Finding]:
    position = order.joint_position
    problem = beyond_limits(limited(joint, thing), position) if position is not None else None
    yield from _findings(source, path, [problem] if problem else [])


def limited(joint: UrdfJoint, thing: ObjectSpec) -> UrdfJoint:
    """A joint with the limits that it has in the scene, by its object's scale and ``limits``."""
    joint = _scaled(joint, (thing.shape.scale if thing.shape else None) or 1.0)
    bounds = thing.joint(joint.name, turns=joint.type != "prismatic").range
    return joint if bounds is None else replace(joint, lower=bounds[0], upper=bounds[1])


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


def _check_collisions(name: str, thing: ObjectSpec, urdf: Urdf) -> Iterator[Finding]:
    """An object that nothing can touch, or a link of it that moves and can only be seen.

    What is fixed at a written position may be there to be looked at.
    """
    if not any(link.collisions for link in urdf.links):
        if not thing.fixed or thing.place is not None:
            message = f"{name} has no collision shape, so it cannot be placed and stand; {_ADD}"
            place = urdf.place_of(urdf.root)
            yield Finding(codes.NO_COLLISION, message, f"link {urdf.root}", place)
        return
    for joint in urdf.moving_joints:
        moved = [urdf.link(link) for link, _ in urdf.fixed_to(joint.child)]
        if any(link.visuals for link in moved) and not any(link.collisions for link in moved):
            message = f"it is seen and moves, and passes through everything; {_ADD}"
            place = urdf.place_of(joint.child)
            subject = f"link {joint.child}"
            yield Finding(codes.NO_COLLISION, message, subject, place, "warning")


def _check_joints(source: Source, name: str, thing: ObjectSpec, urdf: Urdf) -> Iterator[Finding]:
    moving = {joint.name: joint for joint in urdf.moving_joints}
    size = (thing.shape.scale if thing.shape else None) or 1.0
    for key, written in thing.joints.items():
        path: Path_ = ("scene", "objects", name, "joints", key)
        spoken_of = [joint for joint in moving if thing.joint_key(joint) == key]
        if not spoken_of:
            message = f'the URDF has no joint "{key}" that moves; '
            message += suggestion(key, moving, what="it has")
            yield Finding("TB301", message, dotted(path), source.locate(path, key=True))
        for own in spoken_of:
            joint = _scaled(moving[own], size)
            wrong = [
                *_led(source, path, joint, written),
                *_wrong_units(source, path, joint, written),
            ]
            yield from wrong or _beyond(source, path, joint, written)


def _scaled(joint: UrdfJoint, size: float) -> UrdfJoint:
    """A joint of a URDF that is loaded larger or smaller than it is written."""
    if joint.type != "prismatic" or joint.lower is None or joint.upper is None:
        return joint
    return replace(joint, lower=joint.lower * size, upper=joint.upper * size)


def _led(
    source: Source, path: Path_, joint: UrdfJoint, written: JointSpec | float
) -> Iterator[Finding]:
    """A start of a joint that follows another one."""
    spec = JointSpec.of(written, turns=joint.type != "prismatic")
    if joint.mimic is None or spec.begin is None:
        return
    message = (
        f"{joint.name} mimics {joint.mimic.joint}, and starts where that has it; "
        f"write the start of {joint.mimic.joint}"
    )
    yield Finding("TB106", message, dotted(path), source.locate(path, key=True))


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
    if spec.start_between is not None:
        problems = [p for start in spec.start_between if (p := beyond_limits(joint, start))]
        yield from _findings(source, (*path, f"start_range{suffix}"), problems[:1])
    elif spec.begin is not None:
        place = (*path, f"start{suffix}") if isinstance(written, JointSpec) else path
        problem = beyond_limits(joint, spec.begin)
        yield from _findings(source, place, [problem] if problem else [])
    elif spec.range is not None and (problem := beyond_limits(joint, 0.0)):
        message = f"it starts at 0, and {problem}; write start{suffix}"
        yield from _findings(source, (*path, f"limits{suffix}"), [message])


def _findings(source: Source, path: Path_, problems: Sequence[str]) -> Iterator[Finding]:
    for problem in problems:
        yield Finding("TB302", problem, dotted(path), source.locate(path))
