"""Progress as training sees it, from 0 to 1, and the time that an episode goes without it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.bounds import bounds_of
from taskbuilder.description.measures import Measure
from taskbuilder.rollout.record import Rollout

LEAST_RISE = 1.0 / 300.0
"""The minimum rise of progress, from 0 to 1, that restarts the time without progress."""

EPISODES = 20
"""Episodes of the expert on which training measures how long it waits."""

MARGIN = 1.5
"""The time without progress after which training ends an episode, as a multiple of the longest
wait of the expert."""

LEAST_TIMEOUT_S = 1.5
"""The least such time by default, in seconds."""


class ProgressRange(NamedTuple):
    """The values of a description's progress that training maps to 0 and to 1.

    Attributes:
        low: The value that is mapped to 0, as are lower ones.
        high: The value that is mapped to 1, as are higher ones.
    """

    low: float
    high: float

    def share(self, value: float) -> float:
        """A value of the progress, from 0 to 1."""
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)

    def shares(self, episode: Rollout) -> NDArray[np.float64]:
        """The progress of an episode, from 0 to 1: (steps + 1,)."""
        return np.array([self.share(float(value)) for value in episode.progress])


def written_range(progress: Measure) -> ProgressRange | None:
    """The least and the greatest value of a progress, if its expression says them."""
    low, high = bounds_of(progress)
    known = math.isfinite(low) and math.isfinite(high) and low < high
    return ProgressRange(low, high) if known else None


def measured_range(episodes: Iterable[Rollout]) -> ProgressRange | None:
    """The least and the greatest progress in the episodes that succeed; None if it never rises."""
    values = np.concatenate([np.zeros(0), *(e.progress for e in episodes if e.success)])
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    return ProgressRange(low, high) if low < high else None


class ProgressCount(NamedTuple):
    """The time without progress in an episode.

    Attributes:
        highest: The highest progress so far.
        steps: Control steps since it rose, which are not counted while success holds.
    """

    highest: float = 0.0
    steps: int = 0

    def after(self, progress: float, *, success: bool, rise: float = LEAST_RISE) -> ProgressCount:
        """The count after a control step.

        Args:
            progress: The progress now.
            success: Whether success holds.
            rise: By how much progress has to exceed its highest value to count as rising.
        """
        if success or progress >= self.highest + rise:
            return ProgressCount(max(self.highest, progress), 0)
        return ProgressCount(self.highest, self.steps + 1)


class Pause(NamedTuple):
    """A time without progress.

    Attributes:
        steps: Its length in control steps.
        until: The control step at which it ends.
    """

    steps: int
    until: int


def longest_wait(episode: Rollout, progress: Sequence[float] | NDArray[np.float64]) -> Pause:
    """The longest time without progress before an episode's success.

    Args:
        episode: The episode.
        progress: Its progress, from 0 to 1, after reset and after each control step.
    """
    count, longest = ProgressCount(float(progress[0])), Pause(0, 0)
    last = episode.steps if episode.first_success is None else episode.first_success
    for step in range(1, last + 1):
        held = bool(episode.conditions["success"][step])
        count = count.after(float(progress[step]), success=held)
        longest = max(longest, Pause(count.steps, step), key=lambda pause: pause.steps)
    return longest


def longest_wait_s(episode: Rollout, progress: Sequence[float] | NDArray[np.float64]) -> float:
    """The length of `longest_wait` in seconds."""
    return episode.seconds(longest_wait(episode, progress).steps)


def timeout_for(waits_s: Iterable[float], least_s: float = LEAST_TIMEOUT_S) -> float:
    """The time without progress after which training ends an episode by default, in seconds.

    Args:
        waits_s: The longest waits of the expert, in seconds.
        least_s: The time if it waits for less.
    """
    return max([least_s, *(round(MARGIN * wait, 3) for wait in waits_s)])
