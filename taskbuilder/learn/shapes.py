"""Sizes of observations and actions, and their layout in a row of the replay buffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.float32]


@dataclass(frozen=True)
class Shapes:
    """The sizes of observations, actions and state.

    Attributes:
        observations: Size of each agent's observation, in the order of the agents.
        actions: Size of each agent's action.
        state: Size of the state that centralised critics observe besides the observations.
        grippers: Indices of the commands to grippers in the joint action.
    """

    observations: Mapping[str, int]
    actions: Mapping[str, int]
    state: int
    grippers: tuple[int, ...] = ()

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents, in order."""
        return tuple(self.observations)

    @property
    def critic_input(self) -> int:
        """Size of the input of centralised critics."""
        return sum(self.observations.values()) + self.state

    @property
    def joint_action(self) -> int:
        """Size of the joint action of all agents."""
        return sum(self.actions.values())

    def same_spaces(self) -> tuple[tuple[str, ...], ...]:
        """The agents, grouped by the sizes of their observations and actions."""
        groups: dict[tuple[int, int], list[str]] = {}
        for agent in self.agents:
            key = (self.observations[agent], self.actions[agent])
            groups.setdefault(key, []).append(agent)
        return tuple(tuple(group) for group in groups.values())

    @cached_property
    def layout(self) -> Layout:
        """The layout of a transition in a row of the replay buffer."""
        return Layout.of(self)


@dataclass(frozen=True)
class Layout:
    """The slices of a row that hold the parts of a transition.

    Attributes:
        observations: Observations by agent.
        state: The state.
        critic_input: The inputs of centralised critics: all observations and the state.
        actions: All agents' actions in order; `action` has them by agent.
        rewards: One reward per agent.
        ended: 1.0 if the episode ended with this step, for any reason.
        terminated: 1.0 if it ended by success or failure, and not by the time limit.
        demonstrated: 1.0 if the expert acted.
        extra_steps: Control steps of the transition beyond the first; see `NStepTransitions`.
        next_observations: Observations by agent after the step.
        next_state: The state after the step.
        next_critic_input: The inputs of centralised critics after the step.
        width: Numbers in a row.
    """

    observations: Mapping[str, slice]
    state: slice
    critic_input: slice
    actions: slice
    action: Mapping[str, slice]
    rewards: slice
    ended: slice
    terminated: slice
    demonstrated: slice
    extra_steps: slice
    next_observations: Mapping[str, slice]
    next_state: slice
    next_critic_input: slice
    width: int

    @classmethod
    def of(cls, shapes: Shapes) -> Layout:
        """The layout for given sizes, with the parts one after the other."""
        cut = _Cut()
        observations = {agent: cut(size) for agent, size in shapes.observations.items()}
        state = cut(shapes.state)
        action = {agent: cut(size) for agent, size in shapes.actions.items()}
        first = next(iter(action.values())).start
        actions = slice(first, cut.end)
        rewards, ended, terminated, demonstrated, extra_steps = (
            cut(size) for size in (len(shapes.agents), 1, 1, 1, 1)
        )
        next_start = cut.end
        next_observations = {agent: cut(size) for agent, size in shapes.observations.items()}
        next_state = cut(shapes.state)
        return cls(
            observations=observations,
            state=state,
            critic_input=slice(0, state.stop),
            actions=actions,
            action=action,
            rewards=rewards,
            ended=ended,
            terminated=terminated,
            demonstrated=demonstrated,
            extra_steps=extra_steps,
            next_observations=next_observations,
            next_state=next_state,
            next_critic_input=slice(next_start, cut.end),
            width=cut.end,
        )

    def observed(self, batch: Any) -> dict[str, Any]:
        """The observations by agent in rows: (n, ...) each."""
        return {agent: batch[:, part] for agent, part in self.observations.items()}

    def rows(
        self,
        observations: Mapping[str, NDArray[np.floating]],
        state: NDArray[np.floating],
        actions: Mapping[str, NDArray[np.floating]],
        rewards: NDArray[np.floating],
        ended: NDArray[np.bool_],
        terminated: NDArray[np.bool_],
        next_observations: Mapping[str, NDArray[np.floating]],
        next_state: NDArray[np.floating],
        *,
        demonstrated: bool = False,
    ) -> Rows:
        """Make rows of transitions: (n, width). Arguments have n rows; rewards are (n, agents)."""
        rows = np.empty((len(state), self.width), dtype=np.float32)
        for agent in self.observations:
            rows[:, self.observations[agent]] = observations[agent]
            rows[:, self.action[agent]] = actions[agent]
            rows[:, self.next_observations[agent]] = next_observations[agent]
        rows[:, self.state] = state
        rows[:, self.rewards] = rewards
        rows[:, self.ended] = ended[:, None]
        rows[:, self.terminated] = terminated[:, None]
        rows[:, self.demonstrated] = float(demonstrated)
        rows[:, self.extra_steps] = 0.0
        rows[:, self.next_state] = next_state
        return rows


class _Cut:
    """Makes consecutive slices."""

    def __init__(self) -> None:
        self.end = 0

    def __call__(self, size: int) -> slice:
        start, self.end = self.end, self.end + size
        return slice(start, self.end)


def joined(parts: Mapping[str, NDArray[np.floating]], order: Sequence[str]) -> Rows:
    """Concatenate arrays by agent along the last axis, in the order of the agents."""
    return np.concatenate([parts[agent] for agent in order], axis=-1).astype(np.float32)
