"""Learning from rollouts: so many steps of every environment, learned from once and let go."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from taskbuilder.learn.learner import OnPolicyLearner
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Rows


class OnPolicy:
    """Collects ``rollout_steps`` steps of every environment, and lets its learner have them.

    Checkpoints are made between rollouts, so that there is nothing of one to be kept.

    Args:
        learner: Who learns.
        width: Numbers of a row.
        envs: Environments that step at once.
        demonstrations: None; a policy's own transitions are all that it learns from.
    """

    memories: Mapping[str, Replay] = {}

    def __init__(
        self, learner: OnPolicyLearner, width: int, envs: int, demonstrations: Rows | None = None
    ) -> None:
        del demonstrations
        steps = learner.settings.rollout_steps
        self._learner, self._filled = learner, 0
        self._rows = np.zeros((steps, envs, width), dtype=np.float32)
        self._lost = np.zeros((steps, envs), dtype=np.bool_)

    @property
    def at_rest(self) -> bool:
        """Whether the last rollout has been learned from, and the next not begun."""
        return self._filled == 0

    def before_step(self, rng: np.random.Generator, step: int) -> None:
        """Nothing is to be prepared."""

    def during_step(self, rng: np.random.Generator, step: int) -> dict[str, float]:
        """The policy stays as it is while it plays."""
        del rng, step
        return {}

    def after_step(
        self, rows: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Add a step to the rollout, and learn from one that is whole."""
        self._rows[self._filled], self._lost[self._filled] = rows, lost
        self._filled += 1
        if self._filled < len(self._rows):
            return {}
        self._filled = 0
        return self._learner.update(self._rows, self._lost, rng, progress_fraction)

    def counters(self) -> dict[str, Any]:
        """Nothing is left between rollouts."""
        return {}

    def load(self, counters: Mapping[str, Any]) -> None:
        """Go on from what `counters` gave."""
