"""Shares of episodes, with the interval that so few episodes leave them in."""

from __future__ import annotations

from dataclasses import dataclass

from taskbuilder.intervals import wilson


@dataclass(frozen=True)
class Proportion:
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
        """Wilson's interval at 95 %."""
        return wilson(self.count, self.of)

    def __str__(self) -> str:
        low, high = (round(100.0 * bound) for bound in self.interval)
        return f"{self.count}/{self.of} ({low}–{high} %)"
