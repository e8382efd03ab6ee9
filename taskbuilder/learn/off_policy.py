"""Off-policy collection: transitions go to a replay buffer and are sampled many times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from taskbuilder.learn.learner import OffPolicyLearner
from taskbuilder.learn.n_step import NStepTransitions
from taskbuilder.learn.replay import Replay
from taskbuilder.learn.shapes import Layout, Rows

DEMO_SHARE = 0.5
"""Fraction of demonstrations in every batch, if there are any."""


class OffPolicy:
    """Stores transitions in a replay buffer, and updates the learner while the environments step.

    Learning begins after ``warm_up`` control steps, or at once if there are demonstrations. Then
    there is an update every ``update_every`` control steps. Transitions are over ``n_step`` control
    steps; with more than one, those in progress at a checkpoint are dropped.

    Args:
        learner: The learner.
        layout: The layout of a row.
        envs: Number of parallel environments.
        demonstrations: Rows of demonstrations, or None.
    """

    at_rest = True

    needs = ("capacity", "warm_up", "update_every", "n_step")
    """What it needs of the settings of learners."""

    def __init__(
        self,
        learner: OffPolicyLearner,
        layout: Layout,
        envs: int,
        demonstrations: Rows | None = None,
    ) -> None:
        settings = learner.settings
        self._learner, self._envs = learner, envs
        self._due, self._begun = 0.0, False
        self._n_step = NStepTransitions(layout, envs, settings.n_step, settings.discount)
        self.experience = Replay(layout.width, settings.capacity)
        self.demonstrations: Replay | None = None
        if demonstrations is not None:
            self.demonstrations = Replay(layout.width, len(demonstrations))
            self.demonstrations.add(demonstrations)

    @property
    def memories(self) -> dict[str, Replay]:
        """The replay buffer; demonstrations are not saved, because they are replayed on loading."""
        return {"experience": self.experience}

    def begin(self) -> None:
        """Drop the transitions in progress: all environments are reset."""
        self._n_step.begin()

    def before_step(self, rng: np.random.Generator, step: int) -> None:
        """Prepare the learner once learning is due to begin."""
        if self._begun:
            return
        if self.demonstrations is not None or step >= self._learner.settings.warm_up:
            rows = (self.demonstrations or self.experience).since(0)
            self._learner.begin(rows, rng)
            self._begun = True

    def during_step(self, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Make the updates that are due."""
        losses: dict[str, float] = {}
        if not self._begun:
            return losses
        self._due += self._envs / self._learner.settings.update_every
        while self._due >= 1.0:
            losses |= self._learner.update(self, rng, step)
            self._due -= 1.0
        return losses

    def after_step(
        self, rows: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Store the transitions."""
        del rng, progress_fraction
        self.experience.add(self._n_step.add(rows, lost))
        return {}

    def sample(self, count: int, rng: np.random.Generator) -> Rows:
        """Draw a batch: half demonstrations, or all of it while there is no experience."""
        if self.demonstrations is None:
            return self.experience.sample(count, rng)
        demo_count = round(count * DEMO_SHARE) if len(self.experience) else count
        rows = [self.demonstrations.sample(demo_count, rng)]
        if demo_count < count:
            rows.append(self.experience.sample(count - demo_count, rng))
        return np.concatenate(rows)

    def counters(self) -> dict[str, Any]:
        """The number of updates that are due, with fractions, and whether learning has begun."""
        return {"due": self._due, "begun": self._begun}

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
        self._due, self._begun = counters["due"], counters["begun"]
