"""Problems with the robots and bodies that conditions and measures name."""

from __future__ import annotations

from collections.abc import Iterator

from taskbuilder.schema.names import SceneNames


def without_hands(names: SceneNames, *robots: str) -> Iterator[str]:
    """Robots that are to hold something and have no gripper."""
    for robot in robots:
        if robot in names.handless:
            yield f"{robot} has no gripper and never holds anything"


def one_body(first: str, second: str) -> Iterator[str]:
    """The problem with a force between a body and itself."""
    if first.partition(".")[0] == second.partition(".")[0]:
        yield "no force is known within one body; name two"
