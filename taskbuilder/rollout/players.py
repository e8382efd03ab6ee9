"""Simple policies: holding still, random actions, recorded actions, any function."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv


class HoldStill:
    """Repeats the last commands of all arms and grippers."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; actions must be flat."""
        self._encoder = ActionEncoder(env)

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """The action that changes nothing."""
        return self._encoder.hold()


class RandomActions:
    """Draws actions uniformly within their bounds; actions must be flat."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; the seed determines the actions."""
        self._env = env
        # Apart from the generators of the episode, which are made of the seed alone.
        self._rng = np.random.default_rng([seed, 2])

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """The next random actions."""
        drawn = {}
        for agent, modes in self._env.episode.actions.items():
            numbers = self._rng.uniform(-1.0, 1.0, modes.size).tolist()
            if not self._env.options.normalize:
                numbers = modes.physical(numbers)
            drawn[agent] = np.array(numbers, dtype=np.float32)
        return drawn


class RecordedActions:
    """Plays recorded actions, then stops.

    Args:
        actions: (steps, n) by agent.
    """

    def __init__(self, actions: Mapping[str, NDArray[np.float32]]) -> None:
        self._actions = actions
        self._step = 0

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin with the first action."""
        self._step = 0

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The next action, or None after the last."""
        if self._step >= min(map(len, self._actions.values())):
            return None
        step, self._step = self._step, self._step + 1
        return {agent: actions[step] for agent, actions in self._actions.items()}


class Function:
    """Calls a function of the observations at each step.

    Args:
        function: Returns the actions of all agents, given their observations; None to stop.
    """

    def __init__(
        self, function: Callable[[Mapping[str, Any]], Mapping[str, NDArray[np.floating]] | None]
    ) -> None:
        self._function = function

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Do nothing; there is nothing to prepare."""

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The function's actions, in the precision of recorded actions."""
        chosen = self._function(observations)
        if chosen is None:
            return None
        return {agent: np.asarray(action, dtype=np.float32) for agent, action in chosen.items()}
