"""The robots of the library."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.reference.markdown import side_by_side, table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import load_robot

IMAGES = Path(__file__).parents[1] / "images"


def library(_: str) -> str:
    """A table of the robots, and their pictures."""
    robots = [load_robot(entry) for entry in Catalogue().robots.values() if entry.module]
    rows = [
        [
            f"`{robot.name}`",
            str(len(robot.arm)),
            robot.grip or "–",
            robot.spec.summary,
        ]
        for robot in robots
    ]
    figures = [
        f"![{robot.spec.summary}](images/robot-{robot.name}.png)\n\n`{robot.name}`"
        for robot in robots
        if (IMAGES / f"robot-{robot.name}.png").is_file()
    ]
    return f"{table(['robot', 'joints', 'gripper', 'what it is'], rows)}\n\n{side_by_side(figures)}"
