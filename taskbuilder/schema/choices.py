"""Types of choices that change a task file: other robots, and another rule of grasping.

Nothing is loaded for them, so that whoever only names the choices is quick.
"""

from __future__ import annotations

from typing import Literal

OtherRobots = tuple[tuple[str, str], ...]
"""Pairs of a robot of the scene and the model in its place, sorted by name."""

GraspChoice = Literal["task", "friction", "attach"]
"""The rule as in the task file, or the rule of all grippers with fingers."""

LadderChoice = Literal["task", "expert"]
"""Where training gets its progress from: the description, or the stages of the expert."""
