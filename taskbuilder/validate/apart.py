"""A validation in a process of its own, which a description can end or hold up without harm.

The owner never imports the description. It is told of each result as soon as there is one; where
the process is killed or stopped from outside, another one goes on from there.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

from taskbuilder.errors import FileError, Finding
from taskbuilder.jobs import DONE, RAISED, TRIES, LostError, Worker, packed, say, tell_of_loss
from taskbuilder.jobs import wait_for as wait_for_words
from taskbuilder.processes import Fault
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task
from taskbuilder.validate.losses import finding_of_loss, lost_family, refused_import
from taskbuilder.validate.report import Progress, TaskReport
from taskbuilder.validate.static import static_failure

Level = Literal["static", "build", "full"]

START_LIMIT_S = 120.0
"""How long the process may take to load what it needs."""

IMPORT, CHECK = "import", "check"
"""The parts of a validation before its families."""


@dataclass(frozen=True)
class Limits:
    """How long things may take.

    Attributes:
        import_s: The import of a description; and then looking it over.
        piece_s: A piece of work,
        step_s: and so much more for each control step that an episode has.
    """

    import_s: float = 30.0
    piece_s: float = 20.0
    step_s: float = 0.8

    def piece(self, steps: int) -> float:
        """How long a piece of work may take where an episode has so many control steps."""
        return self.piece_s + self.step_s * steps


LIMITS = Limits()


@dataclass(frozen=True)
class Kept:
    """What a validation has come to so far.

    Attributes:
        report: Of the families that are done.
        state: What they leave for those that are yet to come.
    """

    report: TaskReport
    state: Any


@dataclass(frozen=True)
class Orders:
    """What is to be validated.

    Attributes:
        reference: The task's name in the catalogue, or its path.
        level: How far.
        seeds: How many episodes to sample where chance is involved.
        catalogue: Where names are looked up.
        jobs: How many processes play.
        only: Names of the families that are wanted; None for all.
        limits: How long things may take.
        kept: What another process came to before it was lost.
    """

    reference: str
    level: Level
    seeds: int
    catalogue: Catalogue
    jobs: int
    only: tuple[str, ...] | None
    limits: Limits = field(default_factory=lambda: LIMITS)
    kept: Kept | None = None


class Listener(Protocol):
    """Is told how a validation goes."""

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """A part begins: a family, or what comes before them.

        Args:
            part: Its name.
            limit_s: How long a piece of it may take.
            rest: The families after it.
        """

    def alive(self) -> None:
        """The validation goes on."""

    def done(self, kept: Kept) -> None:
        """A part is done."""

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """See `Progress`."""


class Nobody:
    """Is told nothing: the validation runs in the process that asked for it.

    Args:
        progress: See `Progress`.
    """

    def __init__(self, progress: Progress) -> None:
        self._progress = progress

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """See `Listener.begin`."""

    def alive(self) -> None:
        """See `Listener.alive`."""

    def done(self, kept: Kept) -> None:
        """See `Listener.done`."""

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """See `Progress`."""
        return self._progress(seeds, label)


# --- in the process


@dataclass(frozen=True)
class _Begun:
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
    """Hands on to this process's owner what it is told."""

    def begin(self, part: str, limit_s: float, rest: tuple[str, ...] = ()) -> None:
        """See `Listener.begin`."""
        say(_Begun(part, limit_s, rest))

    def alive(self) -> None:
        """See `Listener.alive`."""
        say(_Alive())

    def done(self, kept: Kept) -> None:
        """See `Listener.done`."""
        say(kept)

    def progress(self, seeds: Iterable[int], label: str) -> Iterable[int]:
        """See `Progress`."""
        listed = tuple(seeds)
        say(_Shown(listed, label))
        for seed in listed:
            say(_Alive(one_more=True))
            yield seed
        say(_Alive(one_more=True))


# --- in its owner


def watch(
    function: Callable[[Orders], TaskReport], orders: Orders, progress: Progress
) -> TaskReport:
    """Have a validation done by another process.

    Args:
        function: Of a module; carries out orders, and tells an `Owner`.
        orders: What is to be validated.
        progress: Wraps the seeds of a family to show progress.

    Raises:
        LostError: The process does not start.
    """
    with closing(_Watch(function, orders, progress)) as watched:
        return watched.report()


class _Watch:
    """What is known of a validation elsewhere."""

    def __init__(
        self, function: Callable[[Orders], TaskReport], orders: Orders, progress: Progress
    ) -> None:
        self._function = function
        self._orders = orders
        self._progress = progress
        self._worker = Worker({}, prepared=function.__module__)
        self._losses: dict[str, int] = {}
        self._begin()

    def close(self) -> None:
        """End the process."""
        self._worker.end()

    def report(self) -> TaskReport:
        """What it comes to, whatever happens to the process."""
        while True:
            try:
                for kind, value in self._heard():
                    if kind == RAISED:
                        raise value
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
        self._begun, self._started = _Begun("", START_LIMIT_S), time.perf_counter()
        self._shown: Iterator[int] = iter(())
        self._worker.give(packed(self._function, self._orders))

    def _heard(self) -> list[tuple[str, Any]]:
        wait_for_words([self._worker])
        heard = self._worker.hear()
        if not heard:
            self._worker.check(self._begun.limit_s)
        return heard

    def _take(self, said: Any) -> None:
        if isinstance(said, _Begun):
            self._begun, self._started = said, time.perf_counter()
        elif isinstance(said, _Shown):
            self._shown = iter(self._progress(said.seeds, said.label))
        elif isinstance(said, Kept):
            self._orders = replace(self._orders, kept=said)
        elif said.one_more:
            next(self._shown, None)

    def _without(self, lost: LostError) -> TaskReport:
        """The report where the process was lost for good."""
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
        """All that can be said of a task whose description does not come back."""
        entry = self._orders.catalogue.task(self._orders.reference)
        found = refused_import(fault, entry, looked_over=part == CHECK)
        try:
            return (*read_task(entry, self._orders.catalogue).warnings, found)
        except FileError as error:
            return (*error.findings, found)
