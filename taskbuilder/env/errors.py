"""What an environment refuses; its state is then unchanged."""

from __future__ import annotations

from typing import Any

from taskbuilder.errors import TaskbuilderError, UsageError


class ActionError(TaskbuilderError, ValueError):
    """An action that is not in its agent's space.

    Attributes:
        agent: Whose action it is.
        space: The space that it should be in.
    """

    def __init__(self, agent: str, space: Any, what: str) -> None:
        self.agent = agent
        self.space = space
        super().__init__(f"the action of {agent} {what}; it must be in {space}")


class AgentError(TaskbuilderError, KeyError):
    """Actions were given for agents that are not there, or not for all that are."""

    def __init__(self, message: str) -> None:
        self.message = message
        super().__init__(message)

    def __str__(self) -> str:
        return self.message


class EpisodeOverError(UsageError):
    """A step before the first reset, or after the end of an episode."""
