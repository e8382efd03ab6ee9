"""Watching an episode, to explain afterwards why it did not succeed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from taskbuilder.description.reasons import EvaluatedState, Reason, reasons
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.record import Rollout


class Witness:
    """Records the values of all parts of the description during an episode.

    Call it after reset and after each control step of one episode.
    """

    def __init__(self) -> None:
        self._history: list[Sequence[Any]] = []
        self._failure: tuple[Reason, ...] = ()

    def __call__(self, env: TaskEnv) -> None:
        """Record the values of the current step."""
        episode = env.episode
        if episode.exploded:
            return
        self._history.append(episode.referee.values)
        if episode.outcome.failure and not self._failure:
            failure = env.task.description.failure
            found = reasons(failure, self._moment(env), wanted=False, of="failure")
            step = episode.steps
            self._failure = tuple(Reason("failure", r.part, r.says, step) for r in found)

    def reasons(self, env: TaskEnv, rollout: Rollout) -> tuple[Reason, ...]:
        """The reasons why success does not hold at the end; empty if it does.

        Args:
            env: The environment at the end of the episode.
            rollout: The record of the episode.
        """
        if rollout.success_at_end:
            return ()
        if rollout.exploded:
            diverged = Reason("physics", "", "the physics diverged", rollout.steps)
            return (*self._failure, diverged)
        success = env.task.description.success
        found = reasons(success, self._moment(env), wanted=True, of="success")
        return (*self._failure, *found)

    def _moment(self, env: TaskEnv) -> EvaluatedState:
        return env.episode.referee.moment(env.episode.world, self._history)
