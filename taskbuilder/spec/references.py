"""Resolve the names in a task file.

Works on the file's plain data rather than on its model, so that wrong names are found in the same
run in which shapes are wrong.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from taskbuilder.errors import Finding
from taskbuilder.spec.channels import parse_channel
from taskbuilder.spec.expert import NOTHING, directed, kind_of_stage
from taskbuilder.spec.names import Kind, ObjectNames, SceneNames
from taskbuilder.spec.source import Path_, Source, dotted


@dataclass(frozen=True)
class _Reference:
    path: Path_
    name: str
    kind: Kind
    on_key: bool = False


def read_names(source: Source, articulated: dict[str, ObjectNames]) -> SceneNames:
    """The names that a task file introduces.

    Args:
        source: The task file.
        articulated: What is inside the objects that are URDFs.
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
        grasps = tuple(grasp for grasp, _ in source.entries("scene", "objects", name, "grasps"))
        objects[name] = ObjectNames(inside.parts, grasps, inside.joints, inside.unread)
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
    )


def check_names(source: Source, names: SceneNames) -> Iterator[Finding]:
    """Every name of a task file that is used twice, stands for nothing, or runs in a circle."""
    yield from _clashes(source)
    for reference in _references(source):
        if problem := names.problem(reference.kind, reference.name):
            location = source.locate(reference.path, key=reference.on_key)
            yield Finding("TB201", problem, dotted(reference.path), location)
    yield from _circles(source)
    yield from _channels(source, names)


def _clashes(source: Source) -> Iterator[Finding]:
    first: dict[str, Path_] = {}
    for group in ("robots", "objects", "sites", "cameras"):
        for name, _ in source.entries("scene", group):
            path: Path_ = ("scene", group, name)
            if name in first:
                message = f'"{name}" is also {dotted(first[name])}; every name stands for one thing'
                yield Finding("TB202", message, dotted(path), source.locate(path, key=True))
            first.setdefault(name, path)


def _references(source: Source) -> Iterator[_Reference]:
    for group in ("objects", "sites"):
        for name, _ in source.entries("scene", group):
            path: Path_ = ("scene", group, name)
            yield from _texts(source, (*path, "in"), "frame")
            yield from _texts(source, (*path, "place", "in"), "frame")
            yield from _texts(source, (*path, "place", "surface"), "surface")
    for name, _ in source.entries("scene", "cameras"):
        yield from _texts(source, ("scene", "cameras", name, "mount"), "frame")
    for block in ("observe", "observation_noise"):
        for robot, _ in source.entries(block):
            yield _Reference((block, robot), robot, "robot", on_key=True)
    stages = source.get("expert")
    for index in range(len(stages) if isinstance(stages, tuple) else 0):
        yield from _stage(source, ("expert", index))


def _texts(source: Source, path: Path_, kind: Kind) -> Iterator[_Reference]:
    """The reference at a path, or the references in the list there; none if it holds no text."""
    value = source.get(*path)
    if isinstance(value, str) and not (value == "world" and path[-1] == "in"):
        yield _Reference(path, value, kind)
    if isinstance(value, tuple):
        for index in range(len(value)):
            yield from _texts(source, (*path, index), kind)


_OPERANDS: dict[str, Kind] = {
    "grasp": "grasp",
    "bring": "object",
    "to": "frame",
    "reach": "frame",
    "close": "object",
    "touching": "object",
}


def _stage(source: Source, path: Path_) -> Iterator[_Reference]:
    stage = source.get(*path)
    kind = kind_of_stage(stage)
    if kind == "repeat":
        inner = source.get(*path, "stages")
        for index in range(len(inner) if isinstance(inner, tuple) else 0):
            yield from _stage(source, (*path, "stages", index))
    if kind == "together":
        yield from _texts(source, (*path, "together"), "robot")
        yield from _operands(source, path)
    if kind == "each" and isinstance(stage, dict):
        for robot in directed(stage):
            yield _Reference((*path, robot), robot, "robot", on_key=True)
            yield from _operands(source, (*path, robot))


def _operands(source: Source, path: Path_) -> Iterator[_Reference]:
    for key, kind in _OPERANDS.items():
        if (key, source.get(*path, key)) != ("close", NOTHING):
            yield from _texts(source, (*path, key), kind)


def _circles(source: Source) -> Iterator[Finding]:
    """Things whose position is given in a frame that is, in the end, given in theirs."""
    parents: dict[str, tuple[str, Path_]] = {}
    for group in ("objects", "sites"):
        for name, _ in source.entries("scene", group):
            for path in _frame_keys(group, name):
                value: Any = source.get(*path)
                if isinstance(value, str):
                    parents[name] = (value.partition(".")[0], path)
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
    if isinstance(problem, str):
        location = source.locate(path, key=path[0] == "observation_noise")
        yield Finding("TB204", problem, dotted(path), location)
