"""The joint vector view: Gymnasium's vector environment in which one agent moves all robots."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from taskbuilder.env.errors import ActionError
from taskbuilder.env.joint_observation import (
    JointObservation,
    PixelLayout,
    check_pixels,
    joined_boxes,
)
from taskbuilder.env.options import EnvOptions
from taskbuilder.env.vector import Flags, TaskVectorEnv, make_vec
from taskbuilder.task import Task


class JointVectorEnv(VectorEnv[Any, Any, Any]):
    """Parallel environments of a task, each as a `JointEnv` has it; `gymnasium.make_vec` makes it.

    Observations and actions have one row per environment, and rewards are one array. With the same
    seeds and actions, the environments give the same numbers as those of Gymnasium's
    `SyncVectorEnv`.

    Attributes:
        parallel: The environments with observations, actions and rewards by agent.

    Args:
        task: Name or path of the task, or the task itself.
        num_envs: Number of environments.
        workers: Number of worker processes; with 0, all environments run in the calling process.
        pixels: Arrangement of images in a flat observation; see `JointEnv`.
        autoreset: Gymnasium's autoreset mode, "NextStep" or "SameStep".
        options: Options of the environments; see `Options`.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of the task have errors.
        UsageError: An argument is invalid, or an option does not fit the task.
        WorkerError: A worker process does not start.
    """

    def __init__(
        self,
        task: str | Path | Task,
        num_envs: int = 1,
        *,
        workers: int = 0,
        pixels: PixelLayout = "flat",
        autoreset: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **options: Unpack[EnvOptions],
    ) -> None:
        flat = options.get("flat", True)
        check_pixels(pixels, flat=flat)
        if options.get("reward") == "local":  # one agent gets the reward of all
            options["reward"] = "team"
        self.parallel: TaskVectorEnv = make_vec(
            task, num_envs, workers, autoreset=autoreset, **options
        )
        self.num_envs, self.metadata = num_envs, dict(self.parallel.metadata)
        self._joint: JointObservation | None = None
        self.single_observation_space = self.parallel.single_observation_space
        self.single_action_space = self.parallel.single_action_space
        if flat:
            signature = self.parallel.config.signature
            acted = signature.action_spaces
            self._joint = JointObservation(signature.observation_spaces, pixels)
            self._cuts = np.cumsum([spaces.flatdim(space) for space in acted.values()])[:-1]
            self.single_observation_space = self._joint.space
            self.single_action_space = joined_boxes(acted)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Reset every environment; see `TaskVectorEnv.reset`."""
        observations, infos = self.parallel.reset(seed=seed, options=options)
        return self._joined(observations), infos

    def step(self, actions: Any) -> tuple[Any, NDArray[np.float64], Flags, Flags, dict[str, Any]]:
        """Run one control step in every environment.

        Args:
            actions: (num_envs, n); with ``flat=False``, such arrays by agent.

        Returns:
            Observations, team rewards ((num_envs,) float64), terminations and truncations
            ((num_envs,) bool), and infos.

        Raises:
            ActionError: Actions are not finite, or of another shape or kind.
            EpisodeOverError: There was no reset, or not since a step that was interrupted.
            UsageError: The environment is closed.
            WorkerError: A worker is lost repeatedly.
        """
        seen, rewards, terminations, truncations, infos = self.parallel.step(self._split(actions))
        if "final_obs" in infos:
            for row in np.flatnonzero(infos["_final_obs"]):
                infos["final_obs"][row] = self._joined(infos["final_obs"][row])
        reward = rewards[self.parallel.agents[0]]
        return self._joined(seen), reward, terminations, truncations, infos

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments and end the workers."""
        self.parallel.close(**kwargs)

    def _joined(self, observations: dict[str, Any]) -> Any:
        return self._joint.join(observations) if self._joint else observations

    def _split(self, actions: Any) -> dict[str, Any]:
        if self._joint is None:
            return dict(actions)
        given = np.asarray(actions)
        if given.shape != self.action_space.shape:
            raise ActionError("all robots", self.action_space, f"has shape {given.shape}")
        parts = np.split(given, self._cuts, axis=-1)
        return dict(zip(self.parallel.agents, parts, strict=True))
