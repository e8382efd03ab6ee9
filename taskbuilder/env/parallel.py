"""The multi-agent view: a PettingZoo ParallelEnv whose agents are the robots."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from taskbuilder.arguments import a_seed
from taskbuilder.env.camera import Camera
from taskbuilder.env.copying import Copyable
from taskbuilder.env.episode import Episode
from taskbuilder.env.episode_state import EpisodeState
from taskbuilder.env.errors import AgentError, EpisodeOverError
from taskbuilder.env.infos import make_info
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.observing import Observer
from taskbuilder.env.options import EnvOptions, Options, RenderMode, make_options
from taskbuilder.env.spaces import action_space, read_action
from taskbuilder.errors import UsageError
from taskbuilder.task import Task, load_task
from taskbuilder.world.pictures import capture

Observations = dict[str, Any]
Infos = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class EnvState:
    """A saved state, for `load_state`.

    It can be copied and pickled, and loaded in any environment of the same task and options.
    """

    episode: EpisodeState
    agents: tuple[str, ...]
    seeds: Mapping[str, Any]
    noise: Mapping[str, Any]


class TaskEnv(Copyable, ParallelEnv):  # type: ignore[misc]  # pettingzoo ships no types
    """A task as a multi-agent environment: a PettingZoo ParallelEnv whose agents are the robots.

    By default, each agent observes only the channels that the task file lists for it under
    ``observe``. The method `state` returns the state for centralised critics. All agents act at
    every step, and their episodes end together. The infos are dictionaries of numbers. They have
    the same keys for every agent, at every step and at every reset, except that the infos of
    `reset` also have the text "instruction".

    A copy (including one made by pickle) has its own physics engine. It rebuilds the scene and
    replays the actions of the current episode, because a snapshot of a physics engine belongs
    to this engine.

    Args:
        task: The task.
        options: The options of the environment.
        render_mode: "rgb_array" or None.

    Attributes:
        possible_agents: The names of the robots, in the order of the task file.
        agents: The names of the robots while an episode runs, otherwise empty.
        episode: The current episode; ``episode.world`` is its `World`.
    """

    def __init__(self, task: Task, options: Options, render_mode: str | None = None) -> None:
        self.metadata = {
            "name": f"{task.name}_v{task.version}",
            "render_modes": ["rgb_array"],
            "is_parallelizable": True,
            "render_fps": options.control_hz or task.file.spec.timing.control_hz,
        }
        self.render_mode = render_mode
        self.task = task
        self.options = options
        self.episode = Episode(task, options)
        self.possible_agents = list(task.agents)
        self.agents: list[str] = []
        self._observer = Observer(task, options, self.episode.world)
        self._generator: np.random.Generator | None = None
        self._last: Observations = {}
        self._noise: Mapping[str, Any] = {}  # of the generator before the last look

    def __repr__(self) -> str:
        agents = ", ".join(self.possible_agents)
        return f"<TaskEnv {self.task.name}: {agents}; {self.max_episode_steps} steps>"

    # --- spaces

    @cached_property
    def observation_spaces(self) -> dict[str, spaces.Space[Any]]:
        """The observation space of every agent."""
        return self._observer.agent_spaces()

    @cached_property
    def action_spaces(self) -> dict[str, spaces.Space[Any]]:
        """The action space of every agent."""
        flat, normalize = self.options.flat, self.options.normalize
        return {
            agent: action_space(actions, flat=flat, normalize=normalize)
            for agent, actions in self.episode.actions.items()
        }

    @cached_property
    def state_space(self) -> spaces.Box:
        """The space of `state`."""
        return self._observer.state_space()

    @cached_property
    def observation_names(self) -> dict[str, tuple[str, ...]]:
        """The name of each number that an agent observes, by agent, such as ``left.joint_3``.

        Images have none. With ``flat=False`` these are the numbers of all channels in order.
        """
        return self._observer.names()

    @property
    def action_names(self) -> dict[str, tuple[str, ...]]:
        """The name of each number of an agent's action, by agent, such as ``left.dx``."""
        return {agent: actions.names for agent, actions in self.episode.actions.items()}

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """The name of each number of `state`."""
        return self._observer.state_names()

    @property
    def mask_names(self) -> tuple[str, ...]:
        """The name of each number in a segmentation mask, such as ``left.wrist_3_link``.

        The names are the same in every episode, variation and process. Number 0 is the background.
        """
        return self.episode.world.segments.names

    def cameras(self) -> dict[str, Camera]:
        """The cameras of the scene as they are now, by name, with their matrices.

        The camera randomisation of the episode is included. Those on robots and other moving frames
        differ after every step.
        """
        return self._observer.cameras(self.episode.world)

    @property
    def observes_positions(self) -> bool:
        """Whether any agent observes a position."""
        return bool(self._observer.positions)

    @property
    def observed_pictures(self) -> frozenset[str]:
        """What agents observe of cameras: any of ``rgb``, ``depth``, ``mask`` and ``points``."""
        return self._observer.pictures

    @property
    def task_description(self) -> str:
        """The instruction of this episode, filled in; it depends on the seed and the variation."""
        return self.episode.instruction

    @property
    def max_episode_steps(self) -> int:
        """Length of an episode in control steps."""
        return self.episode.horizon

    @property
    def info_keys(self) -> tuple[str, ...]:
        """Keys of every agent's info."""
        return tuple(make_info(self.episode))

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """An agent's observation space; the same object at every call."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """An agent's action space; the same object at every call."""
        return self.action_spaces[agent]

    # --- stepping

    @property
    def _seeds(self) -> np.random.Generator:
        """Draws the seeds of episodes; made when first needed, as unseeded copies share none."""
        if self._generator is None:
            self._generator = np.random.default_rng()
        return self._generator

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, Infos]:
        """Reset the environment.

        Args:
            seed: Seed of this episode and, until the next seed, of all later ones.
            options: Not used; required by PettingZoo.

        Returns:
            The observations and the infos, which also have the ``instruction`` of the episode.

        Raises:
            PlacementError: The objects do not fit.
            UsageError: The seed is no whole number from 0 to 2**63 - 1, or the environment is
                closed.
        """
        del options
        if seed is not None:
            seed = a_seed(seed)
            self._generator = np.random.default_rng(seed)
        self.episode.reset(seed if seed is not None else int(self._seeds.integers(2**31)))
        self.agents = list(self.possible_agents)
        words = {"instruction": self.task_description}
        return self.observe(), {agent: info | words for agent, info in self._infos().items()}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Run one control step.

        Args:
            actions: An action for every agent. Numbers beyond the bounds are clipped.

        Raises:
            ActionError: An action is not finite, or of another shape or kind.
            AgentError: An agent's action is missing, or there is no such agent.
            EpisodeOverError: There was no reset, or the episode is over.
            UsageError: The environment is closed.
        """
        values = self._read(actions)
        episode = self.episode
        episode.step(values)
        agents = self.agents
        seen = deepcopy(self._last) if episode.exploded else self.observe()
        rewards = self._rewards()
        terminations = dict.fromkeys(agents, episode.terminated)
        truncations = dict.fromkeys(agents, episode.truncated)
        infos = self._infos()
        if episode.over:
            self.agents = []
        return seen, rewards, terminations, truncations, infos

    def observe(self) -> Observations:
        """The current observations of all agents, with new noise."""
        self._noise = self.episode.noise_rng.bit_generator.state
        self._last = self._observer.observe(self.episode)
        return self._last

    def _read(self, actions: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
        if self.episode.closed:
            raise UsageError("this environment is closed; make another")
        if self.episode.over or not self.agents:
            raise EpisodeOverError("no episode is running; call reset")
        if not isinstance(actions, Mapping):
            what = f"actions are a mapping by agent, not {type(actions).__name__}"
            raise AgentError(f"{what}; the agents are {', '.join(self.agents)}")
        missing = [agent for agent in self.agents if agent not in actions]
        unknown = [agent for agent in actions if agent not in self.agents]
        if missing or unknown:
            parts = [f"no action for {', '.join(missing)}"] if missing else []
            parts += [f"no agent {', '.join(map(str, unknown))}"] if unknown else []
            raise AgentError(f"{'; '.join(parts)}; the agents are {', '.join(self.agents)}")
        return {
            agent: read_action(agent, actions[agent], self.action_space(agent))
            for agent in self.agents
        }

    def _rewards(self) -> dict[str, float]:
        if self.options.reward == "local" and not self.episode.exploded:
            return dict(self.episode.outcome.local)
        return dict.fromkeys(self.agents, self.common_reward())

    def common_reward(self) -> float:
        """The reward that all agents share: the team reward, or the sparse one if that is set."""
        if self.options.reward != "sparse":
            return self.team_reward()
        return float(self.episode.outcome.success and not self.episode.exploded)

    def team_reward(self) -> float:
        """The team reward of the current control step; 0 after a divergence of the physics."""
        return 0.0 if self.episode.exploded else self.episode.outcome.team

    def _infos(self) -> Infos:
        info = make_info(self.episode)
        return {agent: dict(info) for agent in self.possible_agents}

    # --- state and rendering

    def state(self) -> NDArray[np.float32]:
        """The state for centralised critics, as listed in the task file under ``state``."""
        return self._observer.state(self.episode)

    def render(self) -> NDArray[np.uint8] | None:
        """An image of the scene: (height, width, 3) uint8, or None without a render mode."""
        if self.render_mode is None:
            return None
        world = self.episode.world
        camera = self.options.render_camera or next(iter(world.scene.cameras))
        world.move_markers()
        return capture(world, world.camera(camera), studio=True, shadow=True).rgb

    # --- saving and restoring

    def save_state(self) -> EnvState:
        """Save the state, including the random-number generators.

        It consists of the seed and the actions since the reset. A snapshot of the physics engine
        of about 250 KB is added where `load_state` can use it.

        Raises:
            UsageError: There was no reset, or the physics diverged.
        """
        episode, seeds = self.episode.save(), self._seeds.bit_generator.state
        return EnvState(episode, tuple(self.agents), seeds, self._noise)

    def load_state(self, state: EnvState) -> Observations:
        """Restore a saved state, bit for bit, so that the same actions have the same results.

        This takes about a millisecond where a snapshot of this environment's physics engine leads
        to the same. Otherwise the actions of the episode are played again, which takes the time of
        these control steps. While an episode goes on from a snapshot, a control step does that
        too, if robots or objects then touch in a way that the snapshot may not have prepared.

        Returns:
            The observations in that state.

        Raises:
            UsageError: It is no state, or one of another task or of other options; or its actions
                do not lead to it, because something else moved the world.
        """
        if not isinstance(state, EnvState):
            kind = type(state).__name__
            raise UsageError(f"a state is what save_state returned, not {kind}")
        self.episode.load(state.episode)
        self.agents = list(state.agents)
        self._seeds.bit_generator.state = state.seeds
        self.episode.noise_rng.bit_generator.state = state.noise  # the same noise again
        return self.observe()

    def close(self) -> None:
        """Close the environment."""
        self.episode.close()
        self.agents = []


@takes_options
def parallel_env(
    task: str | Path | Task,
    *,
    render_mode: RenderMode | None = None,
    **options: Unpack[EnvOptions],
) -> TaskEnv:
    """Make a PettingZoo ParallelEnv of a task.

    Args:
        task: Name or path of the task, or the task itself.
        render_mode: "rgb_array" if `render` should return images.
        options: Options of the environment; see `Options`.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of the task have errors.
        UsageError: An option does not fit the task.
    """
    loaded = task if isinstance(task, Task) else load_task(task)
    if render_mode not in (None, "rgb_array"):
        raise UsageError(f'render_mode is {render_mode!r}; "rgb_array" or None')
    return TaskEnv(loaded, make_options(**options), render_mode)
