"""What a process keeps of the task that it validates: environments and experts, made once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from taskbuilder.description.load import is_interrupt
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.errors import Finding
from taskbuilder.expert.named import has_expert
from taskbuilder.expert.script.player import Expert
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.validate.places import failure_of_description

SMALL = (32, 24)
"""Size of the pictures that agents see meanwhile; what is checked does not depend on it."""


class Start(NamedTuple):
    """The beginning of an episode."""

    variation: int
    seed: int

    def __str__(self) -> str:
        where = f", variation {self.variation}" if self.variation else ""
        return f"seed {self.seed}{where}"


@dataclass(frozen=True)
class Source:
    """Where every process of a validation finds the task.

    Attributes:
        reference: Its name in the catalogue, or its path.
        catalogue: Where names are looked up.
        run: Number of the validation: files that have changed since another are read anew.
    """

    reference: str
    catalogue: Catalogue
    run: int


class Studio:
    """A task's environments in this process, one a variation, and an expert for each.

    Args:
        task: The task.
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        self._envs: dict[tuple[int, int | None, bool], TaskEnv] = {}
        self._experts: dict[tuple[int, int | None, bool], Expert] = {}

    @property
    def has_expert(self) -> bool:
        """Whether the task has an expert, and one that can be planned for."""
        return has_expert(self.task)

    def env(self, variation: int, horizon: int | None = None, *, endless: bool = False) -> TaskEnv:
        """The environment of a variation, between episodes or in one that nobody needs any more.

        Args:
            variation: Which.
            horizon: Control steps of an episode; by default the task's.
            endless: Episodes end by their length alone, whatever the task's ``ends_on`` says.
        """
        key = (variation, horizon, endless)
        if key not in self._envs:
            task = _endless(self.task) if endless else self.task
            self._envs[key] = parallel_env(
                task, variation=variation, horizon=horizon, camera_size=SMALL
            )
        return self._envs[key]

    def expert(
        self, variation: int, horizon: int | None = None, *, endless: bool = False
    ) -> Expert:
        """The expert that plays in that environment."""
        key = (variation, horizon, endless)
        if key not in self._experts:
            self._experts[key] = Expert(self.env(variation, horizon, endless=endless))
        return self._experts[key]

    def close(self) -> None:
        """Free all physics."""
        for expert in self._experts.values():
            expert.close()
        for env in self._envs.values():
            env.close()
        self._experts.clear()
        self._envs.clear()


def _endless(task: Task) -> Task:
    """The task with episodes that neither success nor failure ends."""
    spec = task.file.spec
    timing = spec.timing.model_copy(update={"ends_on": ()})
    return replace(task, file=replace(task.file, spec=spec.model_copy(update={"timing": timing})))


_STUDIOS: dict[Source, Studio] = {}
"""Those of this process; a worker's go with the worker."""


def open_studio(source: Source, task: Task | None = None) -> Studio:
    """This process's studio for a validation.

    Args:
        source: Where the task is found.
        task: The task, where it has been loaded already.
    """
    if source not in _STUDIOS:
        loaded = task or load_task(source.reference, catalogue=source.catalogue)
        _STUDIOS[source] = Studio(loaded)
    return _STUDIOS[source]


def close_studio(source: Source) -> None:
    """Free what this process keeps for a validation, if it keeps anything."""
    studio = _STUDIOS.pop(source, None)
    if studio is not None:
        studio.close()


class DescriptionError(Exception):
    """A description raised an error while it was asked.

    Attributes:
        finding: Which, and at which line.
    """

    def __init__(self, finding: Finding) -> None:
        super().__init__(finding)
        self.finding = finding


def at_work(function: Callable[[Studio, Any], Any], source: Source, item: Any) -> Any:
    """Do a piece of work in this process; what a worker is sent.

    Args:
        function: Of a module, to be called with the process's studio and the item.
        source: Where the task is found.
        item: What the work is about.

    Raises:
        DescriptionError: The description raised an error.
    """
    studio = open_studio(source)
    try:
        return function(studio, item)
    except BaseException as error:
        if is_interrupt(error):
            raise
        raise DescriptionError(failure_of_description(error, studio.task.file.entry)) from None
