"""The sizes that learners go by, and where they lie in a row of the replay memory."""

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
    """How many numbers observations and actions have.

    Attributes:
        observations: Numbers that each agent sees, by agent, in the order of the agents.
        actions: Numbers of each agent's action, by agent.
        state: Numbers that centralised critics see besides the observations.
    """

    observations: Mapping[str, int]
    actions: Mapping[str, int]
    state: int

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents, in order."""
        return tuple(self.observations)

    @property
    def critic_input(self) -> int:
        """Numbers that centralised critics see."""
        return sum(self.observations.values()) + self.state

    @property
    def joint_action(self) -> int:
        """Numbers of all agents' actions together."""
        return sum(self.actions.values())

    def same_spaces(self) -> tuple[tuple[str, ...], ...]:
        """The agents, those whose observations and actions have the same sizes together."""
        groups: dict[tuple[int, int], list[str]] = {}
        for agent in self.agents:
            key = (self.observations[agent], self.actions[agent])
            groups.setdefault(key, []).append(agent)
        return tuple(tuple(group) for group in groups.values())

    @cached_property
    def layout(self) -> Layout:
        """Where a transition's parts lie in a row of the replay memory."""
        return Layout.of(self)


@dataclass(frozen=True)
class Layout:
    """Where the parts of a transition lie in a row of numbers.

    Attributes:
        observations: By agent.
        state: What critics see besides.
        critic_input: All observations and the state: what critics see.
        actions: Of all agents, in order; `action` has each one's.
        rewards: A number an agent.
        ended: 1.0 where the episode ended with this step, by whatever.
        terminated: 1.0 where it ended by success or failure, not by its length.
        demonstrated: 1.0 where an expert acted.
        next_observations: By agent, after the step.
        next_state: After the step.
        next_critic_input: After the step.
        width: Numbers of a row.
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
    next_observations: Mapping[str, slice]
    next_state: slice
    next_critic_input: slice
    width: int

    @classmethod
    def of(cls, shapes: Shapes) -> Layout:
        """Lay the parts out one after the other."""
        cut = _Cut()
        observations = {agent: cut(size) for agent, size in shapes.observations.items()}
        state = cut(shapes.state)
        action = {agent: cut(size) for agent, size in shapes.actions.items()}
        first = next(iter(action.values())).start
        actions = slice(first, cut.end)
        rewards, ended, terminated, demonstrated = (
            cut(size) for size in (len(shapes.agents), 1, 1, 1)
        )
        later = cut.end
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
            next_observations=next_observations,
            next_state=next_state,
            next_critic_input=slice(later, cut.end),
            width=cut.end,
        )

    def observed(self, batch: Any) -> dict[str, Any]:
        """What the agents observe in rows: (n, ...) each."""
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
        """Lay transitions out: (n, width). Arguments have a row for each; rewards (n, agents)."""
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
        rows[:, self.next_state] = next_state
        return rows


class _Cut:
    """Cuts slices off, one after the other."""

    def __init__(self) -> None:
        self.end = 0

    def __call__(self, size: int) -> slice:
        start, self.end = self.end, self.end + size
        return slice(start, self.end)


def joined(parts: Mapping[str, NDArray[np.floating]], order: Sequence[str]) -> Rows:
    """Arrays by agent as one, the agents in order along the last axis."""
    return np.concatenate([parts[agent] for agent in order], axis=-1).astype(np.float32)
