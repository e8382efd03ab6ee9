"""Interfaces of a learning algorithm: the learner, its settings and presets, its collection."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.learn.replay import Memory, Replay
from taskbuilder.learn.shapes import Rows
from taskbuilder.policies.trained import Array32, TrainedPolicy


class Trainable(Protocol):
    """The interface of everything that is trained, whatever it learns from."""

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy, for evaluation."""
        ...

    def start_from(self, policy: TrainedPolicy) -> None:
        """Start from a trained policy; called before any update.

        Raises:
            UsageError: The policy does not fit.
        """
        ...

    def arrays(self) -> Arrays:
        """The complete state of the learner, by name."""
        ...

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Restore the state that `arrays` returned."""
        ...


class Learner(Trainable, Protocol):
    """The interface of learners that act in environments, on-policy and off-policy."""

    settings: Any
    """A frozen dataclass that has at least ``discount``."""

    def act(
        self,
        observations: Mapping[str, Array32],
        rng: np.random.Generator,
        progress_fraction: float,
    ) -> dict[str, Array32]:
        """Exploratory actions at a fraction of the training: (num_envs, n) each."""
        ...


class DataLearner(Trainable, Protocol):
    """Learns from a data set that it was made with, and never acts while it learns."""

    def update(self, rng: np.random.Generator, progress_fraction: float) -> dict[str, float]:
        """Learn from a batch, and return the losses for the logs.

        Args:
            rng: Generator of the batch.
            progress_fraction: The fraction of the training that is done.
        """
        ...


class OffPolicyLearner(Learner, Protocol):
    """Learns from transitions of any policy, sampled from a replay buffer.

    Its settings also have ``capacity``, ``warm_up``, ``update_every`` and ``n_step``; see
    `OffPolicy`.
    """

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Prepare for learning, once, with all transitions so far or all demonstrations."""
        ...

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Learn from a batch at a control step, and return the losses for the logs."""
        ...


class OnPolicyLearner(Learner, Protocol):
    """Learns from the latest transitions of its own policy, and discards them afterwards.

    Its settings also have ``rollout_steps``; see `OnPolicy`.
    """

    def update(
        self, rollout: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Learn from a rollout, and return the losses for the logs.

        Args:
            rollout: (steps, num_envs, width) rows of the layout, in the order of time.
            lost: (steps, num_envs) bool, where a transition was lost with its worker.
            rng: Generator of the minibatches.
            progress_fraction: The fraction of the training that is done.
        """
        ...


class Collection(Protocol):
    """Stores transitions of the environments for a learner, and decides when it learns."""

    @property
    def memories(self) -> Mapping[str, Replay]:
        """The replay buffers that a checkpoint saves."""
        ...

    @property
    def at_rest(self) -> bool:
        """Whether a checkpoint may be made now, with all collected transitions in `memories`."""
        ...

    def begin(self) -> None:
        """Called when all environments are reset: at the start, and after each checkpoint."""
        ...

    def before_step(self, rng: np.random.Generator, step: int) -> None:
        """Called before the agents act."""
        ...

    def during_step(self, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Called while the environments step; returns the losses of updates made meanwhile."""
        ...

    def after_step(
        self, rows: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Called with a row for each environment after a step; returns the losses of updates."""
        ...

    def counters(self) -> dict[str, Any]:
        """Other state that a checkpoint saves."""
        ...

    def load(self, counters: Mapping[str, Any]) -> None:
        """Restore the state that `counters` returned."""
        ...


@dataclass(frozen=True)
class Preset:
    """A named set of settings that belong together.

    Attributes:
        summary: What the preset is for.
        settings: Settings of the algorithm, by name.
        plan: Fields of the run's `Plan`, by name.
    """

    summary: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    plan: Mapping[str, Any] = field(default_factory=dict)


def _no_collection(*_: Any) -> Collection:
    """The collection of algorithms that learn from a data set."""
    raise TypeError("it learns from a data set and collects nothing")


def _no_preset(given: Mapping[str, Any]) -> str:
    """The default preset of algorithms that have none, whatever is given."""
    del given
    return ""


def collects(algorithm: Algorithm) -> bool:
    """Whether an algorithm says how it collects transitions."""
    return algorithm.collection is not _no_collection


@dataclass(frozen=True)
class Algorithm:
    """An algorithm that `train` finds by name; see `taskbuilder.learn.algorithms`.

    Attributes:
        summary: One line about the algorithm.
        settings: The frozen dataclass of its settings, each with a default.
        learner: Makes the learner from shapes, settings, ``shared_reward`` (whether all agents
            always get the same reward), ``seed`` and ``device``. With ``from_data``, from
            `Demonstrations`, settings, ``seed`` and ``device``.
        collection: `OffPolicy` or `OnPolicy`, or a class with the same interface; none with
            ``from_data``.
        presets: The presets by name.
        default_preset: The preset of a run that names none, from the fields of its plan that are
            given; "" for none.
        cannot: Fields of a plan that the algorithm does not support, with the reason, which
            follows the algorithm's name in a message: "learns from no demonstrations".
        settings_of: The settings that match the networks of a trained policy to start from.
        from_data: Whether it learns from a data set, in place of episodes of its own.
    """

    summary: str
    settings: type[Any]
    learner: Callable[..., Any]
    collection: Callable[..., Collection] = _no_collection
    presets: Mapping[str, Preset] = field(default_factory=dict)
    default_preset: Callable[[Mapping[str, Any]], str] = _no_preset
    cannot: Mapping[str, str] = field(default_factory=dict)
    settings_of: Callable[[TrainedPolicy], Mapping[str, Any]] = lambda policy: {}  # noqa: ARG005  # the default ignores them
    from_data: bool = False

    @property
    def refused(self) -> Mapping[str, str]:
        """Fields of a plan that the algorithm or its collection refuses, with the reason."""
        return {**getattr(self.collection, "cannot", {}), **self.cannot}
