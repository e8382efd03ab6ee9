"""What an algorithm is to the rest: a learner, its settings and presets, and how it collects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from taskbuilder.arrays import Arrays
from taskbuilder.learn.policy import Array, TrainedPolicy
from taskbuilder.learn.replay import Memory, Replay
from taskbuilder.learn.shapes import Rows


class Learner(Protocol):
    """Learns to act from transitions: what every learner has, however it collects them."""

    settings: Any
    """A frozen dataclass, with at least ``discount``."""

    def act(
        self, observations: Mapping[str, Array], rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, Array]:
        """What the agents do to explore, after a fraction of the training: (num_envs, n) each."""
        ...

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The present policy, to play."""
        ...

    def start_from(self, policy: TrainedPolicy) -> None:
        """Begin with a trained policy; called before anything is learned.

        Raises:
            UsageError: The policy does not fit.
        """
        ...

    def arrays(self) -> Arrays:
        """All that it needs to go on exactly."""
        ...

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Go on from what `arrays` gave."""
        ...


class OffPolicyLearner(Learner, Protocol):
    """Learns from transitions of any policy, drawn from a replay memory.

    Its settings have ``capacity``, ``warm_up`` and ``update_every`` too; see `OffPolicy`.
    """

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Prepare for learning, once, with all transitions so far or all demonstrations."""
        ...

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Learn from a batch, after so many control steps; gives losses for logs."""
        ...


class OnPolicyLearner(Learner, Protocol):
    """Learns from the latest transitions of its own policy, which it then forgets.

    Its settings have ``rollout_steps`` too; see `OnPolicy`.
    """

    def update(
        self, rollout: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Learn from a rollout; gives losses for logs.

        Args:
            rollout: (steps, num_envs, width) rows of the layout, in the order of time.
            lost: (steps, num_envs) bool: what happened there nobody saw, for a worker was lost.
            rng: Draws the minibatches.
            progress_fraction: Of the training so far.
        """
        ...


class Collection(Protocol):
    """Stands between the environments and a learner: what is kept, and when it learns from it."""

    @property
    def memories(self) -> Mapping[str, Replay]:
        """The replay memories that a checkpoint keeps."""
        ...

    @property
    def at_rest(self) -> bool:
        """Whether a checkpoint may be made now; what has been collected is in `memories`."""
        ...

    def before_step(self, rng: np.random.Generator, step: int) -> None:
        """The agents are about to act."""
        ...

    def during_step(self, rng: np.random.Generator, step: int) -> dict[str, float]:
        """The environments are at work; losses of what was learned meanwhile."""
        ...

    def after_step(
        self, rows: Rows, lost: Any, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """All have acted: a row for each environment; losses of what was learned from it."""
        ...

    def counters(self) -> dict[str, Any]:
        """What else a checkpoint keeps."""
        ...

    def load(self, counters: Mapping[str, Any]) -> None:
        """Go on from what `counters` gave."""
        ...


@dataclass(frozen=True)
class Preset:
    """Settings that go together, under a name.

    Attributes:
        summary: What they are for.
        settings: Of the algorithm, by name.
        plan: Of the run, by name; see `Plan`.
    """

    summary: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    plan: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Algorithm:
    """A learner that `train` knows by name; a module of `taskbuilder.learn.algorithms` has one.

    Attributes:
        summary: What it is.
        settings: The frozen dataclass of its settings, each with a default.
        learner: Makes the learner, of shapes, settings, ``shared_reward`` (whether all agents are
            always rewarded the same), ``seed`` and ``device``.
        collection: `OffPolicy` or `OnPolicy`, or a class of one's own like them.
        presets: By name.
        default_preset: The preset of a run that names none; takes whether there are
            demonstrations, and whether it starts from a trained policy. "" for none.
        cannot: Why it refuses fields of a plan, by name.
        settings_of: The settings that a trained policy's networks ask for, to start from it.
    """

    summary: str
    settings: type[Any]
    learner: Callable[..., Any]
    collection: Callable[..., Collection]
    presets: Mapping[str, Preset] = field(default_factory=dict)
    default_preset: Callable[[bool, bool], str] = lambda demos, init: ""  # noqa: ARG005
    cannot: Mapping[str, str] = field(default_factory=dict)
    settings_of: Callable[[TrainedPolicy], Mapping[str, Any]] = lambda policy: {}  # noqa: ARG005
