"""A check of the validator: movable objects can be told apart by their colours."""

from __future__ import annotations

from collections.abc import Iterator

from taskbuilder.diagnostics import Code, Example
from taskbuilder.diagnostics.foreign import CheckFamily
from taskbuilder.errors import Finding
from taskbuilder.schema.values import rgb
from taskbuilder.task import Task
from taskbuilder.validate.report import Check

CODES = {
    "EXT101": Code(
        "Same colour",
        "Two movable objects have the same colour, so that a policy that sees pictures may not "
        "tell them apart.",
        Example(
            "task",
            "scene: {objects: {a: {color: red}, b: {color: red}}}",
            "scene: {objects: {a: {color: red}, b: {color: blue}}}",
        ),
    )
}


def check_colours(task: Task) -> Iterator[tuple[Check, list[Finding]]]:
    """Compare the colours of all movable objects of the scene."""
    first: dict[tuple[float, float, float], str] = {}
    findings = []
    for name, thing in task.file.spec.scene.objects.items():
        if thing.fixed or thing.urdf is not None:
            continue
        other = first.setdefault(rgb(thing.color), name)
        if other != name:
            path = ("scene", "objects", name)
            message = f"has the colour of {other}; give it another one"
            place = task.file.source.locate(path, key=True)
            findings.append(Finding("EXT101", message, ".".join(path), place, "warning"))
    wrong = len(findings)
    yield (
        Check("EXT101", "objects have colours of their own", True, wrong, None, "objects"),
        findings,
    )


COLOURS = CheckFamily(CODES, check_colours)
