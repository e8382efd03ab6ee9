"""Tasks as LeRobot's evaluation plays them, without LeRobot.

`make_env` is the function that LeRobot looks for in the ``env.py`` of a repository on the Hub. An
exported data set comes with an ``env.py`` that makes the environment it was recorded in. The class
`LeRobotEnv` is registered with Gymnasium as ``taskbuilder/LeRobot-v0``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, Unpack

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv, VectorEnv
from numpy.typing import NDArray

from taskbuilder.env.joint import JointEnv
from taskbuilder.env.joint_observation import AGENT_POS, PIXELS
from taskbuilder.env.joint_state import JointState
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import EnvOptions, from_json
from taskbuilder.errors import UsageError
from taskbuilder.task import Task

SUITE = "taskbuilder"
"""Name of the suite in LeRobot's results; its tasks are numbered in the order given."""


_MOST = 200.0  # rad or m, further than any joint goes


class LeRobotEnv(gymnasium.Env[Any, Any]):
    """A task as LeRobot's policies see it, in the terms of its exported data sets.

    The observation is a dictionary of ``agent_pos``, the joint positions and gripper openings of
    all robots (``observation.state`` of a data set), and of ``pixels``, the image of each camera
    (``observation.images.CAMERA``). The action is that of all robots, from -1 to 1.

    Attributes:
        task: The id of the task.
        state_names: Name of each number of ``agent_pos``, such as ``left.joint_1``.
        action_names: Name of each number of the action, such as ``left.dx``.
        render_mode: Always "rgb_array".

    Args:
        task: Name or path of the task, or the task itself.
        render_mode: "rgb_array"; LeRobot films its episodes.
        options: See `taskbuilder.env.options.Options`; ``flat`` and ``normalize`` keep their
            defaults.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of the task have errors.
        UsageError: An option does not fit the task.
    """

    metadata = JointEnv.metadata

    def __init__(
        self,
        task: str | Path | Task,
        *,
        render_mode: Literal["rgb_array"] = "rgb_array",
        **options: Unpack[EnvOptions],
    ) -> None:
        for name in ("flat", "normalize"):
            if not options.get(name, True):
                raise UsageError(f"{name}=False is not for LeRobot, whose actions are one array")
        self._joint = JointEnv(task, render_mode=render_mode, pixels="nested", **from_json(options))
        self.task = self._joint.parallel.task.name
        self.metadata = self._joint.metadata
        self.render_mode = render_mode
        self.action_space = self._joint.action_space
        self.action_names = self._joint.action_names
        self._state = JointState(self._joint.parallel)
        self.state_names = self._state.names
        shape = (len(self.state_names),)
        seen: dict[str, spaces.Space[Any]] = {
            AGENT_POS: spaces.Box(-_MOST, _MOST, shape, dtype=np.float32)
        }
        joint_space = self._joint.observation_space
        if isinstance(joint_space, spaces.Dict) and PIXELS in joint_space.spaces:
            seen[PIXELS] = joint_space[PIXELS]
        self._pictured = PIXELS in seen
        self.observation_space = spaces.Dict(seen)

    @property
    def task_description(self) -> str:
        """The instruction of this episode, filled in."""
        return self._joint.task_description

    @property
    def max_episode_steps(self) -> int:
        """Length of an episode in control steps."""
        return self._joint.max_episode_steps

    _max_episode_steps = max_episode_steps  # where LeRobot reads it

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Reset the environment; see `JointEnv.reset`."""
        observation, info = self._joint.reset(seed=seed, options=options)  # checks the seed
        super().reset(seed=seed)
        return self._seen(observation), _as_told(info)

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Run one control step; see `JointEnv.step`."""
        observation, reward, terminated, truncated, info = self._joint.step(action)
        return self._seen(observation), reward, terminated, truncated, _as_told(info)

    def render(self) -> NDArray[np.uint8] | None:
        """An image of the scene: (height, width, 3) uint8."""
        return self._joint.render()

    def close(self) -> None:
        """Close the environment."""
        self._joint.close()

    def _seen(self, observation: Any) -> dict[str, Any]:
        seen: dict[str, Any] = {AGENT_POS: self._state()}
        if self._pictured:
            seen[PIXELS] = observation[PIXELS]
        return seen


@takes_options
def make_env(
    n_envs: int = 1,
    use_async_envs: bool = False,  # LeRobot's
    cfg: object = None,
    *,
    tasks: Sequence[str | Path | Task] = ("handover",),
    **options: Unpack[EnvOptions],
) -> dict[str, dict[int, VectorEnv[Any, Any, Any]]]:
    """Make the environments of an evaluation, as LeRobot asks for them.

    Args:
        n_envs: Environments of each task, which are stepped together.
        use_async_envs: Step each in a process of its own.
        cfg: LeRobot's configuration of the environment; not used.
        tasks: Names or paths of the tasks.
        options: See `LeRobotEnv`.

    Returns:
        By suite, of which there is one, and by number of the task.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of a task have errors.
        UsageError: An option does not fit a task, or there are no tasks or environments.
    """
    del cfg
    if n_envs < 1:
        raise UsageError(f"n_envs is {n_envs}; at least 1")
    if isinstance(tasks, str) or not tasks:
        raise UsageError('tasks is a list of names or paths, such as ["handover"]')
    return {
        SUITE: {
            number: _vector(partial(LeRobotEnv, task, **options), n_envs, apart=use_async_envs)
            for number, task in enumerate(tasks)
        }
    }


def _vector(make: partial[LeRobotEnv], count: int, *, apart: bool) -> VectorEnv[Any, Any, Any]:
    kind = _ProcessEnvs if apart else SyncVectorEnv
    return kind([make] * count, autoreset_mode=AutoresetMode.SAME_STEP)


class _Told(NamedTuple):
    """What LeRobot looks for in an environment of another process."""

    task: str = ""
    task_description: str = ""


class _ProcessEnvs(AsyncVectorEnv):
    """Environments in processes of their own.

    Attributes:
        envs: Stand-ins, because LeRobot looks here for what an environment has; it reads the
            values by ``call``.
    """

    @property
    def envs(self) -> tuple[_Told, ...]:
        return (_Told(),) * self.num_envs


def _as_told(info: Mapping[str, Any]) -> dict[str, Any]:
    """The infos with a truth value where LeRobot reads one."""
    return {**info, "is_success": bool(info["is_success"])}
