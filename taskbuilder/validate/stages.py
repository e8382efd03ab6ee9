"""Environments of other interfaces, as multi-agent environments to be checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
from pettingzoo import AECEnv


class SingleAgent:
    """A Gymnasium environment as a multi-agent environment with one agent.

    Args:
        env: The environment.

    Attributes:
        plain: Whether the environment has no wrapper.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        self.unwrapped = env.unwrapped
        self.plain = env.unwrapped is env
        self.possible_agents = ["agent"]
        self.agents: list[str] = []
        self._env = env

    def reset(self, seed: int | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Reset the environment."""
        seen, info = self._env.reset(seed=seed)
        self.agents = ["agent"]
        return {"agent": seen}, {"agent": info}

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """Run a step with the action of the agent."""
        seen, reward, terminated, truncated, info = self._env.step(actions["agent"])
        if terminated or truncated:
            self.agents = []
        return tuple({"agent": told} for told in (seen, reward, terminated, truncated, info))

    def observation_space(self, _: str) -> Any:
        """The observation space of the agent."""
        return self._env.observation_space

    def action_space(self, _: str) -> Any:
        """The action space of the agent."""
        return self._env.action_space


class TurnBased:
    """A turn-based (AEC) environment as one in which all agents act at once.

    Every agent takes its turn, and then each is asked what it sees and is paid: by `last` where it
    is the agent's turn, else by `observe` and `rewards`. In the end, all are asked by `last`.

    Args:
        env: The environment.

    Attributes:
        plain: Whether the environment has no wrapper but PettingZoo's own, which check the order.
    """

    plain = True

    def __init__(self, env: AECEnv) -> None:
        self.unwrapped = env.unwrapped
        self.possible_agents: list[str] = list(env.possible_agents)
        self.agents: list[str] = []
        self._env = env
        if hasattr(env, "state_space") or hasattr(env.unwrapped, "state_space"):
            self.state = env.state

    def reset(self, seed: int | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Reset the environment."""
        self._env.reset(seed=seed)
        self.agents = list(self._env.agents)
        seen = {agent: self._env.observe(agent) for agent in self.agents}
        first = self._env.agent_selection
        seen[first], *_ = self._env.last()
        return seen, dict(self._env.infos)

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """Let every agent take its turn."""
        env = self._env
        for _ in actions:
            env.step(actions[env.agent_selection])
        agents = self.agents
        told = {
            agent: [
                env.observe(agent),
                env.rewards[agent],
                env.terminations[agent],
                env.truncations[agent],
                env.infos[agent],
            ]
            for agent in agents
        }
        told[env.agent_selection] = list(env.last())
        if all(env.terminations[agent] or env.truncations[agent] for agent in agents):
            self.agents = []
            for _ in agents:  # each takes note that it is over
                told[env.agent_selection] = list(env.last())
                env.step(None)
        return tuple({agent: told[agent][part] for agent in agents} for part in range(5))

    def observation_space(self, agent: str) -> Any:
        """The observation space of an agent."""
        return self._env.observation_space(agent)

    def action_space(self, agent: str) -> Any:
        """The action space of an agent."""
        return self._env.action_space(agent)
