"""Training rewards: the rewards that learners are trained on.

The task's own reward is always reported as well. A training reward stands between a vector
environment and a learner. It reads the infos, which policies never observe, and may give the
critics features of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from taskbuilder.learn.wrappers import STEPS_WITHOUT_PROGRESS, TRAINING_PROGRESS
from taskbuilder.rollout.progress import LEAST_TIMEOUT_S

VectorInfos = Mapping[str, Any]
Rewards = NDArray[np.float64]
Flags = NDArray[np.bool_]


class TrainingReward(Protocol):
    """The interface of a training reward.

    Class attributes: ``sharing``, the option `reward` of the environments that it needs;
    ``shared``, whether all agents of an environment always get the same reward;
    ``end_on_setback`` and ``no_progress_timeout_s``, the settings of the training wrappers; and
    ``feature_count``, the number of features for the critics.
    """

    def begin(self, infos: VectorInfos, rows: Flags) -> None:
        """Start new episodes in these rows."""
        ...

    def compute(self, rewards: Rewards, infos: VectorInfos) -> Rewards:
        """The agents' training rewards of a step: (num_envs, agents).

        Args:
            rewards: The environments' own rewards: (num_envs, agents).
            infos: The infos of the step, by key: (num_envs,) each.
        """
        ...

    def critic_features(self) -> NDArray[np.float32]:
        """The features that critics observe in addition: (num_envs, feature_count)."""
        ...


class Unchanged:
    """The environment's own rewards: ``team`` or ``local``."""

    sharing = "team"
    shared = True
    end_on_setback = False
    no_progress_timeout_s: float | None = None
    feature_count = 0

    def __init__(self, num_envs: int, discount: float) -> None:
        del discount
        self._nothing = np.zeros((num_envs, 0), dtype=np.float32)

    def begin(self, infos: VectorInfos, rows: Flags) -> None:
        """Start new episodes in these rows."""

    def compute(self, rewards: Rewards, infos: VectorInfos) -> Rewards:
        """The agents' training rewards of a step: (num_envs, agents)."""
        del infos
        return rewards

    def critic_features(self) -> NDArray[np.float32]:
        """The features that critics observe in addition: (num_envs, feature_count)."""
        return self._nothing


class Local(Unchanged):
    """Each agent's own terms and an equal share of the common ones."""

    sharing = "local"
    shared = False


class Sparse(Unchanged):
    """1 in each control step in which success holds, and else 0."""

    sharing = "sparse"


class Shaped:
    """The team reward plus potential-based shaping by progress.

    r + 45 (γ Φ(s') - Φ(s)), where Φ is the progress, from 0 to 1 (Ng, Harada and Russell 1999).
    Their proof that the optimal policies stay optimal needs Φ = 0 where an episode ends, which is
    not so here.
    """

    sharing = "team"
    shared = True
    end_on_setback = False
    no_progress_timeout_s: float | None = None
    feature_count = 0
    progress = TRAINING_PROGRESS
    weight = 45.0

    def __init__(self, num_envs: int, discount: float) -> None:
        self._discount = discount
        self._before = np.zeros(num_envs)
        self._nothing = np.zeros((num_envs, 0), dtype=np.float32)

    def begin(self, infos: VectorInfos, rows: Flags) -> None:
        """Start new episodes in these rows."""
        self._before[rows] = infos[self.progress][rows]

    def compute(self, rewards: Rewards, infos: VectorInfos) -> Rewards:
        """The agents' training rewards of a step: (num_envs, agents)."""
        now = infos[self.progress]
        gain = self._discount * now - self._before
        self._before = now.copy()
        shaped: Rewards = rewards + self.weight * gain[:, None]
        return shaped

    def critic_features(self) -> NDArray[np.float32]:
        """The features that critics observe in addition: (num_envs, feature_count)."""
        return self._nothing


class Ratchet:
    """A reward for each new best progress of the episode, and a small cost of being below it.

    0.3 (150 max(0, Φ - best Φ so far) - 3.75 (best Φ - Φ) + 4 while success holds - 2 on failure or
    a setback), where Φ is the progress, from 0 to 1; a setback ends the episode. The task's own
    reward is not used: waiting, holding or staying near something earns nothing. The cost is for
    policies that fly past what they were paid for. A learner that has lost its object gains nothing
    by going back for it, so episodes also end when the progress has not risen for a while. Critics
    observe the best progress so far and the steps without progress; policies do not.
    """

    sharing = "team"
    shared = True
    end_on_setback = True
    no_progress_timeout_s: float | None = LEAST_TIMEOUT_S
    feature_count = 2
    progress = TRAINING_PROGRESS
    gain, below, success, failure, scale = 150.0, 3.75, 4.0, 2.0, 0.3
    best_unit = 1.0

    def __init__(self, num_envs: int, discount: float) -> None:
        del discount
        self._best = np.zeros(num_envs)
        self._stalled = np.zeros(num_envs)

    def begin(self, infos: VectorInfos, rows: Flags) -> None:
        """Start new episodes in these rows."""
        self._best[rows] = infos[self.progress][rows]
        self._stalled[rows] = infos[STEPS_WITHOUT_PROGRESS][rows]

    def compute(self, rewards: Rewards, infos: VectorInfos) -> Rewards:
        """The agents' training rewards of a step: (num_envs, agents)."""
        now = infos[self.progress]
        gained = np.maximum(now - self._best, 0.0)
        self._best = np.maximum(self._best, now)
        self._stalled = infos[STEPS_WITHOUT_PROGRESS].copy()
        lost = np.maximum(infos["failure"], infos["condition/setback"])
        reward = self.gain * gained - self.below * (self._best - now)
        reward += self.success * infos["success"] - self.failure * lost
        return np.broadcast_to(self.scale * reward[:, None], rewards.shape)

    def critic_features(self) -> NDArray[np.float32]:
        """The features that critics observe in addition: (num_envs, feature_count)."""
        return np.stack([self._best / self.best_unit, self._stalled], 1).astype(np.float32)


class RawShaped(Shaped):
    """`Shaped` by the unscaled progress of the description, as in runs of earlier versions."""

    progress = "progress"
    weight = 3.0


class RawRatchet(Ratchet):
    """`Ratchet` on the unscaled progress of the description, as in runs of earlier versions."""

    progress = "progress"
    gain, below = 10.0, 0.25
    best_unit = 10.0


RewardClass = type[Unchanged] | type[Shaped] | type[Ratchet]

TRAINING_REWARDS: Mapping[str, RewardClass] = {
    "team": Unchanged,
    "local": Local,
    "sparse": Sparse,
    "shaped": Shaped,
    "ratchet": Ratchet,
}
"""The classes of the training rewards by name; each takes ``num_envs`` and ``discount``."""

RAW_REWARDS: Mapping[str, RewardClass] = {
    **TRAINING_REWARDS,
    "shaped": RawShaped,
    "ratchet": RawRatchet,
}
"""Those of runs that see the unscaled progress of the description."""


def reads_progress(name: str) -> bool:
    """Whether a training reward depends on the progress."""
    return hasattr(TRAINING_REWARDS[name], "progress")
