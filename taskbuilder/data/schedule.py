"""Which attempts at the episodes of a task are played next, and when to stop.

What is next depends only on what came of the attempts before, in their order. The attempts of a
data set are therefore the same however often collecting is interrupted, and in however many
processes it is done.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

from taskbuilder.data.plan import Attempt, CollectPlan, attempt_at, attempt_of
from taskbuilder.data.playing import AttemptResult
from taskbuilder.task import Task

HOPELESS = 20
"""Attempts without a single success after which collecting stops."""

MOST_ATTEMPTS = 20
"""Attempts for every episode asked for after which collecting stops."""


@dataclass
class Series:
    """The attempts at a number of episodes, all of a task or all of one of its variations.

    Attributes:
        wanted: Number of episodes.
        attempt: The attempt of a number, counted from 0.
        results: What came of the attempts so far.
    """

    wanted: int
    attempt: Callable[[int], Attempt]
    results: list[AttemptResult] = field(default_factory=list)

    @property
    def kept(self) -> int:
        """Episodes so far."""
        return sum(result.kept for result in self.results)

    @property
    def is_hopeless(self) -> bool:
        """Whether too few attempts succeed for all episodes to come together."""
        limit = HOPELESS if not self.kept else HOPELESS + MOST_ATTEMPTS * self.wanted
        return self.kept < self.wanted and len(self.results) >= limit

    def next(self) -> list[Attempt]:
        """The attempts to play now: as many as episodes are missing, none if it is hopeless."""
        if self.is_hopeless:
            return []
        missing = self.wanted - self.kept
        if not self.kept:
            missing = min(missing, max(HOPELESS - len(self.results), 0))
        return [self.attempt(len(self.results) + number) for number in range(missing)]


def series_of(plan: CollectPlan, reference: str, task: Task) -> Sequence[Series]:
    """The series of a task: one, or one for each variation that is played."""
    if not plan.per_variation:
        return [Series(plan.episodes, partial(attempt_of, plan, reference, task))]
    return [
        Series(plan.episodes, partial(attempt_at, plan, reference, task, variation))
        for variation in plan.played(task)
    ]


def next_attempts(series: Sequence[Series]) -> Iterator[tuple[Series, Attempt]]:
    """The attempts to play now, by seed, each with its series."""
    pairs = ((one, attempt) for one in series for attempt in one.next())
    yield from sorted(pairs, key=lambda pair: pair[1].seed)
