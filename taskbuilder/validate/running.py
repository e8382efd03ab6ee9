"""A validation under way: what all families share, and how their work is spread."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from typing import Any

from taskbuilder.expert.ways import Way
from taskbuilder.jobs import Map
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.validate.playing import play_expert
from taskbuilder.validate.report import Progress
from taskbuilder.validate.studio import Source, Start, Studio, at_work, open_studio


@dataclass
class Run:
    """A validation of one task.

    Attributes:
        task: The task.
        source: Where other processes find it.
        seeds: How many episodes to sample where chance is involved.
        progress: Wraps the seeds of a family to show progress.
        spread: Maps work over processes, in order.
        limit_s: How long a piece of work may take.
        alive: Called while something lasts, to say that it goes on.
        measures: Figures by name, for the report.
        demonstrations: The expert's episodes, by how they began.
        plays: Other ways of playing that were tried, and by how the episode began.
    """

    task: Task
    source: Source
    seeds: int
    progress: Progress
    spread: Map
    limit_s: float | None = None
    alive: Callable[[], None] = lambda: None
    measures: dict[str, float] = field(default_factory=dict)
    demonstrations: dict[Start, Rollout] = field(default_factory=dict)
    plays: dict[Way, dict[Start, Rollout]] = field(default_factory=dict)

    @property
    def state(self) -> Any:
        """What later families need of those before them; `take_over` takes it, anywhere."""
        return self.measures, self.demonstrations, self.plays

    def take_over(self, state: Any) -> None:
        """Go on from the state of another run, which was lost."""
        self.measures, self.demonstrations, self.plays = state

    @property
    def studio(self) -> Studio:
        """What this process keeps of the task."""
        return open_studio(self.source, self.task)

    @property
    def variations(self) -> int:
        """How many scenes there are, the plain one included."""
        return len(self.task.file.scenes)

    @property
    def has_expert(self) -> bool:
        """Whether the task has an expert, and one that can be planned for."""
        return self.studio.has_expert

    @property
    def every_start(self) -> tuple[Start, ...]:
        """Every seed in every variation."""
        return tuple(Start(v, s) for v in range(self.variations) for s in range(self.seeds))

    def some_starts(self, most: int | None = None) -> tuple[Start, ...]:
        """Every seed once, the variations taking turns: what more than success is asked about.

        Args:
            most: How many seeds at most.
        """
        count = self.seeds if most is None else min(most, self.seeds)
        return tuple(sorted(Start(seed % self.variations, seed) for seed in range(count)))

    def ask(
        self,
        function: Callable[[Studio, Any], Any],
        starts: Sequence[Start],
        label: str,
        *,
        about: Sequence[Any] | None = None,
    ) -> Iterator[Any]:
        """Have work done, and give back the results in order, each as soon as it is there.

        Args:
            function: Of a module, to be called with a studio and a start, or an item.
            starts: How the episodes begin, in the order of their variations.
            label: What progress is shown as.
            about: An item for each start, where the function needs more than the start; picklable.

        Raises:
            DescriptionError: The description raised an error.
        """
        items = starts if about is None else about
        results = iter(self.spread(partial(at_work, function, self.source), items))
        for variation, group in groupby(starts, key=lambda start: start.variation):
            name = f"{label}, variation {variation}" if variation else label
            for _ in self.progress([start.seed for start in group], name):
                yield next(results)

    def demonstrate(self, starts: Sequence[Start], label: str) -> Iterator[Rollout]:
        """What the expert does from each start; played only where it has not been.

        Raises:
            DescriptionError: The description raised an error.
        """
        new = [start for start in starts if start not in self.demonstrations]
        played = zip(new, self.ask(play_expert, new, label), strict=True)
        for start in starts:
            while start not in self.demonstrations:
                fresh, demonstration = next(played)
                self.demonstrations[fresh] = demonstration
            yield self.demonstrations[start]
