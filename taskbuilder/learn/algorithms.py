"""The learners by name, and what all of them have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.learn.maddpg import Maddpg, MaddpgSettings
from taskbuilder.learn.plan import Plan, make_settings
from taskbuilder.learn.policy import Array, Policy
from taskbuilder.learn.replay import Memory
from taskbuilder.learn.shapes import Rows, Shapes


class Learner(Protocol):
    """Learns to act, from transitions."""

    settings: Any
    """A frozen dataclass with at least discount, batch, capacity, warm_up and update_every."""

    def act(
        self, observations: Mapping[str, Array], rng: np.random.Generator, done: float
    ) -> dict[str, Array]:
        """What the agents do to explore, after a share of the training: (num_envs, n) each."""
        ...

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Prepare for learning, once, with all transitions so far."""
        ...

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Learn from a batch, after so many control steps; gives losses for logs."""
        ...

    def policy(self, about: Mapping[str, Any]) -> Policy:
        """The present policy, to play."""
        ...

    def arrays(self) -> Arrays:
        """All that it needs to go on exactly."""
        ...

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Go on from what `arrays` gave."""
        ...


def settings_of(algorithm: str) -> type[Any]:
    """The dataclass of an algorithm's settings."""
    if algorithm == "maddpg":
        return MaddpgSettings
    from taskbuilder.learn.maddpg_openai import OpenaiSettings

    return OpenaiSettings


def make_learner(plan: Plan, shapes: Shapes, *, alike: bool) -> Learner:
    """The learner of a plan, which knows nothing yet.

    Args:
        plan: What to train and how.
        shapes: What agents and critics see and say.
        alike: Whether all agents are always paid the same.

    Raises:
        UsageError: A setting is unknown or of the wrong kind.
    """
    settings = make_settings(settings_of(plan.algorithm), plan.settings)
    if plan.algorithm == "maddpg":
        return Maddpg(shapes, settings, alike=alike, seed=plan.seed)
    from taskbuilder.learn.maddpg_openai import MaddpgOpenai

    return MaddpgOpenai(shapes, settings, alike=alike, seed=plan.seed)
