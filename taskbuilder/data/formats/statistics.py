"""Statistics of features, as LeRobot normalises by them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}

Stats = dict[str, NDArray[Any]]
"""``min``, ``max``, ``mean``, ``std``, ``count`` and quantiles of a feature."""


def stats_of(values: NDArray[Any]) -> Stats:
    """The statistics of (frames, numbers) values, each (numbers,)."""
    numbers = values.astype(np.float64)
    stats: Stats = {
        "min": numbers.min(axis=0),
        "max": numbers.max(axis=0),
        "mean": numbers.mean(axis=0),
        "std": numbers.std(axis=0),
        "count": np.array([len(numbers)]),
    }
    quantiles = np.quantile(numbers, list(QUANTILES.values()), axis=0)
    return {**stats, **dict(zip(QUANTILES, quantiles, strict=True))}


def image_stats(images: Iterable[NDArray[np.uint8]]) -> Stats:
    """The statistics of each colour, scaled to 0 to 1: (3, 1, 1) each.

    Args:
        images: (height, width, 3) each, of which one is held at a time; not every frame of an
            episode is needed.
    """
    counts = np.zeros((3, 256), dtype=np.int64)
    frames = 0
    for image in images:
        frames += 1
        for color in range(3):
            counts[color] += np.bincount(image[..., color].reshape(-1), minlength=256)
    values = np.arange(256) / 255.0
    pixels = int(counts[0].sum())
    mean = counts @ values / pixels
    spread = np.sqrt((counts * (values - mean[:, None]) ** 2).sum(axis=1) / pixels)
    stats: Stats = {
        "min": values[(counts > 0).argmax(axis=1)],
        "max": values[255 - (counts[:, ::-1] > 0).argmax(axis=1)],
        "mean": mean,
        "std": spread,
    }
    stats |= {name: _quantile(counts, share) / 255.0 for name, share in QUANTILES.items()}
    shaped = {name: value.reshape(3, 1, 1) for name, value in stats.items()}
    return {**shaped, "count": np.array([frames])}


def _quantile(counts: NDArray[np.int64], share: float) -> NDArray[np.float64]:
    """A quantile of whole numbers from 0 by how often each occurs, interpolated: (rows,)."""
    place = share * (counts[0].sum() - 1)
    below, above = int(np.floor(place)), int(np.ceil(place))
    ends = np.cumsum(counts, axis=1)
    low, high = ((ends <= rank).sum(axis=1) for rank in (below, above))
    weighted: NDArray[np.float64] = low + (high - low) * (place - below)
    return weighted


LEAST_STD = 0.01
"""Least standard deviation that a number is divided by: rad, m, or a part of an action.

The code of ACT (Zhao et al., 2023) has the same bound. LeRobot itself only adds 1e-8.
"""


def floored(stats: Mapping[str, NDArray[Any]]) -> tuple[Stats, tuple[int, ...]]:
    """Statistics whose standard deviations are not so small that noise would be amplified.

    The joints of an arm that stands still differ by some 1e-7 rad, so that a policy would see a
    move of 0.001 rad as thousands of standard deviations.

    Returns:
        The statistics, and the places of the numbers that hardly vary.
    """
    small = np.flatnonzero(stats["std"] < LEAST_STD)
    raised = {**stats, "std": np.maximum(stats["std"], LEAST_STD)}
    return raised, tuple(int(place) for place in small)


def combined(parts: Sequence[Mapping[str, NDArray[Any]]]) -> Stats:
    """The statistics of several parts together; quantiles are averaged by the number of frames."""
    counts = np.array([int(part["count"][0]) for part in parts], dtype=np.float64)
    weights = counts / counts.sum()

    def average(values: Sequence[NDArray[Any]]) -> NDArray[Any]:
        return np.tensordot(weights, np.stack(values), axes=1)

    mean = average([part["mean"] for part in parts])
    variance = average([part["std"] ** 2 + (part["mean"] - mean) ** 2 for part in parts])
    stats: Stats = {
        "min": np.min([part["min"] for part in parts], axis=0),
        "max": np.max([part["max"] for part in parts], axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": np.array([int(counts.sum())]),
    }
    return {**stats, **{name: average([part[name] for part in parts]) for name in QUANTILES}}
