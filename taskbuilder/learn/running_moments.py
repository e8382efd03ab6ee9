"""Running mean and standard deviation."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

LEAST_SCALE = 1e-2
"""Minimum scale, so that quantities that hardly vary are not amplified."""


class RunningMoments:
    """Mean and standard deviation of all added rows (Chan et al. 1979); 0 and 1 at first.

    Args:
        width: Number of quantities.
    """

    def __init__(self, width: int) -> None:
        self._count = 0.0
        self.mean = np.zeros(width)
        self._square = np.zeros(width)  # sum of squared distances from the mean

    @property
    def scale(self) -> NDArray[np.float64]:
        """The standard deviation."""
        if not self._count:
            return np.ones_like(self.mean)
        spread: NDArray[np.float64] = np.sqrt(self._square / self._count)
        return np.maximum(spread, LEAST_SCALE)

    def add(self, rows: NDArray[np.floating]) -> None:
        """Add rows: (n, width)."""
        if not len(rows):
            return
        values = rows.astype(np.float64)
        count, delta = self._count + len(values), values.mean(0) - self.mean
        self._square += values.var(0) * len(values)
        self._square += delta**2 * self._count * len(values) / count
        self.mean = self.mean + delta * len(values) / count
        self._count = count

    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """The statistics, by name."""
        parts = {"count": np.array([self._count]), "mean": self.mean, "square": self._square}
        return {name: array.copy() for name, array in parts.items()}

    def load(self, arrays: Mapping[str, NDArray[np.float64]]) -> None:
        """Restore what `arrays` returned."""
        self._count = float(arrays["count"][0])
        self.mean, self._square = arrays["mean"].copy(), arrays["square"].copy()
