"""Looking on while an episode is played, to say afterwards why it was no success."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from taskbuilder.description.reasons import EvaluatedState, Reason, reasons
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.record import Rollout


class Witness:
    """Remembers how every part of the description stood; it asks nothing while all goes well.

    Call it after reset and after each control step of one episode.
    """

    def __init__(self) -> None:
        self._history: list[Sequence[Any]] = []
        self._failure: tuple[Reason, ...] = ()

    def __call__(self, env: TaskEnv) -> None:
        """Note how the description was judged."""
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
        """Why success does not hold at the end of the episode; nothing where it does.

        Args:
            env: As it stands there.
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
