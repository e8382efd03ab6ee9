"""What a learner learns from in a run: episodes in environments, or batches of a data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.errors import DivergenceError
from taskbuilder.learn.collector import Collector, Finished
from taskbuilder.learn.learner import Collection, DataLearner, Learner
from taskbuilder.learn.replay import Replay


class PracticeResult(NamedTuple):
    """What came of a step of a `Practice`.

    Attributes:
        losses: Losses of the updates that were made.
        finished: Training episodes that ended.
    """

    losses: Mapping[str, float]
    finished: Sequence[Finished]


class Practice(Protocol):
    """Advances a run step by step, with updates of its learner."""

    @property
    def memories(self) -> Mapping[str, Replay]:
        """The replay buffers that a checkpoint saves."""
        ...

    @property
    def at_rest(self) -> bool:
        """Whether a checkpoint may be made now."""
        ...

    def begin(self, seed: int) -> None:
        """Begin a stretch of training, after a checkpoint or at the start."""
        ...

    def step(self, rng: np.random.Generator, step: int) -> PracticeResult:
        """Advance the run from a step by as many steps as it has environments."""
        ...

    def counters(self) -> dict[str, Any]:
        """Other state that a checkpoint saves."""
        ...

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
        ...


@dataclass(frozen=True)
class Interaction:
    """Learns from episodes: acts in environments, and hands the transitions to a collection.

    Attributes:
        learner: The learner.
        collector: Steps the environments.
        collection: Stores the transitions, and decides when the learner learns.
        steps: Control steps of the whole run.
        envs: Number of parallel environments.
    """

    learner: Learner
    collector: Collector
    collection: Collection
    steps: int
    envs: int

    @property
    def memories(self) -> Mapping[str, Replay]:
        """Those of the collection."""
        return self.collection.memories

    @property
    def at_rest(self) -> bool:
        """Whether all collected transitions are in `memories`."""
        return self.collection.at_rest

    def begin(self, seed: int) -> None:
        """Reset all environments."""
        self.collection.begin()
        self.collector.begin(seed)

    def step(self, rng: np.random.Generator, step: int) -> PracticeResult:
        """Step all environments, and update the learner.

        Raises:
            DivergenceError: Actions of the learner are not finite.
        """
        self.collection.before_step(rng, step)
        fraction = min(step / self.steps, 1.0)
        actions = self.learner.act(self.collector.observations, rng, fraction)
        _check_finite(actions, step)
        self.collector.step_async(actions)
        losses = self.collection.during_step(rng, step)
        rows, lost, finished = self.collector.step_wait()
        fraction = min((step + self.envs) / self.steps, 1.0)
        losses |= self.collection.after_step(rows, lost, rng, fraction)
        return PracticeResult(losses, finished)

    def counters(self) -> dict[str, Any]:
        """Those of the collection."""
        return self.collection.counters()

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
        self.collection.load(counters)


def _check_finite(actions: Arrays, step: int) -> None:
    """Refuse to go on with a learner that has diverged."""
    for agent, action in actions.items():
        if not np.isfinite(action).all():
            raise DivergenceError(
                f"learning diverged: after {step:,} control steps the actions of {agent} are not "
                "finite. Its logs and checkpoints are kept; start again with a smaller lr, or with "
                "another seed"
            )


@dataclass(frozen=True)
class Batches:
    """Learns from a data set: a step is an update with a batch of it.

    Attributes:
        learner: The learner, which has the data set.
        steps: Updates of the whole run.
    """

    learner: DataLearner
    steps: int
    memories: Mapping[str, Replay] = field(default_factory=dict)
    at_rest: bool = True

    def begin(self, seed: int) -> None:
        """Do nothing; batches depend on the run's generator alone."""

    def step(self, rng: np.random.Generator, step: int) -> PracticeResult:
        """Update the learner once.

        Raises:
            DivergenceError: The loss is not finite.
        """
        losses = self.learner.update(rng, min(step / self.steps, 1.0))
        if not np.isfinite(list(losses.values())).all():
            raise DivergenceError(
                f"learning diverged: after {step:,} updates the loss is not finite. Its logs and "
                "checkpoints are kept; start again with a smaller lr, or with another seed"
            )
        return PracticeResult(losses, ())

    def counters(self) -> dict[str, Any]:
        """No other state."""
        return {}

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
