"""The joint view: a Gymnasium environment in which one agent moves all robots."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, Self, Unpack

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from taskbuilder.env.camera import Camera
from taskbuilder.env.errors import ActionError
from taskbuilder.env.joint_observation import (
    JointObservation,
    PixelLayout,
    check_pixels,
    joined_boxes,
)
from taskbuilder.env.options import EnvOptions, RenderMode
from taskbuilder.env.parallel import EnvState, TaskEnv, parallel_env
from taskbuilder.env.spaces import read_action
from taskbuilder.task import Task


class JointEnv(gymnasium.Env[Any, Any]):
    """A task as a Gymnasium environment in which one agent controls all robots.

    The reward is the team reward or, with ``reward="sparse"``, the sparse reward. A flat
    observation is one array: the observations of the robots, concatenated in the order of the task
    file. A flat action is the concatenation of the robots' actions in the same order. If the robots
    observe images, a flat observation is a dictionary: the key ``agent_pos`` has the concatenated
    array, and a key such as ``pixels/front`` has the image of the camera ``front``. With
    ``flat=False``, observations and actions are dictionaries keyed by robot.

    Attributes:
        observation_names: Name of each element of a flat observation, or of ``agent_pos`` if there
            are images. A name consists of the robot and the quantity that this robot observes:
            ``left/stick.x``.
        action_names: Name of each element of a flat action, such as ``left.dx``.
        render_mode: "rgb_array" or None.

    Args:
        task: Name or path of the task, or the task itself.
        render_mode: "rgb_array" if `render` should return images.
        pixels: Arrangement of images in a flat observation. ``flat``: one key for each image, such
            as ``pixels/front``; Stable-Baselines3 needs this arrangement. ``nested``: the key
            ``pixels`` has a dictionary keyed by camera, as in LeRobot's environments.
        options: Options of the environment; see `taskbuilder.env.options.Options`. Because a
            `JointEnv` has one agent, the reward ``local`` is the same as ``team``.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of the task have errors.
        UsageError: An option does not fit the task.
    """

    _spec: EnvSpec | None = None
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012  # Gymnasium's

    def __init__(
        self,
        task: str | Path | Task,
        *,
        render_mode: RenderMode | None = None,
        pixels: PixelLayout = "flat",
        **options: Unpack[EnvOptions],
    ) -> None:
        check_pixels(pixels, flat=options.get("flat", True))
        self.parallel: TaskEnv = parallel_env(task, render_mode=render_mode, **options)
        self.metadata = {**self.metadata, "render_fps": self.parallel.metadata["render_fps"]}
        self.render_mode = render_mode
        self._agents = self.parallel.possible_agents
        observed = {agent: self.parallel.observation_space(agent) for agent in self._agents}
        acted = {agent: self.parallel.action_space(agent) for agent in self._agents}
        self._flat = self.parallel.options.flat
        self._joint = JointObservation(observed, pixels) if self._flat else None
        self.observation_space = self._joint.space if self._joint else spaces.Dict(observed)
        self.action_space = joined_boxes(acted) if self._flat else spaces.Dict(acted)
        self.observation_names = _joined_names(self.parallel.observation_names)
        self.action_names = tuple(
            name for names in self.parallel.action_names.values() for name in names
        )
        sizes = [actions.size for actions in self.parallel.episode.actions.values()]
        self._cuts = np.cumsum(sizes)[:-1]

    @property
    def spec(self) -> EnvSpec | None:
        """What Gymnasium made this environment of, with the length of its episodes."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = spec and replace(spec, max_episode_steps=self.max_episode_steps)

    @property
    def mask_names(self) -> tuple[str, ...]:
        """The name of each number in a segmentation mask; see `TaskEnv.mask_names`."""
        return self.parallel.mask_names

    def cameras(self) -> dict[str, Camera]:
        """The cameras of the scene as they are now; see `TaskEnv.cameras`."""
        return self.parallel.cameras()

    @property
    def task_description(self) -> str:
        """The instruction of this episode, filled in; it depends on the seed and the variation."""
        return self.parallel.task_description

    @property
    def max_episode_steps(self) -> int:
        """Length of an episode in control steps."""
        return self.parallel.max_episode_steps

    _max_episode_steps = max_episode_steps  # where Gymnasium's TimeLimit has it, and LeRobot reads

    def __copy__(self) -> Self:
        return deepcopy(self)  # a copy has a physics engine of its own

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset the environment.

        Args:
            seed: Seed of this episode and, until the next seed, of all later ones.
            options: Not used; required by Gymnasium.

        Returns:
            The observation and the info, which also has the ``instruction`` of the episode.
        """
        observations, infos = self.parallel.reset(seed=seed, options=options)  # checks the seed
        super().reset(seed=seed)
        return self._observation(observations), infos[self._agents[0]]

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Run one control step.

        Raises:
            ActionError: The action is not finite, or of another shape or kind.
            EpisodeOverError: There was no reset, or the episode is over.
        """
        observations, _, terminations, truncations, infos = self.parallel.step(self._split(action))
        first = self._agents[0]
        reward = self.parallel.common_reward()
        seen = self._observation(observations)
        return seen, reward, terminations[first], truncations[first], infos[first]

    def render(self) -> NDArray[np.uint8] | None:
        """An image of the scene: (height, width, 3) uint8, or None without a render mode."""
        return self.parallel.render()

    def save_state(self) -> EnvState:
        """Save the state of the environment; see `TaskEnv.save_state` for its limits."""
        return self.parallel.save_state()

    def load_state(self, state: EnvState) -> Any:
        """Restore a saved state of this environment, and return its observation."""
        return self._observation(self.parallel.load_state(state))

    def close(self) -> None:
        """Close the environment."""
        self.parallel.close()

    def _observation(self, observations: dict[str, Any]) -> Any:
        return self._joint.join(observations) if self._joint else dict(observations)

    def _split(self, action: Any) -> dict[str, Any]:
        if not self._flat:
            if not isinstance(action, Mapping):
                what = f"is {type(action).__name__}, not a mapping"
                raise ActionError("all robots", self.action_space, what)
            return dict(action)
        values = read_action("all robots", action, self.action_space)
        return dict(zip(self._agents, np.split(values, self._cuts), strict=True))


def _joined_names(names: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """The names of all observations in order, each with its observer."""
    return tuple(f"{agent}/{name}" for agent, own in names.items() for name in own)
