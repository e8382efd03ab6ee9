"""Mean and spread of what is measured as it comes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

LEAST_SCALE = 1e-2
"""What hardly moves is not blown up by normalising."""


class RunningMoments:
    """Mean and spread of all that has been added (Chan et al. 1979); 0 and 1 until then.

    Args:
        width: Quantities that are measured.
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
        """Add measurements: (n, width)."""
        if not len(rows):
            return
        values = rows.astype(np.float64)
        count, apart = self._count + len(values), values.mean(0) - self.mean
        self._square += values.var(0) * len(values)
        self._square += apart**2 * self._count * len(values) / count
        self.mean = self.mean + apart * len(values) / count
        self._count = count

    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """All that it knows."""
        parts = {"count": np.array([self._count]), "mean": self.mean, "square": self._square}
        return {name: array.copy() for name, array in parts.items()}

    def load(self, arrays: Mapping[str, NDArray[np.float64]]) -> None:
        """Take over what `arrays` gave."""
        self._count = float(arrays["count"][0])
        self.mean, self._square = arrays["mean"].copy(), arrays["square"].copy()
