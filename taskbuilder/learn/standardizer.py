"""Standardisation of observations and state with fixed statistics."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from taskbuilder.learn.networks import as_array
from taskbuilder.learn.shapes import Layout, Rows
from taskbuilder.policies.trained import Array32

LEAST_SCALE = 0.3
"""Minimum scale, so that inputs that hardly vary are not amplified."""


class Standardizer:
    """Standardises observations and state in rows of the replay buffer, and leaves the rest.

    Args:
        layout: The layout of a row.
        device: Device of the networks.
    """

    def __init__(self, layout: Layout, device: torch.device) -> None:
        self._layout, self._device = layout, device
        self._mean = torch.zeros(layout.width, device=device)
        self._scale = torch.ones(layout.width, device=device)

    def measure(self, rows: Rows) -> None:
        """Set the statistics to those of these rows."""
        layout = self._layout
        pairs = [(layout.observations[a], layout.next_observations[a]) for a in layout.observations]
        for part, next_part in (*pairs, (layout.state, layout.next_state)):
            values = rows[:, part]
            self._mean[part] = self._mean[next_part] = torch.from_numpy(values.mean(0)).to(
                self._device
            )
            scale = torch.from_numpy(np.maximum(values.std(0), LEAST_SCALE)).to(self._device)
            self._scale[part] = self._scale[next_part] = scale

    def apply_(self, rows: Tensor) -> Tensor:
        """Standardise rows in place."""
        return rows.sub_(self._mean).div_(self._scale)

    def observations(self, observations: Mapping[str, Array32]) -> dict[str, Tensor]:
        """Standardised observations of the agents."""
        parts = self._layout.observations
        return {
            agent: (torch.from_numpy(observations[agent]).to(self._device) - self._mean[part])
            / self._scale[part]
            for agent, part in parts.items()
        }

    def by_agent(self) -> tuple[dict[str, Array32], dict[str, Array32]]:
        """Mean and scale of each agent's observations."""
        parts = self._layout.observations
        mean, scale = as_array(self._mean), as_array(self._scale)
        return {a: mean[p] for a, p in parts.items()}, {a: scale[p] for a, p in parts.items()}

    def arrays(self) -> dict[str, Array32]:
        """The statistics, by name."""
        return {"mean": as_array(self._mean), "scale": as_array(self._scale)}

    def load(self, arrays: Mapping[str, Array32]) -> None:
        """Restore what `arrays` returned."""
        self._mean.copy_(torch.from_numpy(arrays["mean"]))
        self._scale.copy_(torch.from_numpy(arrays["scale"]))
