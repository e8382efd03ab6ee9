"""A loaded task: its file, its robots and assets, and its description."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from taskbuilder.description.check import check_description
from taskbuilder.description.description import Description, with_members
from taskbuilder.description.load import load_description, try_import
from taskbuilder.description.named import things_named
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.schema.articulation import locks
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.choices import GraspChoice, OtherRobots
from taskbuilder.schema.expert import waits
from taskbuilder.schema.grasping import with_grasp
from taskbuilder.schema.load import TaskFile, TaskFileError, read_task
from taskbuilder.schema.other_robots import other_robots, with_robots
from taskbuilder.schema.source import dotted
from taskbuilder.wording import suggestion


@dataclass(frozen=True)
class Task:
    """A loaded and checked task.

    Attributes:
        file: The contents of the YAML file, with the robots and assets that it uses.
        declared: The description class of the Python file.
        warnings: Findings that do not prevent the use of the task.
        robots: The models that it was loaded with in place of those of the task file, by robot.
        grasp: The rule of grasping that it was loaded with.
    """

    file: TaskFile
    declared: type[Description]
    warnings: tuple[Finding, ...] = ()
    robots: OtherRobots = ()
    grasp: GraspChoice = "task"

    def __repr__(self) -> str:
        stages = len(self.description.stages)
        return f"<Task {self.name}: {', '.join(self.agents)}; {_counted(stages, 'stage')}>"

    def __getstate__(self) -> dict[str, Any]:
        # Without the description: where it is made for the groups of a scene, no module has it.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def description(self) -> type[Description]:
        """The description class, with the groups of the scene written out, member by member."""
        return with_members(self.declared, self.file.names)

    @property
    def name(self) -> str:
        """The name of the task."""
        return self.file.entry.name

    @property
    def version(self) -> int:
        """The number of its version."""
        return self.file.spec.version

    @property
    def reference(self) -> str:
        """What it can be loaded by elsewhere: its name in an installed package, or its path."""
        entry = self.file.entry
        return entry.name if entry.module else str(entry.file)

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of the robots, in the order of the task file."""
        return tuple(self.file.spec.scene.robots)


def other_version(record: Mapping[str, Any], task: Task) -> str:
    """What is said of a file that was made with another version of a task; "" for the same.

    Args:
        record: What the file says; files from before there were versions are of version 1.
        task: The task as it is here.
    """
    there = record.get("task_version", 1)
    return "" if there == task.version else f"{there} there, and {task.version} here"


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


def load_task(
    reference: str | Path,
    *,
    catalogue: Catalogue | None = None,
    guarded: bool = False,
    robots: Mapping[str, str | Path] | None = None,
    grasp: GraspChoice = "task",
) -> Task:
    """Load a task by its name in the catalogue or by the path of its YAML file.

    A task is code: its Python file is imported.

    Args:
        reference: Name of the task, such as ``handover`` or ``namespace/name``, or path of its YAML
            file.
        catalogue: Catalogue in which to look up names; by default the catalogue of this
            installation.
        guarded: Whether to import the description in a child process first, so that an import that
            hangs or crashes is reported as a finding. For tasks in installed packages, this has no
            effect.
        robots: Models that replace those of the task file, by robot: ``{"left": "panda"}``. A model
            is a name in the catalogue, or the path of a robot file.
        grasp: How grippers with fingers hold objects: ``friction`` or ``attach``, or ``task`` for
            the rules in the task file.

    Raises:
        UnknownNameError: There is no task of this name, or ``robots`` names an unknown model.
        UsageError: ``robots`` names a robot that the scene does not have, or replaces a robot that
            the expert moves to a posture of the original model; or ``grasp`` is no rule, or one
            that no robot of the task can have.
        FileError: The files of the task have errors; the attribute ``findings`` lists them all.
    """
    catalogue = catalogue or Catalogue.discover()
    entry = catalogue.task(str(reference))
    findings: list[Finding] = []
    file = description = names = None
    try:
        file = read_task(entry, catalogue)
        names = file.names
    except TaskFileError as error:
        names = error.names
        findings += error.findings
        if any(finding.code == "TB001" for finding in findings):
            raise  # there is no task file: what lies beside it means nothing
    try:
        if guarded and not entry.module:
            try_import(entry)
        description = load_description(entry)
    except FileError as error:
        findings += error.findings
    if names is not None and description is not None:
        wrong = tuple(check_description(description, names, _where(description, entry)))
        findings += wrong
        if file is not None and not any(finding.code == "TB210" for finding in wrong):
            findings += _check_conditions(file, description)
        findings += file.warnings if file is not None else ()
        if file is not None and not any(finding.severity == "error" for finding in findings):
            models = other_robots(robots or {})
            file = with_grasp(with_robots(file, models, catalogue), grasp)
            full = with_members(description, file.names)
            about = things_named(full, file.spec.instructions, file.names)
            named = replace(file, named=about)
            return Task(named, description, tuple(findings), models, grasp)
    raise FileError(findings)


def _check_conditions(file: TaskFile, description: type[Description]) -> Iterator[Finding]:
    """Every condition that experts and locks go by and that the description does not name."""
    known = with_members(description, file.names).conditions()
    locked = dict.fromkeys(lock for scene in file.scenes for lock in locks(scene))
    for path, name in (*waits(file.spec.expert), *locked):
        if name not in known:
            message = f'"{name}" is no condition; {suggestion(name, known, what="it has")}'
            yield Finding("TB214", message, dotted(path), file.source.locate(path))


def _where(description: type[Description], entry: CatalogueEntry) -> Location:
    try:
        _, line = inspect.getsourcelines(description)
    except (OSError, TypeError):
        line = 1
    return Location(entry.description_file, line, 1)
