"""Where in the task file a finding about a built thing belongs."""

from __future__ import annotations

from taskbuilder.errors import Finding, Severity
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
