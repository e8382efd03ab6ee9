"""Where a finding about a built thing belongs: in the task file, or in the description."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from traceback import extract_tb

from taskbuilder.description import description as referee
from taskbuilder.description.load import explain
from taskbuilder.description.node import Node
from taskbuilder.errors import Finding, Location, Severity
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.source import dotted
from taskbuilder.task import Task


def finding_at(
    task: Task, code: str, message: str, name: str, *inner: str, severity: Severity = "error"
) -> Finding:
    """A finding about a robot, object or site, placed where the task file describes it.

    Args:
        task: The task.
        code: The finding's code.
        message: What is wrong; what would be right.
        name: Of the robot, object or site.
        inner: Keys below it, such as "place".
        severity: How bad it is.
    """
    scene = task.file.spec.scene
    groups = {"robots": scene.robots, "objects": scene.objects, "sites": scene.sites}
    group = next(group for group, things in groups.items() if name in things)
    path = ("scene", group, name, *inner)
    location = task.file.source.locate(path, key=not inner)
    return Finding(code, message, ".".join(path), location, severity)


def finding_of_scene(task: Task, code: str, message: str) -> Finding:
    """A finding about the scene as a whole."""
    return Finding(code, message, "scene", task.file.source.locate(("scene",), key=True))


def in_variation(
    variation: int, wrong: Iterable[Finding], known: Iterable[Finding]
) -> list[Finding]:
    """What is wrong in a variation and was not in those before it; its message names it."""
    before = {(finding.code, finding.path) for finding in known}
    new = [finding for finding in wrong if (finding.code, finding.path) not in before]
    if not variation:
        return new
    return [replace(found, message=f"in variation {variation}: {found.message}") for found in new]


def failure_of_description(error: BaseException, entry: CatalogueEntry) -> Finding:
    """A finding at the line of the description that raised an error while it was asked.

    Raises:
        BaseException: The same error, if the description has no part in it.
    """
    finding = _explained(error, entry)
    if finding is None:
        raise error
    return finding


def arose_in_description(error: BaseException, entry: CatalogueEntry) -> bool:
    """Whether a description has a part in an error."""
    return _explained(error, entry) is not None


def _explained(error: BaseException, entry: CatalogueEntry) -> Finding | None:
    what = "fails when it is asked"
    finding = explain(error, entry.description_file, "TB314", what)
    frames = extract_tb(error.__traceback__)
    if finding is None and any(frame.filename == referee.__file__ for frame in frames):
        # What it gave back could not be used.
        said = f"{type(error).__name__}: {error}".splitlines()[0]
        location = Location(entry.description_file, 1, 1)
        finding = Finding("TB314", f"{what}: {said}", location=location)
    return finding


def finding_in_description(
    task: Task, code: str, message: str, name: str, node: Node | None = None
) -> Finding:
    """A finding about an attribute of the description, placed where it was written.

    Args:
        task: The task.
        code: The finding's code.
        message: What is wrong; what would be right.
        name: Of the attribute, or of what belongs to it.
        node: The expression that is meant; its place is the finding's.
    """
    location = None if node is None else node.origin
    file = task.file.entry.description_file
    return Finding(code, message, name, location or Location(file, 1, 1))


def finding_in_file(
    task: Task, code: str, message: str, *path: str | int, severity: Severity = "error"
) -> Finding:
    """A finding about what the task file holds at a path, or about what is missing there."""
    location = task.file.source.locate(path, key=True)
    return Finding(code, message, dotted(path), location, severity)
