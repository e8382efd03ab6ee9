"""Policies that take no plan: holding still, random actions, recorded actions, any function."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv


class HoldStill:
    """Every robot stays where it is commanded to be, grippers included."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; actions must be flat."""
        self._encoder = ActionEncoder(env)

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """The action that changes nothing."""
        return self._encoder.hold()


class RandomActions:
    """Draws every number of every action uniformly within its bounds; actions must be flat."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; the seed decides what is drawn."""
        self._env = env
        # Apart from the generators of the episode, which are made of the seed alone.
        self._rng = np.random.default_rng([seed, 2])

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """The next draw."""
        drawn = {}
        for agent, modes in self._env.episode.actions.items():
            numbers = self._rng.uniform(-1.0, 1.0, modes.size).tolist()
            if not self._env.options.normalize:
                numbers = modes.physical(numbers)
            drawn[agent] = np.array(numbers, dtype=np.float32)
        return drawn


class RecordedActions:
    """Repeats recorded actions, then stops playing.

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
    """Asks a function of the observations; what it remembers between steps is its own affair.

    Args:
        function: Every agent's action, as the environment takes it, given every agent's
            observation; None to stop playing.
    """

    def __init__(
        self, function: Callable[[Mapping[str, Any]], Mapping[str, NDArray[np.floating]] | None]
    ) -> None:
        self._function = function

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Nothing needs to be prepared."""

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """What the function says, in the precision in which actions are recorded."""
        chosen = self._function(observations)
        if chosen is None:
            return None
        return {agent: np.asarray(action, dtype=np.float32) for agent, action in chosen.items()}
