"""Checking the actions and seeds that are passed to a vector environment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from taskbuilder.arguments import a_seed
from taskbuilder.env.errors import ActionError, AgentError
from taskbuilder.env.shared_buffers import Signature
from taskbuilder.env.spaces import ACTION_PARTS
from taskbuilder.errors import UsageError


def read_actions(
    actions: Any, signature: Signature, num_envs: int
) -> dict[str, NDArray[np.float64]]:
    """Every agent's actions: (num_envs, n) float64, checked but not clipped.

    Raises:
        AgentError: It is no mapping, an agent's actions are missing, or there is no such agent.
        ActionError: Actions are not finite, or of another shape or kind.
    """
    agents = ", ".join(signature.agents)
    if not isinstance(actions, Mapping):
        kind = type(actions).__name__
        raise AgentError(f"actions are a mapping from agent to array, not {kind}; agents: {agents}")
    missing = [agent for agent in signature.agents if agent not in actions]
    unknown = [agent for agent in actions if agent not in signature.agents]
    if missing or unknown:
        parts = [f"no actions for {', '.join(missing)}"] if missing else []
        parts += [f"no agent {', '.join(map(str, unknown))}"] if unknown else []
        raise AgentError(f"{'; '.join(parts)}; the agents are {agents}")
    return {
        agent: _read(agent, actions[agent], space, num_envs)
        for agent, space in signature.action_spaces.items()
    }


def read_seeds(seed: Any, num_envs: int) -> list[int | None]:
    """A seed for every environment; None for those that continue their own sequence.

    Raises:
        UsageError: A seed is not a whole number from 0 to 2**63 - 1, or there are too few or many.
    """
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, Sequence | np.ndarray):
        seeds = [None if one is None else a_seed(one) for one in seed]
        if len(seeds) != num_envs:
            raise UsageError(f"there are {len(seeds)} seeds for {num_envs} environments")
        return seeds
    first = a_seed(seed)
    return [a_seed(first + number) for number in range(num_envs)]


def _read(agent: str, actions: Any, space: spaces.Space[Any], num_envs: int) -> NDArray[np.float64]:
    if isinstance(space, spaces.Dict):
        if not isinstance(actions, Mapping) or set(actions) != set(space.spaces):
            raise ActionError(agent, space, "is not a mapping with these keys")
        keys = [key for key in ACTION_PARTS if key in space.spaces]
        parts = [_read(agent, actions[key], space[key], num_envs) for key in keys]
        return np.concatenate(parts, axis=1)
    try:
        values = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        kind = type(actions).__name__
        raise ActionError(
            agent, space, f"is {kind}, not a row of numbers for each of {num_envs} environments"
        ) from None
    shape = (num_envs, *(space.shape or ()))
    if values.shape != shape:
        what = f"has shape {values.shape}, not {shape} for {num_envs} environments"
        raise ActionError(agent, space, what)
    finite = np.isfinite(values).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise ActionError(agent, space, f"in environment {row} has numbers that are not finite")
    return values
