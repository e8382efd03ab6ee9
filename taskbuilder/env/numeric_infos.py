"""Infos of numbers alone, for frameworks that keep infos in tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pettingzoo.utils import BaseParallelWrapper


class NumericInfos(BaseParallelWrapper):  # type: ignore[misc]  # pettingzoo ships no types
    """Leaves what is no number, such as the instruction, out of the infos.

    TorchRL and BenchMARL make a tensor of each info. The text of the instruction is still in
    ``env.unwrapped.task_description``.

    Example:
        >>> env = NumericInfos(parallel_env("handover"))
        >>> env = PettingZooWrapper(env, return_state=True)  # of torchrl.envs
    """

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, float]]]:
        """Begin an episode; see `TaskEnv.reset`."""
        observations, infos = super().reset(seed=seed, options=options)
        return observations, _numeric(infos)

    def step(self, actions: dict[str, Any]) -> tuple[Any, ...]:
        """Run one control step; see `TaskEnv.step`."""
        *returned, infos = super().step(actions)
        observations, rewards, terminations, truncations = returned
        return observations, rewards, terminations, truncations, _numeric(infos)


def _numeric(infos: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    return {
        agent: {key: value for key, value in info.items() if isinstance(value, int | float)}
        for agent, info in infos.items()
    }
