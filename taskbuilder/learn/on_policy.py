"""On-policy collection: rollouts that are learned from once and then discarded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from taskbuilder.learn.learner import OnPolicyLearner
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Layout, Rows


class OnPolicy:
    """Collects ``rollout_steps`` steps of every environment, then updates the learner with them.

    Checkpoints are made between rollouts, so no rollout has to be saved.

    Args:
        learner: The learner.
        layout: The layout of a row.
        envs: Number of parallel environments.
        demonstrations: None; on-policy learners use only transitions of their own policy.
    """

    memories: Mapping[str, Replay] = {}

    needs = ("rollout_steps",)
    """What it needs of the settings of learners."""

    cannot: ClassVar = {"demos": "learns from no demonstrations; maddpg does"}
    """Fields of a plan that its learners do not support."""

    def __init__(
        self,
        learner: OnPolicyLearner,
        layout: Layout,
        envs: int,
        demonstrations: Rows | None = None,
    ) -> None:
        del demonstrations
        steps = learner.settings.rollout_steps
        self._learner, self._filled = learner, 0
        self._rows = np.zeros((steps, envs, layout.width), dtype=np.float32)
        self._lost = np.zeros((steps, envs), dtype=np.bool_)

    @property
    def at_rest(self) -> bool:
        """Whether no rollout is in progress."""
        return self._filled == 0

    def begin(self) -> None:
        """Do nothing: checkpoints, and so resets, are between rollouts."""

    def before_step(self, rng: np.random.Generator, step: int) -> None:
        """Do nothing; there is nothing to prepare."""

    def during_step(self, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Do nothing; the policy does not change during a rollout."""
        del rng, step
        return {}

    def after_step(
        self, rows: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Add a step to the rollout, and update the learner when the rollout is complete."""
        self._rows[self._filled], self._lost[self._filled] = rows, lost
        self._filled += 1
        if self._filled < len(self._rows):
            return {}
        self._filled = 0
        return self._learner.update(self._rows, self._lost, rng, progress_fraction)

    def counters(self) -> dict[str, Any]:
        """No other state; nothing is kept between rollouts."""
        return {}

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
