"""Fractions of episodes with their confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass

from taskbuilder.intervals import wilson


@dataclass(frozen=True)
class Proportion:
    """A fraction of episodes.

    Attributes:
        count: Number of episodes that count.
        of: Number of all episodes, at least one.
    """

    count: int
    of: int

    @property
    def value(self) -> float:
        """The fraction, from 0 to 1."""
        return self.count / self.of

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % Wilson interval."""
        return wilson(self.count, self.of)

    def __str__(self) -> str:
        low, high = (round(100.0 * bound) for bound in self.interval)
        return f"{self.count}/{self.of} ({low}–{high} %)"
