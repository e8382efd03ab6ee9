"""Validation in a child process, which protects the caller from the description.

The owner never imports the description. It receives each result as soon as there is one. If the
child process is killed or stopped from outside, another one continues from there.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from taskbuilder.env.loading import load_with
from taskbuilder.env.options import Options
from taskbuilder.errors import FileError, Finding, Location
from taskbuilder.jobs import DONE, RAISED, TRIES, LostError, Worker, packed, say, tell_of_loss
from taskbuilder.jobs import wait_for as wait_for_words
from taskbuilder.processes import Fault
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task
from taskbuilder.task import Task
from taskbuilder.validate.broken import broken_family
from taskbuilder.validate.checks.static import static_failure
from taskbuilder.validate.losses import finding_of_loss, lost_family, refused_import
from taskbuilder.validate.report import Progress, TaskReport

Level = Literal["static", "build", "full"]

START_LIMIT_S = 120.0
"""Time limit for the process to load its modules, in seconds."""

IMPORT, CHECK = "import", "check"
"""The parts of a validation before its families."""


@dataclass(frozen=True)
class Limits:
    """Time limits, in seconds.

    Attributes:
        import_s: For the import of a description, and again for its inspection.
        piece_s: For a unit of work,
        step_s: plus this for each control step of an episode.
    """

    import_s: float = 30.0
    piece_s: float = 20.0
    step_s: float = 0.8

    def piece(self, steps: int) -> float:
        """Time limit of a unit of work, for episodes of a given number of control steps."""
        return self.piece_s + self.step_s * steps


LIMITS = Limits()


@dataclass(frozen=True)
class Kept:
    """The intermediate result of a validation.

    Attributes:
        report: The report on the finished families.
        state: Their state, for the families that follow.
    """

    report: TaskReport
    state: Any


@dataclass(frozen=True)
class ValidationConfig:
    """The arguments of a validation.

    Attributes:
        reference: Name or path of the task.
        level: The level of the validation.
        seeds: Number of seeds per variation.
        catalogue: The catalogue that names are looked up in.
        jobs: Number of processes that play episodes.
        only: Names of the families to run; None for all.
        limits: The time limits.
        kept: Intermediate result of a process that was lost.
        options: Options of every environment of the task.
    """

    reference: str
    level: Level
    seeds: int
    catalogue: Catalogue
    jobs: int
    only: tuple[str, ...] | None
    limits: Limits = field(default_factory=lambda: LIMITS)
    kept: Kept | None = None
    options: Options = field(default_factory=Options)

    def load(self, *, guarded: bool = False) -> Task:
        """Load the task, with the changes of the options.

        Args:
            guarded: Whether to import the description in a child process first.
        """
        return load_with(self.options, self.reference, catalogue=self.catalogue, guarded=guarded)


class Listener(Protocol):
    """Receives events of a validation."""

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """Report that a part has begun: a family, the import or the inspection.

        Args:
            part: Its name.
            limit_s: Time limit of a unit of its work.
            rest: The families after it.
        """

    def alive(self) -> None:
        """Report that the work goes on."""

    def done(self, kept: Kept) -> None:
        """Report that a part is done."""

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """Report the progress over seeds, with a label."""


Save = Callable[[Kept], None]
"""Called with the results so far after each family."""


class Nobody:
    """Ignores most events, for a validation in the calling process.

    Args:
        progress: See `Progress`.
        save: Called with the results so far after each family.
    """

    def __init__(self, progress: Progress, save: Save) -> None:
        self._progress, self._save = progress, save

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """Report that a part has begun."""

    def alive(self) -> None:
        """Report that the work goes on."""

    def done(self, kept: Kept) -> None:
        """Report that a part is done."""
        self._save(kept)

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """Report the progress over seeds, with a label."""
        return self._progress(seeds, label)


# --- in the process


@dataclass(frozen=True)
class Begun:
    """A part of a validation has begun: a family, the import or the inspection.

    Attributes:
        part: Its name.
        limit_s: Time limit of a unit of its work.
        rest: The families after it.
    """

    part: str
    limit_s: float
    rest: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Shown:
    seeds: tuple[int, ...]
    label: str


@dataclass(frozen=True)
class _Alive:
    one_more: bool = False  # of the seeds that are shown


class Owner:
    """Sends events to the owner of this process."""

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """Report that a part has begun."""
        say(Begun(part, limit_s, rest))

    def alive(self) -> None:
        """Report that the work goes on."""
        say(_Alive())

    def done(self, kept: Kept) -> None:
        """Report that a part is done."""
        say(kept)

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """Report the progress over seeds, with a label."""
        listed = tuple(seeds)
        say(_Shown(listed, label))
        for seed in listed:
            say(_Alive(one_more=True))
            yield seed
        say(_Alive(one_more=True))


# --- in its owner


def watch(
    function: Callable[[ValidationConfig], TaskReport],
    config: ValidationConfig,
    progress: Progress,
    save: Save = lambda _: None,
) -> TaskReport:
    """Run a validation in a child process.

    Args:
        function: A function of a module that runs the validation and reports to an `Owner`.
        config: The arguments of the validation.
        progress: Wraps the seeds of a family to show progress.
        save: Called with the results so far after each family.

    Raises:
        LostError: The process does not start.
    """
    with closing(_Watch(function, config, progress, save)) as watched:
        return watched.report()


class _Watch:
    """The owner's view of a validation in a child process."""

    def __init__(
        self,
        function: Callable[[ValidationConfig], TaskReport],
        config: ValidationConfig,
        progress: Progress,
        save: Save,
    ) -> None:
        self._function = function
        self._save = save
        self._orders = config
        self._progress = progress
        self._worker = Worker({}, prepared=function.__module__)
        self._losses: dict[str, int] = {}
        self._begin()

    def close(self) -> None:
        """End the process."""
        self._worker.end()

    def report(self) -> TaskReport:
        """The report, also if the process is lost."""
        while True:
            try:
                for kind, value in self._heard():
                    if kind == RAISED:
                        return self._broken(value)
                    if kind == DONE:
                        found: TaskReport = value
                        return found
                    self._take(value)
            except LostError as lost:
                part = self._begun.part
                self._losses[part] = self._losses.get(part, 0) + 1
                if not lost.fault.outside or self._losses[part] == TRIES:
                    return self._without(lost)
                tell_of_loss(lost.fault)
                self._begin()

    def _begin(self) -> None:
        self._begun, self._started = Begun("", START_LIMIT_S), time.perf_counter()
        self._shown: Iterator[int] = iter(())
        self._worker.give(packed(self._function, self._orders))

    def _heard(self) -> list[tuple[str, Any]]:
        wait_for_words([self._worker])
        heard = self._worker.hear()
        if not heard:
            self._worker.check(self._begun.limit_s)
        return heard

    def _take(self, said: Any) -> None:
        if isinstance(said, Begun):
            self._begun, self._started = said, time.perf_counter()
        elif isinstance(said, _Shown):
            self._shown = iter(self._progress(said.seeds, said.label))
        elif isinstance(said, Kept):
            self._orders = replace(self._orders, kept=said)
            self._save(said)
        elif said.one_more:
            next(self._shown, None)

    def _broken(self, error: Exception) -> TaskReport:
        """The report if the validation raised an error: the families so far, and one that failed.

        Raises:
            Exception: The same error, before the first family has begun.
        """
        kept = self._orders.kept
        if kept is None:
            raise error
        place = Location(self._orders.catalogue.task(self._orders.reference).file, 1, 1)
        seconds = time.perf_counter() - self._started
        return replace(
            kept.report,
            families=(
                *kept.report.families,
                broken_family(self._begun.part, error, place, seconds),
            ),
            skipped=(*kept.report.skipped, *self._begun.rest),
        )

    def _without(self, lost: LostError) -> TaskReport:
        """The report if the process was lost repeatedly."""
        reference, kept = self._orders.reference, self._orders.kept
        part = self._begun.part
        if not part:
            raise lost
        if part in (IMPORT, CHECK):
            findings = self._refused(lost.fault, part)
            return TaskReport(reference, reference, (static_failure(findings),))
        if kept is None:
            raise lost
        finding = finding_of_loss(lost.fault, self._orders.catalogue.task(reference))
        seconds = time.perf_counter() - self._started
        return replace(
            kept.report,
            families=(*kept.report.families, lost_family(part, finding, seconds)),
            skipped=(*kept.report.skipped, *self._begun.rest),
        )

    def _refused(self, fault: Fault, part: str) -> tuple[Finding, ...]:
        """The report on a task whose description does not return from its import."""
        entry = self._orders.catalogue.task(self._orders.reference)
        found = refused_import(fault, entry, looked_over=part == CHECK)
        try:
            return (*read_task(entry, self._orders.catalogue).warnings, found)
        except FileError as error:
            return (*error.findings, found)
