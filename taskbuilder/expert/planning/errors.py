"""The error of planning."""

from __future__ import annotations

from typing import Literal

from taskbuilder.errors import TaskbuilderError

Cause = Literal["out of reach", "in collision", "no path"]


class PlanningError(TaskbuilderError):  # it is an answer as much as an error
    """A motion is not possible.

    Attributes:
        robot: The robot; "" for none in particular.
        cause: The cause, one of `Cause`.
        message: The robot and the obstacle, or the remaining distance, in a sentence.
    """

    def __init__(self, robot: str, cause: Cause, message: str) -> None:
        self.robot = robot
        self.cause = cause
        self.message = message
        super().__init__(message)
