"""The replay buffer: a ring of transitions, one row each."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from taskbuilder.learn.shapes import Rows


class Memory(Protocol):
    """A source of transitions for learners."""

    def sample(self, count: int, rng: np.random.Generator) -> Rows:
        """Draw transitions, with replacement: (count, width)."""
        ...


class Replay:
    """A ring buffer of the latest transitions.

    Args:
        width: Numbers in a row.
        capacity: Maximum number of rows; memory is allocated as they come.
    """

    def __init__(self, width: int, capacity: int) -> None:
        self._rows = np.empty((min(capacity, 4096), width), dtype=np.float32)
        self.capacity = capacity
        self.added = 0

    def __len__(self) -> int:
        return min(self.added, self.capacity)

    def add(self, rows: Rows) -> None:
        """Add transitions: (n, width), n at most the capacity."""
        self._grow(min(self.added + len(rows), self.capacity))
        places = (self.added + np.arange(len(rows))) % self.capacity
        self._rows[places] = rows
        self.added += len(rows)

    def sample(self, count: int, rng: np.random.Generator) -> Rows:
        """Draw transitions uniformly, with replacement: (count, width)."""
        return self._rows.take(rng.integers(len(self), size=count), axis=0)

    def since(self, added: int) -> Rows:
        """The rows added since a given number of additions, oldest first, if still stored."""
        first = max(added, self.added - self.capacity)
        return self._rows[np.arange(first, self.added) % self.capacity]

    def _grow(self, needed: int) -> None:
        if needed > len(self._rows):
            size = min(max(needed, 2 * len(self._rows)), self.capacity)
            grown = np.empty((size, self._rows.shape[1]), dtype=np.float32)
            grown[: len(self._rows)] = self._rows
            self._rows = grown
