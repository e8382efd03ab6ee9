"""Shares of episodes, with the interval that so few episodes leave them in."""

from __future__ import annotations

import math
from dataclasses import dataclass

Z = 1.959963984540054
"""Standard normal quantile of a two-sided interval of 95 %."""


@dataclass(frozen=True)
class Share:
    """How many of some episodes went one way.

    Attributes:
        count: How many did.
        of: How many there were, at least one.
    """

    count: int
    of: int

    @property
    def value(self) -> float:
        """The share itself, from 0 to 1."""
        return self.count / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval at 95 %: unlike the usual one, it is right at 0 and at 1.

        Wilson, "Probable inference, the law of succession, and statistical inference", Journal of
        the American Statistical Association 22, 1927.
        """
        n, p = self.of, self.value
        spread = Z * math.sqrt(p * (1.0 - p) / n + Z * Z / (4.0 * n * n))
        low, high = (
            (p + Z * Z / (2.0 * n) + sign * spread) / (1.0 + Z * Z / n) for sign in (-1.0, 1.0)
        )
        return max(0.0, low), min(1.0, high)

    def __str__(self) -> str:
        low, high = (round(100.0 * bound) for bound in self.interval)
        return f"{self.count}/{self.of} ({low}–{high} %)"
