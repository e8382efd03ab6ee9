"""Statistics of features, as LeRobot normalises by them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}

Stats = dict[str, NDArray[Any]]
"""``min``, ``max``, ``mean``, ``std``, ``count`` and quantiles of a feature."""


def stats_of(values: NDArray[Any]) -> Stats:
    """The statistics of (frames, numbers) values, each (numbers,)."""
    numbers = values.astype(np.float64)
    found: Stats = {
        "min": numbers.min(axis=0),
        "max": numbers.max(axis=0),
        "mean": numbers.mean(axis=0),
        "std": numbers.std(axis=0),
        "count": np.array([len(numbers)]),
    }
    quantiles = np.quantile(numbers, list(QUANTILES.values()), axis=0)
    return {**found, **dict(zip(QUANTILES, quantiles, strict=True))}


def image_stats(images: NDArray[np.uint8]) -> Stats:
    """The statistics of each colour, scaled to 0 to 1: (3, 1, 1) each.

    Args:
        images: (frames, height, width, 3); not every frame of an episode is needed.
    """
    found = stats_of(images.reshape(-1, 3) / 255.0)
    shaped = {name: value.reshape(3, 1, 1) for name, value in found.items() if name != "count"}
    return {**shaped, "count": np.array([len(images)])}


def combined(parts: Sequence[Mapping[str, NDArray[Any]]]) -> Stats:
    """The statistics of several parts together; quantiles are averaged by the number of frames."""
    counts = np.array([int(part["count"][0]) for part in parts], dtype=np.float64)
    weights = counts / counts.sum()

    def average(values: Sequence[NDArray[Any]]) -> NDArray[Any]:
        return np.tensordot(weights, np.stack(values), axes=1)

    mean = average([part["mean"] for part in parts])
    variance = average([part["std"] ** 2 + (part["mean"] - mean) ** 2 for part in parts])
    found: Stats = {
        "min": np.min([part["min"] for part in parts], axis=0),
        "max": np.max([part["max"] for part in parts], axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": np.array([int(counts.sum())]),
    }
    return {**found, **{name: average([part[name] for part in parts]) for name in QUANTILES}}
