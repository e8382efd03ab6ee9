"""Resolve the names in a task file.

Works on the file's plain data rather than on its model, so that wrong names are found in the same
run in which shapes are wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from types import MappingProxyType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from taskbuilder.errors import Finding, Fix
from taskbuilder.schema.bodies import BodySpec
from taskbuilder.schema.channels import parse_channel
from taskbuilder.schema.expert import STAGES, ExpertStage, directed, kind_of_stage
from taskbuilder.schema.groups import member_names
from taskbuilder.schema.names import NameProblem, ObjectNames, Refers, SceneNames
from taskbuilder.schema.order import Order
from taskbuilder.schema.source import Path_, Source, dotted
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.values import Model


@dataclass(frozen=True)
class _Reference:
    path: Path_
    name: str
    refers: Refers
    on_key: bool = False


def read_names(
    source: Source,
    articulated: Mapping[str, ObjectNames],
    handless: tuple[str, ...] = (),
    bodies: Mapping[str, BodySpec] = MappingProxyType({}),
) -> SceneNames:
    """The names that a task file introduces.

    Args:
        source: The task file.
        articulated: What is inside the objects that are URDFs.
        handless: The robots that have no gripper.
        bodies: What is known of the objects that are in the catalogue.
    """
    objects = {
        name: articulated.get(name)
        or ObjectNames(
            parts=tuple(part for part, _ in source.entries("scene", "objects", name, "parts")),
            unread=source.get("scene", "objects", name, "shape", "urdf") is not None,
        )
        for name, _ in source.entries("scene", "objects")
    }
    for name, inside in objects.items():
        own = tuple(grasp for grasp, _ in source.entries("scene", "objects", name, "grasps"))
        objects[name] = replace(inside, grasps=own)
        if name in bodies:
            body = bodies[name]
            grasps = tuple(dict.fromkeys((*body.grasps, *own)))
            parts = inside.parts or tuple(body.parts or ())
            objects[name] = replace(inside, parts=parts, grasps=grasps)
        elif source.get("scene", "objects", name, "object") is not None:
            objects[name] = replace(objects[name], unread=True)
    groups = {
        name: member_names(name, source.get("scene", "objects", name, "count"))
        for name in objects
        if source.get("scene", "objects", name, "count") is not None
    }
    objects = {one: inside for name, inside in objects.items() for one in groups.get(name, (name,))}
    return SceneNames(
        robots=tuple(name for name, _ in source.entries("scene", "robots")),
        objects=objects,
        sites={
            name: source.get("scene", "sites", name, "marker") is not None
            for name, _ in source.entries("scene", "sites")
        },
        cameras=tuple(
            ("front",)
            if source.get("scene", "cameras") is None
            else (name for name, _ in source.entries("scene", "cameras"))
        ),
        groups=groups,
        handless=handless,
    )


def check_names(source: Source, names: SceneNames) -> Iterator[Finding]:
    """Every name of a task file that is used twice, stands for nothing, or runs in a circle."""
    yield from _clashes(source, names)
    yield from _shadowed(source, names)
    for reference in _references(TaskSpec, source.data):
        refers = reference.refers
        if problem := names.problem(refers.kind, reference.name, several=refers.several):
            location = source.locate(reference.path, key=reference.on_key)
            fix = Fix(location, reference.name, problem.meant) if problem.meant else None
            path = dotted(reference.path)
            yield Finding("TB201", problem.message, path, location, fix=fix)
    yield from _circles(source, names)
    yield from _channels(source, names)


def _clashes(source: Source, names: SceneNames) -> Iterator[Finding]:
    first: dict[str, Path_] = {}
    for group in ("robots", "objects", "sites", "cameras"):
        for name, _ in source.entries("scene", group):
            path: Path_ = ("scene", group, name)
            for one in (name, *names.groups.get(name, ())):
                if one in first:
                    message = (
                        f'"{one}" is also {dotted(first[one])}; every name stands for one thing'
                    )
                    location = source.locate(path, key=True)
                    yield Finding("TB202", message, dotted(path), location)
                first.setdefault(one, path)


def _shadowed(source: Source, names: SceneNames) -> Iterator[Finding]:
    """Grasp points named as a link of their object, which may be somewhere else."""
    for name, _ in source.entries("scene", "objects"):
        first = next(iter(names.groups.get(name, (name,))), None)
        articulated = source.get("scene", "objects", name, "shape", "urdf") is not None
        if first is None or not (articulated or source.get("scene", "objects", name, "object")):
            continue
        inside = names.objects[first]
        for grasp in inside.grasps:
            if grasp in inside.parts:
                path: Path_ = ("scene", "objects", name, "grasps", grasp)
                message = f'"{grasp}" is also a link of {name}; every name stands for one thing'
                yield Finding("TB202", message, dotted(path), source.locate(path, key=True))


def _references(hint: Any, value: Any, path: Path_ = ()) -> Iterator[_Reference]:
    """The references in a value, as the annotations of its model tell; its shape may be wrong."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        refers = next((extra for extra in inner if isinstance(extra, Refers)), None)
        if refers:
            yield from _texts(refers, value, path)
        elif hint == ExpertStage:
            yield from _stage(value, path)
        else:
            yield from _references(inner[0], value, path)
    elif origin in (Union, UnionType):
        for member in inner:
            yield from _references(member, value, path)
    elif origin is tuple:
        for place, item in _items(value, path):
            yield from _references(inner[0], item, place)
    elif origin is Mapping and isinstance(value, dict):
        for key, held in value.items():
            for refers in get_args(inner[0]):
                if isinstance(refers, Refers):
                    yield _Reference((*path, key), key, refers, on_key=True)
            yield from _references(inner[1], held, (*path, key))
    elif isinstance(hint, type) and issubclass(hint, Model) and isinstance(value, dict):
        for key, annotation in _annotations(hint).items():
            if key in value:
                yield from _references(annotation, value[key], (*path, key))


@cache
def _annotations(model: type[Model]) -> dict[str, Any]:
    """The annotation of each key of a model."""
    hints = get_type_hints(model, include_extras=True)
    return {field.alias or name: hints[name] for name, field in model.model_fields.items()}


def _stage(stage: Any, path: Path_) -> Iterator[_Reference]:
    """The references in a stage, which is taken for what it seems meant to be."""
    if model := STAGES.get(kind_of_stage(stage)):
        yield from _references(model, stage, path)
    elif isinstance(stage, dict):
        for robot in directed(stage):
            yield _Reference((*path, robot), robot, Refers("robot"), on_key=True)
            for place, order in _items(stage[robot], (*path, robot)):
                found = _references(Order, order, place)
                in_metres = isinstance(order, dict) and not {"slide", "press"}.isdisjoint(order)
                yield from (ref for ref in found if not in_metres or ref.path[-1] != "to")


def _texts(refers: Refers, value: Any, path: Path_) -> Iterator[_Reference]:
    """The reference that a value is, or those in a list; none if it holds no text."""
    if isinstance(value, tuple):
        for place, item in _items(value, path):
            yield from _texts(refers, item, place)
    elif isinstance(value, str) and value != refers.besides:
        yield _Reference(path, value, refers)


def _items(value: Any, path: Path_) -> Iterator[tuple[Path_, Any]]:
    """The items of a list and where they are; what is no list counts as an item by itself."""
    if not isinstance(value, tuple):
        yield path, value
        return
    for index, item in enumerate(value):
        yield (*path, index), item


def _circles(source: Source, names: SceneNames) -> Iterator[Finding]:
    """Things whose position is given in a frame that is, in the end, given in theirs."""
    entry = {one: group for group, members in names.groups.items() for one in members}
    parents: dict[str, tuple[str, Path_]] = {}
    for group in ("objects", "sites"):
        for name, _ in source.entries("scene", group):
            for path in _frame_keys(group, name):
                value: Any = source.get(*path)
                if isinstance(value, str):
                    owner = value.partition(".")[0]
                    parents[name] = (entry.get(owner, owner), path)
    reported: set[str] = set()
    for name in parents:
        chain = [name]
        while chain[-1] in parents and parents[chain[-1]][0] not in chain:
            chain.append(parents[chain[-1]][0])
        closes = chain[-1] in parents and parents[chain[-1]][0] == name
        if closes and not reported & set(chain):
            reported |= set(chain)
            path = parents[name][1]
            message = f"runs in a circle: {' in '.join([*chain, name])}; give one a world position"
            yield Finding("TB203", message, dotted(path), source.locate(path))


def _frame_keys(group: str, name: str) -> tuple[Path_, ...]:
    path: Path_ = ("scene", group, name)
    return ((*path, "in"), (*path, "place", "in"), (*path, "place", "surface"))


def _channels(source: Source, names: SceneNames) -> Iterator[Finding]:
    for robot, listed in source.entries("observe"):
        if robot not in names.robots:
            continue  # which has been reported; "self" would mean nothing
        for index, text in enumerate(listed if isinstance(listed, tuple) else ()):
            yield from _channel(source, names, ("observe", robot, index), text, robot)
    for robot, _ in source.entries("observation_noise"):
        if robot not in names.robots:
            continue
        for text, _ in source.entries("observation_noise", robot):
            yield from _channel(source, names, ("observation_noise", robot, text), text, robot)
    state = source.get("state")
    for index, text in enumerate(state if isinstance(state, tuple) else ()):
        if text != "all":
            yield from _channel(source, names, ("state", index), text, None)


def _channel(
    source: Source, names: SceneNames, path: Path_, text: Any, agent: str | None
) -> Iterator[Finding]:
    if not isinstance(text, str):
        return
    problem = parse_channel(text, agent, names)
    if isinstance(problem, NameProblem):
        location = source.locate(path, key=path[0] == "observation_noise")
        fix = Fix(location, text, problem.meant) if problem.meant else None
        yield Finding("TB204", problem.message, dotted(path), location, fix=fix)
