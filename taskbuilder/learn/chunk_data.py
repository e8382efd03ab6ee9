"""Demonstrations on a device: standardised observations, pictures and chunks of actions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from taskbuilder.learn.recordings import Demonstrations
from taskbuilder.policies.trained import Array32

LEAST_SCALE = 0.02
"""Minimum scale of an observed number, so that those that hardly vary are not amplified."""


NOT_TURNED: Mapping[str, Tensor] = MappingProxyType({})
"""The angles of scenes as they were."""


class ChunkData:
    """The training data of `BehaviourCloning`.

    With pictures, policies observe only the numbers of their own robot besides; without, all.

    Args:
        demonstrations: The demonstrations.
        device: Where the tensors are.

    Attributes:
        sizes: Number of observed numbers, by agent.
        pictures: (n, height, width, 3) uint8 by camera.
        scene: (n, numbers) the standardised numbers that policies do not observe.
    """

    def __init__(self, demonstrations: Demonstrations, device: torch.device) -> None:
        self._device = device
        observations = demonstrations.observations
        self._mean = {agent: x.mean(0) for agent, x in observations.items()}
        self._scale = {
            agent: np.maximum(x.std(0), LEAST_SCALE) for agent, x in observations.items()
        }
        self._own = {
            agent: own if demonstrations.pictures else np.ones_like(own)
            for agent, own in demonstrations.own.items()
        }
        normal = {a: (x - self._mean[a]) / self._scale[a] for a, x in observations.items()}
        self.sizes = {agent: x.shape[1] for agent, x in observations.items()}
        self._mask = {agent: self._tensor(own) for agent, own in self._own.items()}
        self._observations = {a: self._tensor(x) * self._mask[a] for a, x in normal.items()}
        rest = [x[:, ~self._own[agent]] for agent, x in normal.items()]
        self.scene = self._tensor(np.concatenate(rest, 1))
        self.pictures = {
            camera: torch.from_numpy(images).to(device)
            for camera, images in demonstrations.pictures.items()
        }
        self._actions = {a: self._tensor(actions) for a, actions in demonstrations.actions.items()}
        self._ends = torch.from_numpy(demonstrations.ends).to(device)
        self._turns = {
            agent: (self._columns(turns.observed), self._columns(turns.commanded))
            for agent, turns in demonstrations.turns.items()
            if turns is not None and turns.of_tool
        }
        self._moments = {
            agent: (self._tensor(self._mean[agent]), self._tensor(self._scale[agent]))
            for agent in self._turns
        }

    @property
    def action_sizes(self) -> dict[str, int]:
        """Size of each agent's action."""
        return {agent: actions.shape[1] for agent, actions in self._actions.items()}

    def draw(self, count: int, rng: np.random.Generator) -> Tensor:
        """Rows, drawn uniformly: (count,)."""
        return torch.from_numpy(rng.integers(len(self._ends), size=count)).to(self._device)

    def angles(self, count: int, spread: float, rng: np.random.Generator) -> dict[str, Tensor]:
        """Angles by which the scene is turned about the vertical through each agent's base.

        Args:
            count: How many.
            spread: Standard deviation in rad; with 0, there are none.
            rng: Their generator.

        Returns:
            (count,) angles in rad, by agent, of those whose motions are known to turn.
        """
        return {
            agent: self._tensor(rng.normal(0.0, spread, count))
            for agent in (self._turns if spread else ())
        }

    def observations(
        self,
        rows: Tensor,
        noise: float,
        rng: np.random.Generator,
        angles: Mapping[str, Tensor] = NOT_TURNED,
    ) -> dict[str, Tensor]:
        """Standardised observations of some rows, by agent.

        Args:
            rows: (n,) rows.
            noise: Standard deviation of Gaussian noise on the numbers that policies observe.
            rng: Generator of the noise.
            angles: As of `angles`.
        """
        observed = {agent: values[rows] for agent, values in self._observations.items()}
        for agent, by in angles.items():
            mean, scale = self._moments[agent]
            plain = observed[agent] * scale + mean
            turned = (_turned(plain, self._turns[agent][0], by) - mean) / scale
            observed[agent] = turned * self._mask[agent]
        if noise:
            for agent, values in observed.items():
                sample = self._tensor(rng.standard_normal(values.shape, dtype=np.float32))
                observed[agent] = values + noise * sample * self._mask[agent]
        return observed

    def chunks(
        self, rows: Tensor, length: int, angles: Mapping[str, Tensor] = NOT_TURNED
    ) -> tuple[Tensor, Tensor]:
        """The actions from some rows on, of all agents in order.

        Args:
            rows: (n,) rows.
            length: Actions in a chunk.
            angles: As of `angles`.

        Returns:
            The actions (n, length * joint action), agent by agent; and whether each of these
            numbers is within the episode, else it repeats the last action.
        """
        ahead = rows[:, None] + torch.arange(length, device=self._device)
        ends = self._ends[rows, None]
        ahead, inside = torch.minimum(ahead, ends - 1), ahead < ends
        actions = [
            (
                _turned(values[ahead], self._turns[agent][1], angles[agent][:, None])
                if agent in angles
                else values[ahead]
            ).flatten(1)
            for agent, values in self._actions.items()
        ]
        counted = [inside.repeat_interleave(size, 1) for size in self.action_sizes.values()]
        return torch.cat(actions, 1), torch.cat(counted, 1)

    def statistics(self, features: int) -> tuple[dict[str, Array32], dict[str, Array32]]:
        """Mean and scale of each agent's input: its observed numbers, then features as they are.

        A number that the policy does not observe has an infinite scale, and so no weight.
        """
        zeros = np.zeros(features, dtype=np.float32)
        mean = {agent: np.concatenate([x, zeros]) for agent, x in self._mean.items()}
        scale = {
            agent: np.concatenate([np.where(self._own[agent], x, np.float32(np.inf)), zeros + 1.0])
            for agent, x in self._scale.items()
        }
        return mean, scale

    def _columns(self, pairs: NDArray[np.int64]) -> Tensor:
        return torch.from_numpy(pairs).to(self._device)

    def _tensor(self, array: NDArray[np.generic]) -> Tensor:
        return torch.from_numpy(array.astype(np.float32)).to(self._device)


def _turned(values: Tensor, pairs: Tensor, angles: Tensor) -> Tensor:
    """Values (..., numbers) whose pairs (n, 2) of columns are turned by angles (...) in rad."""
    turned = values.clone()
    x, y = values[..., pairs[:, 0]], values[..., pairs[:, 1]]
    cos, sin = angles.cos()[..., None], angles.sin()[..., None]
    turned[..., pairs[:, 0]] = cos * x - sin * y
    turned[..., pairs[:, 1]] = sin * x + cos * y
    return turned
