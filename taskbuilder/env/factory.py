"""Environments described by values, so that other processes can make them, too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.disturbances import disturbances
from taskbuilder.schema.other_robots import other_robots
from taskbuilder.task import Task, load_task


@dataclass(frozen=True)
class EnvFactory:
    """Makes the environment of a task; it can be pickled and compared.

    Attributes:
        task: Name or path of the task.
        catalogue: Where it is looked up.
        options: Options of the environment, by name.
    """

    task: str
    catalogue: Catalogue
    options: tuple[tuple[str, Any], ...] = ()

    @classmethod
    def of(
        cls,
        task: str | Path | Task,
        options: Mapping[str, Any],
        catalogue: Catalogue | None = None,
    ) -> EnvFactory:
        """The factory of a task; what a loaded task was loaded with, its environments have, too.

        Args:
            task: Name or path of the task, or the task itself.
            options: Options of the environment, by name; they go before those of a loaded task.
            catalogue: Where names are looked up; by default, the catalogue of a loaded task or of
                this installation.
        """
        if isinstance(task, Task):
            options = with_choices(task, options)
            catalogue = catalogue or task.file.catalogue
        plain = {name: _hashable(name, value) for name, value in options.items()}
        where = task.reference if isinstance(task, Task) else str(task)
        return cls(where, catalogue or Catalogue.discover(), tuple(plain.items()))

    def __call__(self, **more: Any) -> TaskEnv:
        """Make the environment, with more options if need be."""
        task = load_task(self.task, catalogue=self.catalogue)
        return parallel_env(task, **{**dict(self.options), **more})


def _hashable(name: str, value: Any) -> Any:
    if name == "robots":
        return other_robots(value)
    if name == "disturbances":
        return disturbances(value)
    return tuple(value) if isinstance(value, list) else value


def with_choices(task: Task, options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of an environment, with the robots and the grasping that a task was loaded with.

    Args:
        task: The task.
        options: Options by name; what they say themselves goes before, unless it is None.
    """
    chosen = {name: value for name, value in options.items() if value is not None}
    robots = {**dict(task.robots), **dict(other_robots(chosen.get("robots", ())))}
    if robots:
        chosen["robots"] = other_robots(robots)
    if task.grasp != "task":
        chosen.setdefault("grasp", task.grasp)
    return chosen
