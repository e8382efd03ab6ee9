"""Other robots in place of those that a task file names.

The task file's data are read as if it named the other robot. What then does not fit, because it was
written for the joints of the robot before, falls back to the other robot's own home.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from taskbuilder.errors import UnknownNameError
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry, looks_like_path
from taskbuilder.schema.robots import RobotModel, beyond_limits, joint_values, load_robot
from taskbuilder.schema.source import Source
from taskbuilder.wording import suggestion

OtherRobots = Mapping[str, str]
"""Name of a robot in a scene -> name of another model, or path of its robot file."""


def absolute(robots: OtherRobots) -> dict[str, str]:
    """The same, with absolute paths, so that it can be recorded."""
    return {
        name: str(Path(model).expanduser().absolute()) if looks_like_path(model) else model
        for name, model in robots.items()
    }


def with_other_robots(
    source: Source, robots: OtherRobots, entry: CatalogueEntry, catalogue: Catalogue
) -> tuple[Source, dict[str, RobotModel]]:
    """A task file's data with other robots, and these.

    Args:
        source: Of the task file.
        robots: The other robots; paths are relative to the working directory.
        entry: The task.
        catalogue: Where names are looked up.

    Raises:
        UnknownNameError: The scene has no robot of a name, or there is no such model.
        FileError: A robot file has errors.
    """
    known = [name for name, _ in source.entries("scene", "robots")]
    models: dict[str, RobotModel] = {}
    data = dict(source.data)
    for name, reference in robots.items():
        if name not in known:
            help_ = suggestion(name, known, what="its robots")
            raise UnknownNameError(
                f'{name}={reference}: {entry.name} has no robot "{name}"; {help_}'
            )
        models[name] = model = _model(name, reference, entry, catalogue)
        written = source.get("scene", "robots", name)
        if isinstance(written, dict):
            changed = _fitted({**written, "model": reference}, model)
            data = _replaced(data, ("scene", "robots", name), changed)
    return replace(source, data=data), models


def _model(name: str, reference: str, entry: CatalogueEntry, catalogue: Catalogue) -> RobotModel:
    try:
        found = catalogue.robot(reference, Path())
    except UnknownNameError as error:
        raise UnknownNameError(f"{name}={reference}: {error}") from error
    return load_robot(found, (entry.root, *catalogue.folders))


def _fitted(robot: dict[str, Any], model: RobotModel) -> dict[str, Any]:
    """A robot's entry in which joint angles that the model cannot take are its home's instead."""
    home = robot.get("home")
    if isinstance(home, dict) and "joints_deg" in home and not _fits(home["joints_deg"], model):
        robot = {key: value for key, value in robot.items() if key != "home"}
    postures = robot.get("postures")
    if isinstance(postures, dict):
        robot = {**robot, "postures": {key: _posture(p, model) for key, p in postures.items()}}
    return robot


def _posture(posture: Any, model: RobotModel) -> Any:
    if not isinstance(posture, dict) or _fits(posture.get("joints_deg"), model):
        return posture
    return {**posture, "joints_deg": tuple(model.spec.home_deg)}


def _fits(written: Any, model: RobotModel) -> bool:
    """Whether joint angles are as many as an arm has joints, and within their limits."""
    if not isinstance(written, Sequence) or not all(isinstance(v, int | float) for v in written):
        return True  # the model of the file says what is wrong
    if len(written) != len(model.arm):
        return False
    values = joint_values(model.arm, written)
    return not any(map(beyond_limits, model.arm, values))


def _replaced(data: Any, path: tuple[str, ...], value: Any) -> Any:
    """The data with one value replaced; what is not on the way is shared."""
    if not path:
        return value
    return {**data, path[0]: _replaced(data[path[0]], path[1:], value)}
