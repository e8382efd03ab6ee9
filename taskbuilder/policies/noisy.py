"""The expert with noise, whose episodes show how mistakes are made good."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.script.player import Expert
from taskbuilder.rollout.record import ScriptLog


class NoisyExpert:
    """The expert with Gaussian noise on the numbers of the arms; grippers have none.

    The expert corrects what the noise has done: within a motion at the next control step, and at
    its end until the goal is reached. So its episodes show how to come back to the way (DART,
    Laskey et al. 2017).

    A robot that holds a moving link of a fixed object, such as a door, has no noise either: its
    hand can only move with the link, and noise would not lead it off its way but tear it away.

    Args:
        env: An environment of the task.
        spread: Standard deviation, where actions are from -1 to 1.
        share: Share of the control steps that have noise, drawn for each robot.
    """

    def __init__(self, env: TaskEnv, spread: float, share: float = 1.0) -> None:
        self._expert = Expert(env, disturbed=spread * share > 0.0)
        self._spread, self._share = spread, share

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode; the seed determines the noise."""
        self._expert.reset(env, seed)
        # Apart from the generators of the episode and of random actions.
        self._rng = np.random.default_rng([seed, 3])

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The expert's actions with noise, from -1 to 1."""
        actions = self._expert.act(observations)
        if actions is None:
            return None
        noisy = {}
        episode = self._expert.env.episode
        for agent, action in actions.items():
            noise = self._rng.normal(0.0, self._spread, len(action))
            # What is drawn depends on nothing that happens.
            spared = self._share < 1.0 and self._rng.random() >= self._share
            if spared or any(episode.world.held(link, agent) for link in episode.world.mechanisms):
                noise[:] = 0.0
            noise[episode.actions[agent].arm_size :] = 0.0
            noisy[agent] = np.clip(action + noise, -1.0, 1.0).astype(np.float32)
        return noisy

    def log(self) -> ScriptLog:
        """The log of the expert's stages."""
        return self._expert.log()

    def close(self) -> None:
        """Free what the expert holds."""
        self._expert.close()
