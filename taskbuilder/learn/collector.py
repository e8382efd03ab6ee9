"""Collecting experience from parallel environments under a training reward."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.vector import TaskVectorEnv
from taskbuilder.learn.shapes import Rows, Shapes
from taskbuilder.learn.training_rewards import TrainingReward

AgentArrays = Mapping[str, NDArray[np.float32]]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Finished:
    """The result of a training episode.

    Attributes:
        steps: Length in control steps.
        success: Whether the episode succeeded; see `Episode`.
        stage: The last stage reached, 0 for none.
        team_return: Sum of the task's team reward.
        training_return: Sum of the training reward, as the mean over the agents.
        terms: Sum of every reward term, by label.
    """

    steps: int
    success: bool
    stage: int
    team_return: float
    training_return: float
    terms: Mapping[str, float]


class Tally:
    """Accumulates rewards and results in the current episode of each environment."""

    def __init__(self, num_envs: int) -> None:
        self._sums: dict[str, NDArray[np.float64]] = {}
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._stage = np.zeros(num_envs)
        self._success = np.zeros(num_envs, dtype=np.bool_)

    def begin(self, rows: NDArray[np.bool_]) -> None:
        """Start episodes in these rows."""
        for values in (*self._sums.values(), self._steps, self._stage, self._success):
            values[rows] = 0

    def add(self, infos: Mapping[str, Any], rewards: NDArray[np.float64]) -> None:
        """Add a step of every environment."""
        parts = {"team": infos["team_reward"], "training": rewards.mean(1)}
        parts |= {name: value for name, value in infos.items() if name.startswith("reward/")}
        for name, value in parts.items():
            self._sums.setdefault(name, np.zeros(len(self._steps)))[:] += value
        self._steps += 1
        self._stage = np.maximum(self._stage, infos["stage"])
        self._success |= infos["succeeded"] > 0.0

    def finished(self, rows: NDArray[np.bool_]) -> Iterator[Finished]:
        """The results of the episodes that ended in these rows."""
        for row in np.flatnonzero(rows):
            sums = {name: float(values[row]) for name, values in self._sums.items()}
            terms = {n.removeprefix("reward/"): v for n, v in sums.items() if "reward/" in n}
            yield Finished(
                int(self._steps[row]),
                bool(self._success[row]),
                int(self._stage[row]),
                sums["team"],
                sums["training"],
                terms,
            )


class Collector:
    """Steps environments, and makes rows for the replay buffer.

    Args:
        envs: The vector environment, which resets ended episodes within the same step.
        reward: The training reward.
        shapes: The sizes of observations and state, with the training reward's features.

    Attributes:
        observations: The current observations: (num_envs, n) each.
    """

    def __init__(self, envs: TaskVectorEnv, reward: TrainingReward, shapes: Shapes) -> None:
        self._envs, self._reward, self._layout = envs, reward, shapes.layout
        self.observations: dict[str, NDArray[np.float32]] = {}
        self._state: NDArray[np.float32] = np.zeros((0, 0), dtype=np.float32)
        self._tally = Tally(envs.num_envs)
        self._actions: AgentArrays = {}

    def begin(self, seed: int) -> None:
        """Reset all environments."""
        self.observations, infos = self._envs.reset(seed=seed)
        everywhere = np.ones(self._envs.num_envs, dtype=np.bool_)
        self._reward.begin(infos, everywhere)
        self._tally.begin(everywhere)
        self._state = self._critic_state()

    def _critic_state(self) -> NDArray[np.float32]:
        return np.concatenate([self._envs.state(), self._reward.critic_features()], 1)

    def step_async(self, actions: AgentArrays) -> None:
        """Start a step of all environments, without waiting for workers."""
        self._actions = actions
        self._envs.step_async(dict(actions))

    def step_wait(self) -> tuple[Rows, Flags, Sequence[Finished]]:
        """Wait for the step to finish.

        Returns:
            A row for each environment's transition; (num_envs,) bool, where the transition was lost
            with its worker; and the episodes that ended.
        """
        observations, rewards, terminated, truncated, infos = self._envs.step_wait()
        ended = terminated | truncated
        final, next_observations, next_envs = infos, observations, self._envs.state()
        if ended.any():
            final = {
                key: np.where(ended, infos["final_info"][key], infos[key])
                for key in infos["final_info"]
            }
            next_observations = _replaced(observations, infos["final_obs"], ended)
            next_envs = np.where(ended[:, None], infos["final_state"], next_envs)
        rewarded = self._reward.compute(np.stack([rewards[a] for a in self._envs.agents], 1), final)
        next_state = np.concatenate([next_envs, self._reward.critic_features()], 1)
        rows = self._layout.rows(
            self.observations,
            self._state,
            self._actions,
            rewarded,
            ended,
            terminated,
            next_observations,
            next_state,
        )
        lost = final["lost"] > 0.0
        self._tally.add(final, rewarded)
        finished = list(self._tally.finished(ended & ~lost))
        self._tally.begin(ended)
        self._reward.begin(infos, ended)
        self.observations, self._state = observations, self._critic_state()
        return rows, lost, finished


def _replaced(
    observations: AgentArrays, finals: NDArray[np.object_], rows: NDArray[np.bool_]
) -> dict[str, NDArray[np.float32]]:
    replaced = {agent: values.copy() for agent, values in observations.items()}
    for row in np.flatnonzero(rows):
        for agent, values in replaced.items():
            values[row] = finals[row][agent]
    return replaced
