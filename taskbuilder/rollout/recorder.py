"""Recording an episode while it is played."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.description import Outcome
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.rollout.record import BY_STATE, BY_STEP, Rollout, ScriptLog
from taskbuilder.world.pictures import capture


class Recorder:
    """Records an episode of an environment while other code steps it.

    Args:
        env: The environment.
        observations: Record the observations of every agent.
        cameras: Cameras of the scene to record images of.
        size: Width and height of the images; by default each camera's own.
        forces: Record the force between robots.

    Attributes:
        env: The environment.
        latest: The current observations.

    Raises:
        UsageError: Its actions are dictionaries.
    """

    def __init__(
        self,
        env: TaskEnv,
        *,
        observations: bool = False,
        cameras: Sequence[str] = (),
        size: tuple[int, int] | None = None,
        forces: bool = False,
    ) -> None:
        if not env.options.flat:
            raise UsageError("rollouts have flat actions; make the environment with flat=True")
        self.env = env
        self.latest: Mapping[str, Any] = {}
        self._cameras, self._size, self._observing = tuple(cameras), size, observations
        self._metering = forces
        if forces:
            env.episode.meter_robots()
        self._seed = 0
        self._disturbed: Mapping[str, Any] = {}
        self._before: Rollout | None = None
        self._actions: list[Mapping[str, Any]] = []
        self._rewards: list[Mapping[str, float]] = []
        self._team: list[float] = []
        self._outcomes: list[Outcome] = []
        self._succeeded: list[bool] = []
        self._observations: list[Mapping[str, Any]] = []
        self._pictures: list[Mapping[str, Any]] = []
        self._forces: list[float] = []

    def begin(self, seed: int, observations: Mapping[str, Any]) -> None:
        """Record the state after reset."""
        self._seed, self._disturbed = seed, self.env.episode.disturbed
        self._note_state(observations)

    def take_over(self, before: Rollout, observations: Mapping[str, Any]) -> None:
        """Continue the record of an episode from its end."""
        self._before = before
        self.begin(before.seed, observations)

    def add(
        self,
        actions: Mapping[str, Any],
        observations: Mapping[str, Any],
        rewards: Mapping[str, float],
    ) -> None:
        """Record a control step and the state after it."""
        self._actions.append(actions)
        self._rewards.append(rewards)
        self._team.append(self.env.team_reward())
        self._note_state(observations)

    def _note_state(self, observations: Mapping[str, Any]) -> None:
        self.latest = observations
        self._outcomes.append(self.env.episode.outcome)
        self._succeeded.append(self.env.episode.succeeded)
        if self._observing:
            self._observations.append(observations)
        if self._metering:
            last = self._forces[-1] if self._forces else 0.0
            episode = self.env.episode
            self._forces.append(last if episode.exploded else episode.robot_force())
        if self._cameras and not self.env.episode.exploded:
            self._pictures.append({name: self._picture(name) for name in self._cameras})

    def _picture(self, camera: str) -> Any:
        world = self.env.episode.world
        world.move_markers()
        return capture(world, world.camera(camera, self._size), studio=True, shadow=True).rgb

    def rollout(self, log: ScriptLog | None = None) -> Rollout:
        """The record of the episode so far.

        Args:
            log: The log of the expert's stages, if one played.
        """
        env, task = self.env, self.env.task
        episode = env.episode
        outcomes = self._outcomes
        if episode.exploded:  # then there is no reward and no new state
            outcomes = [*outcomes[:-1], _without_rewards(outcomes[-1])]
        after = outcomes[1:]
        found = Rollout(
            task=task.name,
            seed=self._seed,
            variation=episode.variation,
            options=env.options,
            control_hz=env.options.control_hz or task.file.spec.timing.control_hz,
            horizon=episode.horizon,
            stages=tuple(task.description.stages),
            actions={agent: self._actions_of(agent) for agent in env.possible_agents},
            rewards=np.array(self._team, dtype=np.float64),
            agent_rewards={
                agent: np.array([rewards[agent] for rewards in self._rewards], dtype=np.float64)
                for agent in env.possible_agents
            },
            terms={
                label: np.array([outcome.terms[label] for outcome in after], dtype=np.float64)
                for label in outcomes[0].terms
            },
            conditions={
                name: np.array([outcome.conditions[name] for outcome in outcomes], dtype=np.bool_)
                for name in outcomes[0].conditions
            },
            stage=np.array([outcome.stage for outcome in outcomes], dtype=np.int64),
            progress=np.array([outcome.progress for outcome in outcomes], dtype=np.float64),
            succeeded=np.array(self._succeeded, dtype=np.bool_),
            exploded=episode.exploded,
            observations=_stacked(self._observations),
            pictures=_stacked(self._pictures),
            robot_force=np.array(self._forces, dtype=np.float64),
            log=log,
            disturbed=self._disturbed,
        )
        return found if self._before is None else _joined(self._before, found)

    def _actions_of(self, agent: str) -> NDArray[np.float32]:
        size = self.env.episode.actions[agent].size
        chosen = [actions[agent] for actions in self._actions]
        return np.array(chosen, dtype=np.float32).reshape(-1, size)


def _without_rewards(outcome: Outcome) -> Outcome:
    return replace(outcome, terms=dict.fromkeys(outcome.terms, 0.0))


def _stacked(parts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Stack the arrays of every key; mappings may be nested."""
    if not parts:
        return {}
    return {
        key: _stacked([part[key] for part in parts])
        if isinstance(first, Mapping)
        else np.stack([part[key] for part in parts])
        for key, first in parts[0].items()
    }


def _joined(before: Rollout, rest: Rollout) -> Rollout:
    """Join two parts of an episode; the second begins with the last state of the first."""

    def join(one: Any, other: Any, first: int) -> Any:
        if isinstance(one, Mapping):
            return {name: join(one[name], other[name], first) for name in one}
        return np.concatenate([one, other[first:]])

    by_state = (*BY_STATE, "robot_force") if len(rest.robot_force) else BY_STATE
    return replace(
        rest,
        **{name: join(getattr(before, name), getattr(rest, name), 0) for name in BY_STEP},
        **{name: join(getattr(before, name), getattr(rest, name), 1) for name in by_state},
    )
