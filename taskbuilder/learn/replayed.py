"""Observations of recorded episodes that were not recorded: the episodes are played again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.data.dataset import RecordedEpisode
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError
from taskbuilder.policies.trained import Array32
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import RecordedActions
from taskbuilder.task import Task

SAME_REWARD = 1e-3
"""Greatest difference of a reward between an episode and its replay on another machine."""


@dataclass(frozen=True)
class Replayer:
    """Plays recorded episodes again, with other observations.

    Attributes:
        task: The task.
        options: Options of the environment, besides the variation.
    """

    task: Task
    options: Mapping[str, Any]

    def observations(self, episodes: Iterable[RecordedEpisode]) -> Iterator[Mapping[str, Array32]]:
        """What the agents observe before each control step: (steps, numbers) by agent.

        Raises:
            UsageError: An episode does not happen again as it was recorded.
        """
        with ExitStack() as stack:
            envs: dict[int, TaskEnv] = {}
            for episode in episodes:
                number = episode.variation
                if number not in envs:
                    options = {**self.options, "variation": number, "cameras": ()}
                    made = closing(parallel_env(self.task, **options))
                    envs[number] = stack.enter_context(made)
                yield self._observed(envs[number], episode)

    def _observed(self, env: TaskEnv, episode: RecordedEpisode) -> Mapping[str, Array32]:
        played = play(env, RecordedActions(episode.actions), episode.seed, observations=True)
        if not _same(played.rewards, episode.team_reward):
            raise UsageError(
                f"{episode.name} does not happen again as it was recorded, so what the task file "
                "lists cannot be observed; collect another data set, with --observe task"
            )
        return {
            agent: (values[VECTOR] if isinstance(values, Mapping) else values)[:-1]
            for agent, values in played.observations.items()
        }


def _same(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    return len(one) == len(other) and bool(np.allclose(one, other, atol=SAME_REWARD))


def joined(parts: Sequence[Mapping[str, Array32]]) -> dict[str, Array32]:
    """The observations of several episodes, one after the other, by agent."""
    return {agent: np.concatenate([part[agent] for part in parts]) for agent in parts[0]}
