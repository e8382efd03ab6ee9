"""The error of planning."""

from __future__ import annotations

from typing import Literal

from taskbuilder.errors import TaskbuilderError

Cause = Literal["out of reach", "in collision", "no way"]


class PlanningError(TaskbuilderError):  # it is an answer as much as an error
    """A motion that cannot be made.

    Attributes:
        robot: Whose motion it is; "" where it is none in particular.
        cause: In a few words; one of `Cause`.
        message: Which robot and what is in the way or how far off it stays, in a sentence.
    """

    def __init__(self, robot: str, cause: Cause, message: str) -> None:
        self.robot = robot
        self.cause = cause
        self.message = message
        super().__init__(message)
