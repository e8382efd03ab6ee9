"""Variations and randomisation: the same scene with some values changed.

A change is written ``thing.key: value`` (``stick.color: green``, ``stick.place.center: [0, 0]``).
The changed scene goes through the same model and the same name check as the plain one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from taskbuilder.errors import Finding
from taskbuilder.schema.explain import parse
from taskbuilder.schema.names import SceneNames
from taskbuilder.schema.references import check_names
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.source import Path_, Source, dotted
from taskbuilder.schema.task import Distribution, TaskSpec
from taskbuilder.wording import suggestion

_GROUPS = ("robots", "objects", "sites", "cameras")

RANDOMIZABLE = ("mass", "friction", "rolling_friction", "restitution", "color")
"""What can be drawn anew each episode: a change that needs no new body."""

DRIVES: Mapping[str, float] = {"gains": 1.0, "delay": 0}
"""What of robots can be drawn anew each episode, and how it is in the task as written.

``gains`` is a factor of the position gain of the arm's motors, ``delay`` the number of control
steps after which actions are carried out.
"""

GREATEST_GAIN, LONGEST_DELAY = 2.0, 50


class _BadChange(Exception):  # noqa: N818  # carries a sentence from one function to the next
    pass


def read_variations(
    source: Source, names: SceneNames, plain: SceneSpec
) -> tuple[list[SceneSpec], list[Finding]]:
    """The varied scenes of a task file, in order, and what is wrong with them."""
    scenes: list[SceneSpec] = []
    findings: list[Finding] = []
    listed = source.get("variations")
    for index, changes in enumerate(listed if isinstance(listed, tuple) else ()):
        if not isinstance(changes, dict):
            continue  # the model has already said so
        scene, wrong = _changed(source, names, ("variations", index), changes)
        findings += wrong
        if scene is None:
            continue
        scenes.append(scene)
        path: Path_ = ("variations", index)
        if _counts(scene) != _counts(plain):
            message = "changes count; a variation changes values, not how many objects there are"
            findings.append(Finding("TB205", message, dotted(path), source.locate(path)))
        if _files(scene) != _files(plain):
            message = "names another model, mesh or urdf; a variation changes values, not files"
            findings.append(Finding("TB205", message, dotted(path), source.locate(path)))
    return scenes, findings


def _files(scene: SceneSpec) -> tuple[object, ...]:
    """What a scene refers to outside the task file."""
    models = tuple(robot.model for robot in scene.robots.values())
    shapes = (thing.shape for thing in scene.objects.values() if thing.shape)
    named = tuple(thing.object for thing in scene.objects.values())
    return (models, named, *((shape.mesh, shape.urdf, shape.collision) for shape in shapes))


def _counts(scene: SceneSpec) -> dict[str, int | None]:
    return {name: thing.count for name, thing in scene.objects.items()}


def check_randomize(source: Source, names: SceneNames, spec: TaskSpec) -> Iterator[Finding]:
    """What is wrong with the quantities to be randomised and with the values they may take."""
    for key, distribution in spec.randomize.items():
        path: Path_ = ("randomize", key)
        thing, _, quantity = key.partition(".")
        if quantity and any(thing in owner for owner in _owners(names)):
            allowed = _randomizable(thing, names)
            if quantity not in allowed:
                help_ = "only what objects, sites and robots have can be"
                if allowed:
                    help_ = suggestion(quantity, allowed, what=f"of {thing}, these can")
                message = f'"{key}" cannot be randomised; {help_}'
                yield Finding("TB205", message, dotted(path), source.locate(path, key=True))
                continue
        if quantity in DRIVES and thing in names.robots:
            if problem := _drive_problem(quantity, distribution):
                yield Finding("TB205", problem, dotted(path), source.locate(path))
            continue
        for value in distribution.uniform or distribution.choice or ():
            _, wrong = _changed(source, names, ("randomize",), {key: value})
            yield from wrong
            if wrong:
                break


def _randomizable(thing: str, names: SceneNames) -> tuple[str, ...]:
    if thing in names.entries:
        return RANDOMIZABLE
    if thing in names.robots:
        return tuple(DRIVES)
    return ("color",) if thing in names.sites else ()


def _drive_problem(quantity: str, distribution: Distribution) -> str | None:
    """What is wrong with the gains or the delays that may be drawn for a robot, or None."""
    if quantity == "gains":
        for value in distribution.uniform or distribution.choice or ():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0.0 < value <= GREATEST_GAIN:
                return f"{value!r} is no factor for gains; above 0 to {GREATEST_GAIN:g}"
        return None
    if distribution.uniform is not None:
        return "a delay is a whole number of control steps; write choice: [0, 1, 2]"
    for value in distribution.choice or ():
        if type(value) is not int or not 0 <= value <= LONGEST_DELAY:
            return f"{value!r} is no delay; a whole number of control steps, 0 to {LONGEST_DELAY}"
    return None


def _changed(
    source: Source, names: SceneNames, path: Path_, changes: Mapping[str, Any]
) -> tuple[SceneSpec | None, list[Finding]]:
    """The scene with some values changed; findings point at the changes that caused them."""
    scene = source.get("scene")
    for key, value in changes.items():
        try:
            scene = _replaced(scene, _scene_path(key, names), value)
        except _BadChange as problem:
            place = (*path, key)
            location = source.locate(place, key=True)
            return None, [Finding("TB205", str(problem), dotted(place), location)]
    varied = Source(source.file, scene, {}, {})
    spec, wrong = parse(SceneSpec, varied)
    if spec is not None:
        known = {(finding.path, finding.message) for finding in check_names(source, names)}
        found = check_names(Source(source.file, {"scene": scene}, {}, {}), names)
        wrong = tuple(f for f in found if (f.path, f.message) not in known)
    return spec, [_blame(finding, source, names, path, changes) for finding in wrong]


def _scene_path(key: str, names: SceneNames) -> tuple[str, ...]:
    thing, *inner = key.split(".")
    owners = _owners(names)
    for group, owner in zip(_GROUPS, owners, strict=True):
        if thing in owner and inner:
            return (group, thing, *inner)
    if not inner:
        raise _BadChange(f'"{key}" names no value; write thing.key, such as stick.color')
    for group, members in names.groups.items():
        if thing in members:
            advice = f"change all of them: {'.'.join((group, *inner))}"
            raise _BadChange(f'"{thing}" is one of the group "{group}"; {advice}')
    known = [name for owner in owners for name in owner]
    help_ = suggestion(thing, known, what="it has")
    raise _BadChange(f'the scene has no "{thing}"; {help_}')


def _owners(names: SceneNames) -> tuple[Iterable[str], ...]:
    """The names that changes may begin with, section by section."""
    return (names.robots, names.entries, names.sites, names.cameras)


def _replaced(data: Any, path: tuple[str, ...], value: Any) -> Any:
    """The data with one value replaced or added; what is not on the way is shared."""
    if not path:
        return value
    inner = data if isinstance(data, dict) else {}
    return {**inner, path[0]: _replaced(inner.get(path[0]), path[1:], value)}


def _blame(
    finding: Finding,
    source: Source,
    names: SceneNames,
    path: Path_,
    changes: Mapping[str, Any],
) -> Finding:
    """The finding, moved from the varied scene to the change that caused it."""
    for key in changes:
        where = ".".join(_scene_path(key, names))
        if finding.path.removeprefix("scene.").startswith(where):
            place = (*path, key)
            return Finding(
                finding.code, finding.message, dotted(place), source.locate(place), finding.severity
            )
    key = next(iter(changes))
    return finding.at(source.locate((*path, key)))
