"""Other models in the places of robots: a new value of the task file, with the rest unchanged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from taskbuilder.errors import UsageError
from taskbuilder.schema.agents import RobotEntry
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.schema.choices import OtherRobots
from taskbuilder.schema.expert import each_order
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.values import frozen
from taskbuilder.wording import suggestion


def other_robots(given: Mapping[str, str | Path] | Iterable[tuple[str, str | Path]]) -> OtherRobots:
    """The canonical form of a choice of robots: pairs sorted by name, with absolute paths.

    Args:
        given: A mapping from robots of a scene to models, or pairs of these.

    Raises:
        UsageError: It is neither.
    """
    models: dict[Any, Any]
    try:
        models = dict(given)
    except (TypeError, ValueError):
        models = {"": given}
    for name, model in models.items():
        if not (isinstance(name, str) and name and isinstance(model, str | Path)):
            raise UsageError(f'robots is {given!r}; a mapping such as {{"left": "panda"}}')
    return tuple(sorted((name, _reference(str(model))) for name, model in models.items()))


def _reference(model: str) -> str:
    """A model as options record it: a name, or a path that does not depend on the folder."""
    return str(Path(model).expanduser().resolve()) if looks_like_path(model) else model


def with_robots(file: TaskFile, robots: OtherRobots, catalogue: Catalogue) -> TaskFile:
    """Put other robots in the places of a scene's.

    Base, action mode and a home given as a tool's pose stay. Joint angles are of no use to another
    arm: a home given by them becomes the new model's own, and postures are dropped. So is what the
    scene says of grasping, for a model without fingers.

    Args:
        file: The task file.
        robots: The models, as `other_robots` makes them.
        catalogue: The catalogue that models are looked up in.

    Raises:
        UsageError: The scene has no such robot, or the expert names a posture of a replaced one.
        UnknownNameError: There is no such model.
        FileError: The files of a model have errors.
    """
    own = file.spec.scene.robots
    models: dict[str, RobotModel] = {}
    for name, reference in robots:
        if name not in own:
            help_ = suggestion(name, own, what="its robots are")
            raise UsageError(f'{file.entry.name} has no robot "{name}"; {help_}')
        model = load_robot(catalogue.robot(reference, Path()), catalogue.folders)
        if model.entry.file != file.robots[name].entry.file:
            models[name] = model
    _check_postures(file, models)
    references = {name: reference for name, reference in robots if name in models}
    spec, written = (
        each.model_copy(update={"scene": _changed(each.scene, references, models)})
        for each in (file.spec, file.written)
    )
    scenes = tuple(_changed(scene, references, models) for scene in file.scenes)
    return replace(
        file, spec=spec, written=written, scenes=scenes, robots={**file.robots, **models}
    )


def _check_postures(file: TaskFile, models: Mapping[str, RobotModel]) -> None:
    for _, name, order in each_order(file.spec.expert):
        if name in models and order.posture is not None:
            was = file.robots[name].name
            raise UsageError(
                f"{name} cannot be {models[name].name}: the expert sends it to the posture "
                f'"{order.posture}", which is given in joint angles of {was}; give the expert a '
                "pose of the tool instead"
            )


def _changed(
    scene: SceneSpec, references: Mapping[str, str], models: Mapping[str, RobotModel]
) -> SceneSpec:
    robots = {
        name: _replaced(entry, references[name], models[name]) if name in references else entry
        for name, entry in scene.robots.items()
    }
    return scene.model_copy(update={"robots": frozen(robots)})


def _replaced(entry: RobotEntry, reference: str, model: RobotModel) -> RobotEntry:
    keeps = entry.home is not None and entry.home.joints_deg is None
    update = {
        "model": reference,
        "home": entry.home if keeps else None,
        "postures": frozen({}),
        "grasp": entry.grasp if model.spec.gripper is not None else None,
    }
    return entry.model_copy(update=update)
