"""Training rewards: what learners learn from, beside the task's reward that is always reported.

A training reward stands between a vector of environments and a learner. It reads the infos, which
the policies never see, and may show the critics features of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from taskbuilder.learn.wrappers import STEPS_WITHOUT_PROGRESS

Infos = Mapping[str, Any]
Rewards = NDArray[np.float64]
Flags = NDArray[np.bool_]


class TrainingReward(Protocol):
    """Rewards learners.

    Its class says: ``sharing``, the option `reward` of the environments that it builds upon;
    ``shared``, whether all agents of an environment are always rewarded the same;
    ``end_on_setback`` and ``no_progress_timeout_s``, the training wrappers of those names; and
    ``feature_count``, the numbers that it shows the critics.
    """

    def begin(self, infos: Infos, rows: Flags) -> None:
        """Episodes have begun in these rows."""
        ...

    def compute(self, rewards: Rewards, infos: Infos) -> Rewards:
        """The agents' rewards of a step: (num_envs, agents), from the environments' own."""
        ...

    def critic_features(self) -> NDArray[np.float32]:
        """What critics see of it: (num_envs, feature_count)."""
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

    def begin(self, infos: Infos, rows: Flags) -> None:
        """See `TrainingReward`."""

    def compute(self, rewards: Rewards, infos: Infos) -> Rewards:
        """See `TrainingReward`."""
        del infos
        return rewards

    def critic_features(self) -> NDArray[np.float32]:
        """See `TrainingReward`."""
        return self._nothing


class Local(Unchanged):
    """Every agent's own terms and an even share of the common ones."""

    sharing = "local"
    shared = False


class Shaped:
    """The team's reward and the discounted gain in progress.

    Potential-based shaping (Ng, Harada and Russell 1999): r + w (γ Φ(s') - Φ(s)), which leaves
    the best policies as they are.
    """

    sharing = "team"
    shared = True
    end_on_setback = False
    no_progress_timeout_s: float | None = None
    feature_count = 0
    weight = 3.0

    def __init__(self, num_envs: int, discount: float) -> None:
        self._discount = discount
        self._before = np.zeros(num_envs)
        self._nothing = np.zeros((num_envs, 0), dtype=np.float32)

    def begin(self, infos: Infos, rows: Flags) -> None:
        """See `TrainingReward`."""
        self._before[rows] = infos["progress"][rows]

    def compute(self, rewards: Rewards, infos: Infos) -> Rewards:
        """See `TrainingReward`."""
        now = infos["progress"]
        gain = self._discount * now - self._before
        self._before = now.copy()
        shaped: Rewards = rewards + self.weight * gain[:, None]
        return shaped

    def critic_features(self) -> NDArray[np.float32]:
        """See `TrainingReward`."""
        return self._nothing


class Ratchet:
    """Rewards progress beyond the best of the episode so far, and takes nothing for losing it.

    10 max(0, Φ - best Φ so far) + 2 while there is success - 2 for failure or a setback, which ends
    the episode, times 0.3. The best so far is shown to the critics; policies do not see it. It is
    not the task's reward: what waits, holds or stays near earns nothing here. So a learner that has
    gone astray has no reason to come back, and an episode ends when progress has not risen for a
    while; how long it has not is shown to the critics too.
    """

    sharing = "team"
    shared = True
    end_on_setback = True
    no_progress_timeout_s: float | None = 1.5
    feature_count = 2
    gain, success, failure, scale = 10.0, 2.0, 2.0, 0.3

    def __init__(self, num_envs: int, discount: float) -> None:
        del discount
        self._best = np.zeros(num_envs)
        self._stalled = np.zeros(num_envs)

    def begin(self, infos: Infos, rows: Flags) -> None:
        """See `TrainingReward`."""
        self._best[rows] = infos["progress"][rows]
        self._stalled[rows] = infos[STEPS_WITHOUT_PROGRESS][rows]

    def compute(self, rewards: Rewards, infos: Infos) -> Rewards:
        """See `TrainingReward`."""
        gained = np.maximum(infos["progress"] - self._best, 0.0)
        self._best = np.maximum(self._best, infos["progress"])
        self._stalled = infos[STEPS_WITHOUT_PROGRESS].copy()
        lost = np.maximum(infos["failure"], infos["condition/setback"])
        pay = self.gain * gained + self.success * infos["success"] - self.failure * lost
        return np.broadcast_to(self.scale * pay[:, None], rewards.shape)

    def critic_features(self) -> NDArray[np.float32]:
        """See `TrainingReward`; progress in tens, as large as other things that critics see."""
        return np.stack([self._best / 10.0, self._stalled], 1).astype(np.float32)


TRAINING_REWARDS: Mapping[str, type[Unchanged] | type[Shaped] | type[Ratchet]] = {
    "team": Unchanged,
    "local": Local,
    "shaped": Shaped,
    "ratchet": Ratchet,
}
"""Training rewards by name, made for so many environments and a discount."""
