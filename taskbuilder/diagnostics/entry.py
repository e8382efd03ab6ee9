"""What the registries of codes are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Where = Literal["file", "task", "description", "module", "robot", "folder"]
"""What an example is a piece of.

``file``: a YAML file, whole. ``task``, ``robot``: keys of a task file or robot.yaml.
``description``: attributes of the description class. ``module``: the Python file, less its
imports from taskbuilder. ``folder``: names of files.
"""


@dataclass(frozen=True, slots=True)
class Example:
    """Something that gives a finding, and the same mended.

    Attributes:
        where: What both are a piece of.
        bad: What gives the finding.
        good: What does not.
        under: Dotted path of the mapping that the keys belong to; "" for the top level.
    """

    where: Where
    bad: str
    good: str
    under: str = ""


@dataclass(frozen=True, slots=True)
class Code:
    """What a code stands for.

    Attributes:
        title: A few words.
        meaning: What is wrong, and why it is refused.
        example: None for a check that gathers several codes, or that no task file is known to
            fail.
    """

    title: str
    meaning: str
    example: Example | None = None


def within(under: str, bad: str, good: str) -> Example:
    """Keys of a task file, under a dotted path."""
    return Example("task", bad, good, under)


def cabinet(bad: str, good: str) -> Example:
    """What is said of a cabinet with a drawer, badly and well."""
    begin = "cabinet: {shape: {urdf: cabinet.urdf}, fixed: true, position: [0, 0.35, 0.401], "
    return within("scene.objects", f"{begin}{bad}}}", f"{begin}{good}}}")


def block(bad: str, good: str) -> Example:
    """A block that is put somewhere, badly and well."""
    begin = "block: {shape: {box: [0.06, 0.06, 0.06]}, mass: 0.1, "
    return within("scene.objects", f"{begin}{bad}}}", f"{begin}{good}}}")
