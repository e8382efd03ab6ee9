"""A task, whole: its file, its robots and assets, and its description."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.description.check import check_description
from taskbuilder.description.description import Description
from taskbuilder.description.load import load_description, try_import
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.expert import waits
from taskbuilder.schema.load import TaskFile, TaskFileError, read_task
from taskbuilder.schema.source import dotted
from taskbuilder.wording import suggestion


@dataclass(frozen=True)
class Task:
    """A task that has been found right.

    Attributes:
        file: What its YAML file holds and names.
        description: Success and reward.
        warnings: What is doubtful without keeping the task from being used.
    """

    file: TaskFile
    description: type[Description]
    warnings: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        """Its id."""
        return self.file.entry.name

    @property
    def agents(self) -> tuple[str, ...]:
        """The robots of the scene, in file order."""
        return tuple(self.file.spec.scene.robots)


def load_task(
    reference: str | Path, *, catalogue: Catalogue | None = None, guarded: bool = False
) -> Task:
    """Load a task by its name in the catalogue or by the path of its YAML file.

    A task is code: its Python file is imported.

    Args:
        reference: ``handover``, ``namespace/name``, or a path.
        catalogue: Where names are looked up; by default that of this installation.
        guarded: Import a description that is not in the catalogue in a child process first, so
            that one that hangs or dies becomes a finding.

    Raises:
        UnknownNameError: There is no task of that name.
        FileError: The task is wrong; with every finding.
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
            findings += _check_waits(file, description)
        findings += file.warnings if file is not None else ()
        if file is not None and not any(finding.severity == "error" for finding in findings):
            return Task(file, description, tuple(findings))
    raise FileError(findings)


def _check_waits(file: TaskFile, description: type[Description]) -> Iterator[Finding]:
    """Every condition that the expert waits for and that the description does not name."""
    known = description.conditions()
    for path, name in waits(file.spec.expert):
        if name not in known:
            message = f'"{name}" is no condition; {suggestion(name, known, what="it has")}'
            yield Finding("TB214", message, dotted(path), file.source.locate(path))


def _where(description: type[Description], entry: CatalogueEntry) -> Location:
    try:
        _, line = inspect.getsourcelines(description)
    except (OSError, TypeError):
        line = 1
    return Location(entry.description_file, line, 1)
