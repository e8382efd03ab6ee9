"""The shared state of a running validation, and the distribution of its work."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import groupby
from typing import Any

from taskbuilder.expert.baselines import Baseline
from taskbuilder.jobs import Map
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.validate.env_cache import EnvCache, EnvSource, Start, at_work, open_cache
from taskbuilder.validate.playing import play_expert
from taskbuilder.validate.report import Progress
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World


@dataclass
class Context:
    """A validation of one task.

    Attributes:
        task: The task.
        source: The source of the task, for other processes.
        seeds: Number of seeds per variation.
        progress: Wraps the seeds of a family to display progress.
        spread: Maps work over processes, in order.
        limit_s: Time limit of a unit of work.
        alive: Called during long work, to report that it goes on.
        measures: Figures by name, for the report.
        demonstrations: The expert's episodes, by start.
        plays: The episodes of the probes, by name and start.
        worlds: The worlds that were built and are still of use, by variation.
    """

    task: Task
    source: EnvSource
    seeds: int
    progress: Progress
    spread: Map
    limit_s: float | None = None
    alive: Callable[[], None] = lambda: None
    measures: dict[str, float] = field(default_factory=dict)
    demonstrations: dict[Start, Rollout] = field(default_factory=dict)
    plays: dict[Baseline, dict[Start, Rollout]] = field(default_factory=dict)
    worlds: dict[int, World] = field(default_factory=dict)

    def world(self, variation: int) -> World:
        """The world of a variation, built the first time it is asked for.

        Raises:
            FileError: The scene cannot be built.
        """
        if variation not in self.worlds:
            self.worlds[variation] = build_world(self.task.file, variation=variation)
        return self.worlds[variation]

    def close_world(self, variation: int) -> None:
        """Close the world of a variation, if there is one; the next one is built anew."""
        world = self.worlds.pop(variation, None)
        if world is not None:
            world.close()

    @property
    def state(self) -> Any:
        """State that later families need; `take_over` restores it, in any process."""
        return self.measures, self.demonstrations, self.plays

    def take_over(self, state: Any) -> None:
        """Continue from the state of another run that was lost."""
        self.measures, self.demonstrations, self.plays = state

    @property
    def cache(self) -> EnvCache:
        """The environments and experts that this process keeps."""
        return open_cache(self.source, self.task)

    @property
    def variations(self) -> int:
        """Number of variations, including number 0."""
        return len(self.task.file.scenes)

    @property
    def has_expert(self) -> bool:
        """Whether the task has an expert whose action modes can be planned for."""
        return self.cache.has_expert

    @property
    def every_start(self) -> tuple[Start, ...]:
        """Every seed in every variation."""
        return tuple(Start(v, s) for v in range(self.variations) for s in range(self.seeds))

    def some_starts(self, most: int | None = None) -> tuple[Start, ...]:
        """Every seed once, with the variations in turn.

        Args:
            most: Maximum number of seeds.
        """
        return self.later_starts(0, self.seeds if most is None else min(most, self.seeds))

    def later_starts(self, first: int, end: int) -> tuple[Start, ...]:
        """Every seed from the first to before the end, once, with the variations in turn."""
        return tuple(sorted(Start(seed % self.variations, seed) for seed in range(first, end)))

    def ask(
        self,
        function: Callable[[EnvCache, Any], Any],
        starts: Sequence[Start],
        label: str,
        *,
        about: Sequence[Any] | None = None,
    ) -> Iterator[Any]:
        """Distribute work, and yield the results in order.

        Args:
            function: A function of a module, called with a cache and a start, or an item.
            starts: The starts of the episodes, in the order of their variations.
            label: Label of the progress display.
            about: A picklable item for each start, passed instead of the start.

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
        """The expert's episode from each start; played only once.

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
