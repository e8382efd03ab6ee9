"""Groups: one entry of a task file, with a ``count``, that stands for several objects.

A group ``cubes`` of three stands for the objects ``cubes_1``, ``cubes_2`` and ``cubes_3``. They are
positioned in the frame of their arrangement, a site with the name of the group. Everything that
comes after the task file was read has to do with ordinary objects and sites.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf
from taskbuilder.errors import Finding
from taskbuilder.geometry import Box, bounding_box, norm
from taskbuilder.schema.arrangement import MAX_COUNT, Outline
from taskbuilder.schema.expert import Repeat, Together
from taskbuilder.schema.names import SceneNames
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.order import Order
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.shapes import PartSpec, Shape
from taskbuilder.schema.sites import SiteSpec
from taskbuilder.schema.source import Path_, Source, dotted
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.values import RpyDeg, frozen

Assets = Mapping[str, Mesh | Urdf]
Thing = TypeVar("Thing")


def member_names(name: str, count: Any) -> tuple[str, ...]:
    """The objects that a group stands for; none if its count cannot be one."""
    countable = isinstance(count, int) and not isinstance(count, bool) and 1 <= count <= MAX_COUNT
    return tuple(f"{name}_{i + 1}" for i in range(count)) if countable else ()


def entries_of(names: SceneNames) -> dict[Path_, Path_]:
    """For a task file's `Source`: the entries of members, and of the frames of arrangements."""
    entries: dict[Path_, Path_] = {}
    for group, members in names.groups.items():
        entry = ("objects", group)
        entries |= {("sites", group): entry, **{("objects", one): entry for one in members}}
    return entries


def of_members(names: SceneNames, entries: Mapping[str, Thing]) -> dict[str, Thing]:
    """What belongs to every object, such as its mesh, from what belongs to the file's entries."""
    given = dict(entries)
    for group, members in names.groups.items():
        if group in given:
            given |= dict.fromkeys(members, given.pop(group))
    return given


def expanded(spec: TaskSpec, names: SceneNames, assets: Assets) -> TaskSpec:
    """A task with its groups written out.

    Args:
        spec: The task as it is in its file.
        names: The names of its scene.
        assets: Mesh or URDF of the file's objects.
    """
    if not names.groups:
        return spec
    scene = expanded_scene(spec.scene, names, assets)
    stages = tuple(_stage(stage, names) for stage in spec.expert)
    return spec.model_copy(update={"scene": scene, "expert": stages})


def expanded_scene(scene: SceneSpec, names: SceneNames, assets: Assets) -> SceneSpec:
    """A scene with its groups written out."""
    objects: dict[str, ObjectSpec] = {}
    sites = dict(scene.sites)
    for name, thing in scene.objects.items():
        if thing.count is None or thing.arrange is None:
            objects[name] = thing
            continue
        objects |= dict(zip(names.groups[name], _members(name, thing, assets), strict=True))
        sites[name] = _frame(thing)
    return scene.model_copy(update={"objects": frozen(objects), "sites": frozen(sites)})


def outline(thing: ObjectSpec, asset: Mesh | Urdf | None) -> Outline | None:
    """The room that an object takes; None for a URDF, whose joints move."""
    if thing.parts is not None:
        boxes = [_box(part).seen_from(part.pose) for part in thing.parts.values()]
        box = bounding_box([corner for each in boxes for corner in (each.low, each.high)])
    elif isinstance(asset, Mesh) and thing.shape is not None:
        size = thing.shape.scale or 1.0
        low, high = (tuple(size * x for x in end) for end in (asset.bounds.low, asset.bounds.high))
        box = Box.around((low[0], low[1], low[2]), (high[0], high[1], high[2]))
    elif thing.shape is not None and thing.shape.mesh is None and thing.urdf is None:
        box = _box(thing.shape)
        if thing.shape.sphere is not None:
            return Outline(box, 2.0 * thing.shape.sphere, upright_round=True)
        return Outline(box, 2.0 * norm(box.half), upright_round=thing.shape.box is None)
    else:
        return None
    return Outline(box, 2.0 * (norm(box.center) + norm(box.half)))


def _box(shape: Shape | PartSpec) -> Box:
    """Bounding box of a primitive in its own frame."""
    if shape.box is not None:
        x, y, z = shape.box
        return Box((0.0, 0.0, 0.0), (x / 2, y / 2, z / 2))
    if shape.sphere is not None:
        return Box((0.0, 0.0, 0.0), (shape.sphere,) * 3)
    round_ = shape.cylinder or shape.capsule
    if round_ is None:
        raise ValueError(f"{shape} is no primitive")
    ends = round_.radius if shape.capsule is not None else 0.0
    return Box((0.0, 0.0, 0.0), (round_.radius, round_.radius, round_.length / 2 + ends))


def check_arrangements(source: Source, scene: SceneSpec, assets: Assets) -> Iterator[Finding]:
    """Groups whose members overlap, or do not fit into their pile."""
    for name, thing in scene.objects.items():
        room = outline(thing, assets.get(name))
        if thing.arrange is None or thing.count is None or room is None:
            continue
        if problem := thing.arrange.problem(thing.count, _rpy_deg(thing), room):
            path = ("scene", "objects", name, "arrange")
            yield Finding("TB111", problem, dotted(path), source.locate(path, key=True))


def _rpy_deg(thing: ObjectSpec) -> RpyDeg:
    return thing.place.rpy_deg if thing.place is not None else thing.rpy_deg


def _members(name: str, thing: ObjectSpec, assets: Assets) -> Iterator[ObjectSpec]:
    """The members of a group; their roll and pitch are their own, the yaw is the arrangement's."""
    if thing.arrange is None or thing.count is None:
        raise ValueError(f"{name} is no group")
    room = outline(thing, assets.get(name))
    for position, rpy_deg in thing.arrange.places(thing.count, _rpy_deg(thing), room):
        own = {"position": position, "rpy_deg": rpy_deg, "frame": name}
        yield thing.model_copy(update={"place": None, **own})


def _frame(thing: ObjectSpec) -> SiteSpec:
    """The frame of an arrangement, which is where its group is put."""
    yaw = (0.0, 0.0, _rpy_deg(thing)[2])
    if thing.place is None:
        return SiteSpec.model_construct(
            position=thing.position, rpy_deg=yaw, frame=thing.frame, place=None
        )
    place = thing.place.model_copy(update={"rpy_deg": yaw})
    return SiteSpec.model_construct(place=place)


def _stage(stage: Any, names: SceneNames) -> Any:
    """A stage in which ``touching`` names single objects."""
    if isinstance(stage, Repeat):
        inner = tuple(_stage(each, names) for each in stage.stages)
        return stage.model_copy(update={"stages": inner})
    if isinstance(stage, Order | Together):
        touching = tuple(one for name in stage.touching for one in names.members(name) or (name,))
        return stage.model_copy(update={"touching": touching})
    if isinstance(stage, tuple):
        return tuple(_stage(order, names) for order in stage)
    if isinstance(stage, Mapping):
        return frozen({robot: _stage(order, names) for robot, order in stage.items()})
    return stage
