"""Hand-made transitions, memories and draws, and learners with hand-set numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from taskbuilder.learn.shapes import Rows, Shapes


class Constant:
    """Draws the same number whatever is asked for."""

    def __init__(self, value: float) -> None:
        self.value = value

    def standard_normal(self, shape: tuple[int, ...], dtype: Any) -> Any:
        return np.full(shape, self.value, dtype)


class Given:
    """A memory that always gives the same transitions, and keeps what it was asked for."""

    def __init__(self, *rows: Rows) -> None:
        self.rows = np.concatenate(rows)
        self.asked: list[int] = []

    def sample(self, count: int, rng: Any) -> Rows:
        self.asked.append(count)
        return self.rows.copy()


def row(
    shapes: Shapes,
    observations: Mapping[str, Any] | None = None,
    actions: Mapping[str, Any] | None = None,
    next_observations: Mapping[str, Any] | None = None,
    **parts: Any,
) -> Rows:
    """A transition (1, width): zeros where nothing is said."""
    layout = shapes.layout
    numbers = np.zeros((1, layout.width), dtype=np.float32)
    by_agent = (
        (layout.observations, observations),
        (layout.action, actions),
        (layout.next_observations, next_observations),
    )
    for places, values in by_agent:
        for agent, value in (values or {}).items():
            numbers[0, places[agent]] = value
    for name, value in parts.items():
        numbers[0, getattr(layout, name)] = value
    return numbers


def set_to(learner: Any, numbers: Mapping[str, Any]) -> None:
    """Set these arrays of a learner, and all others to zero, except what is divided by."""
    arrays = {n: a if n == "scale" else a * 0 for n, a in learner.arrays().items()}
    unknown = set(numbers) - set(arrays)
    assert not unknown, unknown
    for name, value in numbers.items():
        dtype, shape = arrays[name].dtype, arrays[name].shape
        arrays[name] = np.array(np.broadcast_to(value, shape), dtype=dtype)
    learner.load(arrays)


def same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether arrays are equal to the bit, by name."""
    return set(one) == set(other) and all(np.array_equal(one[n], other[n]) for n in one)
