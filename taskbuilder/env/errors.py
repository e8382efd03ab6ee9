"""Errors of environments; a refused call leaves the state unchanged."""

from __future__ import annotations

from typing import Any

from taskbuilder.errors import TaskbuilderError, UsageError


class ActionError(TaskbuilderError, ValueError):
    """An action that is not in its agent's space.

    Attributes:
        agent: The agent.
        space: The action space.
    """

    def __init__(self, agent: str, space: Any, what: str) -> None:
        self.agent = agent
        self.space = space
        super().__init__(f"the action of {agent} {what}; it must be in {space}")


class AgentError(TaskbuilderError, KeyError):
    """An action is missing, or is for an unknown agent."""

    def __init__(self, message: str) -> None:
        self.message = message
        super().__init__(message)

    def __str__(self) -> str:
        return self.message


class EpisodeOverError(UsageError):
    """A step before the first reset, or after the end of an episode."""
