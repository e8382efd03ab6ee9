"""Caches of a validating process: the environments and experts of its task."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from taskbuilder.description.load import is_interrupt
from taskbuilder.env.loading import load_with
from taskbuilder.env.options import Options
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import Finding
from taskbuilder.expert.script.player import Expert, has_expert
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task
from taskbuilder.validate.locate import failure_of_description

SMALL = (32, 24)
"""Size of observed images during validation; the checks do not depend on it."""


class Start(NamedTuple):
    """The beginning of an episode."""

    variation: int
    seed: int

    def __str__(self) -> str:
        where = f", variation {self.variation}" if self.variation else ""
        return f"seed {self.seed}{where}"


@dataclass(frozen=True)
class EnvSource:
    """The source of the task, for every process of a validation.

    Attributes:
        reference: Name or path of the task.
        catalogue: The catalogue that names are looked up in.
        number: Number of the validation, so that files that have changed since another are reread.
        options: Options of every environment of the task.
    """

    reference: str
    catalogue: Catalogue
    number: int
    options: Options = field(default_factory=Options)


class EnvCache:
    """A task's environments in this process, one a variation, and an expert for each.

    Args:
        task: The task.
        options: Options of all environments.
    """

    def __init__(self, task: Task, options: Options | None = None) -> None:
        self.task, self.options = task, options or Options()
        self._envs: dict[tuple[int, int | None, bool], TaskEnv] = {}
        self._experts: dict[tuple[int, int | None, bool], Expert] = {}

    @property
    def has_expert(self) -> bool:
        """Whether the task has an expert whose action modes can be planned for."""
        return has_expert(self.task)

    def env(self, variation: int, horizon: int | None = None, *, endless: bool = False) -> TaskEnv:
        """The environment of a variation, for a new episode.

        Args:
            variation: Number of the variation.
            horizon: Length of an episode in control steps; by default the task's.
            endless: Ignore the task's ``ends_on``, so that episodes end by their length only.
        """
        key = (variation, horizon, endless)
        if key not in self._envs:
            task = _endless(self.task) if endless else self.task
            options = replace(self.options, variation=variation, camera_size=SMALL)
            if horizon is not None:
                options = replace(options, horizon=horizon)
            self._envs[key] = TaskEnv(task, options)
        return self._envs[key]

    def expert(
        self, variation: int, horizon: int | None = None, *, endless: bool = False
    ) -> Expert:
        """The expert for this environment."""
        key = (variation, horizon, endless)
        if key not in self._experts:
            self._experts[key] = Expert(self.env(variation, horizon, endless=endless))
        return self._experts[key]

    def close(self) -> None:
        """Close all environments."""
        for expert in self._experts.values():
            expert.close()
        for env in self._envs.values():
            env.close()
        self._experts.clear()
        self._envs.clear()


def _endless(task: Task) -> Task:
    """The task without termination by success or failure."""
    spec = task.file.spec
    timing = spec.timing.model_copy(update={"ends_on": ()})
    return replace(task, file=replace(task.file, spec=spec.model_copy(update={"timing": timing})))


_CACHES: dict[EnvSource, EnvCache] = {}
"""The caches of this process."""


def open_cache(source: EnvSource, task: Task | None = None) -> EnvCache:
    """Open this process's cache for a validation.

    Args:
        source: The source of the task.
        task: The task, if it has been loaded already.
    """
    if source not in _CACHES:
        loaded = task or load_with(source.options, source.reference, catalogue=source.catalogue)
        _CACHES[source] = EnvCache(loaded, source.options)
    return _CACHES[source]


def close_cache(source: EnvSource) -> None:
    """Close the cache of this process for a validation, if there is one."""
    cache = _CACHES.pop(source, None)
    if cache is not None:
        cache.close()


class DescriptionError(Exception):
    """A description raised an error.

    Attributes:
        finding: The error and its line.
    """

    def __init__(self, finding: Finding) -> None:
        super().__init__(finding)
        self.finding = finding


def at_work(function: Callable[[EnvCache, Any], Any], source: EnvSource, item: Any) -> Any:
    """Run a unit of work in this process; sent to workers.

    Args:
        function: A function of a module, called with the process's cache and the item.
        source: The source of the task.
        item: The item of work.

    Raises:
        DescriptionError: The description raised an error.
    """
    cache = open_cache(source)
    try:
        return function(cache, item)
    except BaseException as error:
        if is_interrupt(error):
            raise
        raise DescriptionError(failure_of_description(error, cache.task.file.entry)) from None
