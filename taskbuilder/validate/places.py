"""Where a finding about a built thing belongs: in the task file, or in the description."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from taskbuilder.description.load import explain
from taskbuilder.errors import Finding, Severity
from taskbuilder.spec.catalogue import Entry
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


def failure_of_description(error: BaseException, entry: Entry) -> Finding:
    """A finding at the line of the description that raised an error while it was asked.

    Raises:
        BaseException: The same error, if the description has no part in it.
    """
    finding = explain(error, entry.description_file, "TB314", "fails when it is asked")
    if finding is None:
        raise error
    return finding
