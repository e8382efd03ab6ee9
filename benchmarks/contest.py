"""What learners are measured on, and how: the same batches for all, in turns."""

from __future__ import annotations

import itertools
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

AGENTS = ("left", "right")
OBSERVATION, ACTION = 20, 5
HIDDEN = (64, 64)
BATCH = 1024
BATCHES = 32
LR, DISCOUNT, TAU = 1e-3, 0.95, 0.01


@dataclass(frozen=True)
class Batch:
    """Transitions: an array (n, ...) an agent, by name."""

    observations: dict[str, NDArray[np.float32]]
    actions: dict[str, NDArray[np.float32]]
    rewards: dict[str, NDArray[np.float32]]
    next_observations: dict[str, NDArray[np.float32]]


@dataclass(frozen=True)
class Contestant:
    """One that learns.

    Attributes:
        package: The Python package that it comes from.
        actors: How many networks act.
        critics: How many networks judge, without targets.
        note: What its update does that others' do not.
        update: Learns from a batch; returns losses.
    """

    package: str
    actors: int
    critics: int
    note: str
    update: Callable[[], Any]


def draw_batches() -> list[Batch]:
    """The batches that all learn from; all agents are paid the same, and no episode ends."""
    rng = np.random.default_rng(0)

    def seen() -> dict[str, NDArray[np.float32]]:
        size = (BATCH, OBSERVATION)
        return {agent: rng.standard_normal(size, dtype=np.float32) for agent in AGENTS}

    def said() -> dict[str, NDArray[np.float32]]:
        size = (BATCH, ACTION)
        return {agent: rng.uniform(-1.0, 1.0, size).astype(np.float32) for agent in AGENTS}

    def paid() -> dict[str, NDArray[np.float32]]:
        return dict.fromkeys(AGENTS, rng.uniform(-1.0, 0.0, BATCH).astype(np.float32))

    return [Batch(seen(), said(), paid(), seen()) for _ in range(BATCHES)]


@dataclass(frozen=True)
class Figures:
    """How long updates took, in milliseconds.

    Attributes:
        updates_per_second: By the median.
        median: Of the repetitions' means.
        quartiles: Of the same.
        least: Of the same.
        median_cpu: The same of the processor's time: on a quiet machine, as long as by the clock.
    """

    updates_per_second: float
    median: float
    quartiles: tuple[float, float]
    least: float
    median_cpu: float

    @classmethod
    def of(cls, wall: list[float], cpu: list[float]) -> Figures:
        """Sum repetitions up."""
        first, median, third = statistics.quantiles(wall, n=4)
        return cls(1e3 / median, median, (first, third), min(wall), statistics.median(cpu))


def measure(
    contestants: dict[str, Contestant], repetitions: int, updates: int
) -> dict[str, Figures]:
    """Let all take turns.

    Args:
        contestants: By name.
        repetitions: Turns of each.
        updates: In a turn.
    """
    for contestant in contestants.values():
        timed(contestant, updates)
    turns: dict[str, list[tuple[float, float]]] = {name: [] for name in contestants}
    for _, (name, contestant) in itertools.product(range(repetitions), contestants.items()):
        turns[name].append(timed(contestant, updates))
    return {
        name: Figures.of([wall for wall, _ in found], [cpu for _, cpu in found])
        for name, found in turns.items()
    }


def timed(contestant: Contestant, updates: int) -> tuple[float, float]:
    """Milliseconds an update, by the clock and of the processor."""
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(updates):
        contestant.update()
    ended = time.perf_counter(), time.process_time()
    return (ended[0] - wall) * 1e3 / updates, (ended[1] - cpu) * 1e3 / updates
