"""Some of a vector's environments, stepped one after the other in one process."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from taskbuilder.env.options import Options
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.shared_buffers import SharedBuffers
from taskbuilder.env.spaces import ACTION_PARTS
from taskbuilder.task import Task

Wrap = Callable[[TaskEnv], Any]
"""Wraps an environment; it is sent to workers by pickle."""


def unwrapped(env: TaskEnv) -> TaskEnv:
    """Return the environment without a wrapper."""
    return env


class EnvGroup:
    """Environments that read actions from shared buffers and write the results to them.

    Args:
        task: The task.
        options: The options of the environments.
        wrap: Wraps each environment.
        buffers: The shared arrays.
        rows: The rows of this group.
        same_step: Whether an ended episode is followed by a reset within the same step.
    """

    def __init__(
        self,
        task: Task,
        options: Options,
        wrap: Wrap,
        buffers: SharedBuffers,
        rows: range,
        *,
        same_step: bool,
    ) -> None:
        self._buffers = buffers
        self._same_step = same_step
        self._envs = {row: wrap(TaskEnv(task, options)) for row in rows}

    @property
    def envs(self) -> tuple[Any, ...]:
        """The environments, by row."""
        return tuple(self._envs.values())

    def advance(self) -> None:
        """Reset or step every environment, as the buffers say."""
        buffers = self._buffers
        for row, env in self._envs.items():
            if buffers.begin[row]:
                buffers.rewards[row] = 0.0
                buffers.terminated[row] = buffers.truncated[row] = False
                self._begin(row, env)
            else:
                self._act(row, env)

    def close(self) -> None:
        """Close the environments."""
        for env in self._envs.values():
            env.close()

    def _begin(self, row: int, env: TaskEnv) -> None:
        observations, infos = env.reset(seed=int(self._buffers.seeds[row]))
        first = env.possible_agents[0]  # infos are the same for all
        self._buffers.now.write(row, observations, env.state(), infos[first])
        self._buffers.instructions[row] = env.unwrapped.task_description.encode()

    def _act(self, row: int, env: TaskEnv) -> None:
        buffers = self._buffers
        first = env.possible_agents[0]  # all end together, and infos are the same for all
        observations, rewards, terminations, truncations, infos = env.step(self._actions(row, env))
        buffers.rewards[row] = [rewards[agent] for agent in env.possible_agents]
        buffers.terminated[row] = terminations[first]
        buffers.truncated[row] = truncations[first]
        another = self._same_step and not env.agents
        view = buffers.final if another else buffers.now
        view.write(row, observations, env.state(), infos[first])
        if another:
            self._begin(row, env)

    def _actions(self, row: int, env: TaskEnv) -> dict[str, Any]:
        """Copies, because environments keep their last action and rows of buffers change."""
        return {
            agent: _parted(values[row].copy(), env.action_space(agent))
            for agent, values in self._buffers.actions.items()
        }


def _parted(values: NDArray[np.float64], space: spaces.Space[Any]) -> Any:
    if isinstance(space, spaces.Dict):
        sizes = [math.prod(space[key].shape or ()) for key in ACTION_PARTS if key in space.spaces]
        parts = np.split(values, np.cumsum(sizes)[:-1])
        return dict(zip(ACTION_PARTS, parts, strict=False))
    return values
