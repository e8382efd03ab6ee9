"""Locating findings about the built scene in the task file or the description."""

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
        name: Name of the robot, object or site.
        inner: Keys below it, such as "place".
        severity: Error or warning.
    """
    scene = task.file.spec.scene
    groups = {"robots": scene.robots, "objects": scene.objects, "sites": scene.sites}
    group = next(group for group, things in groups.items() if name in things)
    path = task.file.source.written(("scene", group, name, *inner))
    location = task.file.source.locate(path, key=not inner)
    return Finding(code, message, dotted(path), location, severity)


def finding_of_scene(task: Task, code: str, message: str) -> Finding:
    """A finding about the scene as a whole."""
    return Finding(code, message, "scene", task.file.source.locate(("scene",), key=True))


def in_variation(
    variation: int, wrong: Iterable[Finding], known: Iterable[Finding]
) -> list[Finding]:
    """Findings that are new in a variation, with its name in the message."""
    before = {(finding.code, finding.path) for finding in known}
    new = [finding for finding in wrong if (finding.code, finding.path) not in before]
    if not variation:
        return new
    return [replace(found, message=f"in variation {variation}: {found.message}") for found in new]


def failure_of_description(error: BaseException, entry: CatalogueEntry) -> Finding:
    """A finding for an error that a description raised, at the line that raised it.

    Raises:
        BaseException: The same error, if it did not arise in the description.
    """
    finding = in_description(error, entry)
    if finding is None:
        raise error
    return finding


def arose_in_description(error: BaseException, entry: CatalogueEntry) -> bool:
    """Whether an error arose in a description."""
    return in_description(error, entry) is not None


def in_description(error: BaseException, entry: CatalogueEntry) -> Finding | None:
    """A finding for an error that a description raised; None for any other error."""
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
    task: Task,
    code: str,
    message: str,
    name: str,
    node: Node | None = None,
    *,
    severity: Severity = "error",
) -> Finding:
    """A finding about an attribute of the description, at the line where it was written.

    Args:
        task: The task.
        code: The finding's code.
        message: What is wrong; what would be right.
        name: Name of the attribute, or of a part of it.
        node: The expression, which gives the place of the finding.
        severity: Error or warning.
    """
    location = None if node is None else node.origin
    file = task.file.entry.description_file
    return Finding(code, message, name, location or Location(file, 1, 1), severity)


def finding_in_file(
    task: Task, code: str, message: str, *path: str | int, severity: Severity = "error"
) -> Finding:
    """A finding about a path of keys in the task file, or about a missing key there."""
    location = task.file.source.locate(path, key=True)
    return Finding(code, message, dotted(path), location, severity)
