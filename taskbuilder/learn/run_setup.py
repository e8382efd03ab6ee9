"""What a training run works with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from taskbuilder.data.dataset import Dataset
from taskbuilder.learn.plan import Plan
from taskbuilder.task import Task


@dataclass(frozen=True)
class ExpertWaits:
    """How long the expert went without progress before it succeeded.

    Attributes:
        waits_s: The longest time without progress in each successful episode, in seconds.
        episodes: Number of all episodes.
        timeout_s: The time without progress after which training ends an episode.
    """

    waits_s: tuple[float, ...]
    episodes: int
    timeout_s: float

    @property
    def cut(self) -> int:
        """Number of successful episodes that training would end before their success."""
        return sum(wait >= self.timeout_s for wait in self.waits_s)

    def __str__(self) -> str:
        ends = f"training ends an episode after {self.timeout_s:g} s without progress"
        if not self.episodes:
            return f"{ends}; the task has no expert to measure it by"
        if not self.waits_s:
            return f"{ends}; none of {self.episodes} episodes of the expert succeeded"
        longest = f"the expert waits for {max(self.waits_s):g} s at most"
        if not self.cut:
            return f"{ends}; {longest}"
        cut = f"{self.cut} of {len(self.waits_s)} episodes in which the expert succeeds"
        return f"{ends}, which cuts {cut}: {longest}"


@dataclass(frozen=True)
class RunSetup:
    """What a run works with, checked once and handed down.

    Attributes:
        plan: The plan.
        task: The task of the plan.
        dataset: The data set to learn from, or None.
        observed: Names of the numbers that robots observe, by agent; only with a data set.
        waits: How long the expert goes without progress, if that was measured for this run.
    """

    plan: Plan
    task: Task
    dataset: Dataset | None = None
    observed: Mapping[str, Sequence[str]] = field(default_factory=dict)
    waits: ExpertWaits | None = None
