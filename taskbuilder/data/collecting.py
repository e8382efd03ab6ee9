"""Collecting a data set: episodes played in several processes or on several machines, resumable.

Attempts are numbered, and each has a seed, a variation and a policy that follow from its number.
Every attempt is written on its own, whole or not at all, so that it does not matter when a process
is killed, how many there are, or in what order they end: the files are the same in the end. Nodes
of a cluster need not reach the folder; what they play is written here.
"""

from __future__ import annotations

import errno
import json
import shutil
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from taskbuilder.carried import carry
from taskbuilder.data import layout
from taskbuilder.data.card import card_text
from taskbuilder.data.index import make_index
from taskbuilder.data.plan import (
    Attempt,
    CollectPlan,
    changes,
    check_plan,
    describe,
)
from taskbuilder.data.playing import (
    AttemptResult,
    CollectJob,
    EpisodePlayer,
    play_and_write,
    play_elsewhere,
)
from taskbuilder.data.schedule import Series, next_attempts, series_of
from taskbuilder.data.videos import require_video
from taskbuilder.errors import (
    TaskbuilderError,
    UsageError,
    display_path,
)
from taskbuilder.files import write_whole
from taskbuilder.jobs import LostError, Map, workers
from taskbuilder.policies.grammar import Player
from taskbuilder.policies.mixture import players_of
from taskbuilder.task import Task

_ASIDE = tuple(f".{name}." for name in layout.OWN)
"""How files are called while they are written; a process that was killed may have left some."""


class CollectingError(TaskbuilderError):
    """Collecting cannot go on; what has been collected stays."""


class CollectProgress(NamedTuple):
    """How far collecting is.

    Attributes:
        kept: Episodes that are there.
        wanted: Episodes that there will be.
        failed: Attempts that failed.
        left_s: Seconds that it will still take at this pace, or None if that is not known.
    """

    kept: int
    wanted: int
    failed: int
    left_s: float | None


Report = Callable[[CollectProgress], None]


def collect(
    plan: CollectPlan,
    folder: Path,
    *,
    jobs: int = 1,
    nodes: Map | None = None,
    report: Report = lambda _: None,
    players: Mapping[str, Player] | None = None,
) -> None:
    """Collect a data set, or continue with one that was begun.

    Args:
        plan: What is collected.
        folder: Where to; it must be new, empty, or a data set of the same plan.
        jobs: Processes.
        nodes: A map over the nodes of a cluster, in place of processes; see `cluster.cluster`.
        report: Called after every attempt.
        players: The policies of the plan, by name; by default, they are read from their names.

    Raises:
        UnknownNameError: There is no policy of this name.
        UsageError: Something cannot be collected, the folder holds something else, or the data
            set in it was begun in another way.
        CollectingError: Too few attempts succeed, a process was lost, or the disk is full.
        FileError: A task has errors.
    """
    loaded = [plan.load(reference) for reference in plan.tasks]
    check_plan(plan, loaded)
    players = players or players_of(plan.policies)
    for task in loaded:
        for player in players.values():
            player.check_task(task, plan.catalogue)
    tasks = dict(zip(plan.tasks, loaded, strict=True))
    if plan.cameras.names:
        require_video()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with layout.locked(folder):
            about = describe(plan, loaded)
            begin_folder(folder, about)
            write_tasks(folder, loaded)
            # A node draws as this machine does, whatever else is installed there.
            drawn = replace(plan, renderer=about["renderer"] or plan.renderer)
            job = CollectJob(drawn, folder, players)
            if not layout.is_finished(folder):
                played = _play_all(job, tasks, report, jobs=jobs, nodes=nodes)
                finish_folder(folder, about, played)
            wanted = _wanted(plan, loaded)
            report(CollectProgress(wanted, wanted, 0, 0.0))
    except OSError as error:
        raise CollectingError(disk_words(error, folder)) from error
    except LostError as lost:
        raise CollectingError(
            f"{lost}\n{_there(folder)}; run the same command again to continue"
        ) from lost


def _wanted(plan: CollectPlan, tasks: Iterable[Task]) -> int:
    counts = [len(plan.played(task)) if plan.per_variation else 1 for task in tasks]
    return plan.episodes * sum(counts)


def begin_folder(folder: Path, about: Mapping[str, Any]) -> None:
    """Write what the data set says of itself, or compare it with what is there.

    Raises:
        UsageError: Something else is there.
    """
    where = display_path(folder)
    if links := [name for name in layout.OWN if (folder / name).is_symlink()]:
        raise UsageError(f"{where}: {links[0]} is a link; name a folder without links")
    strange = sorted(
        file.name
        for file in folder.iterdir()
        if file.name not in layout.OWN and not file.name.startswith(_ASIDE)
    )
    if not (folder / layout.ABOUT).exists():
        others = sorted({*strange, *(f.name for f in folder.iterdir() if f.name in layout.OWN)})
        if others:
            raise UsageError(
                f"{where} holds other files ({', '.join(others[:3])}); name a new or empty folder"
            )
        layout.write_json(folder / layout.ABOUT, about)
        return
    there, here = layout.read_about(folder), json.loads(json.dumps(about))
    differs = list(changes(there, here))
    if differs and there["collected"]["episodes"] and not _has_begun(folder):
        # It was refused, such as for a policy of another task. What people record begins empty.
        shutil.rmtree(folder / layout.TASKS, ignore_errors=True)
        layout.write_json(folder / layout.ABOUT, about)
    elif differs:
        raise UsageError(
            f"{where} holds a data set that was begun in another way; name another folder\n"
            + "\n".join(f"  {line}" for line in differs)
        )
    if strange and not layout.is_finished(folder):
        raise UsageError(
            f"{where} holds other files beside the data set ({', '.join(strange[:3])}); move them "
            "away"
        )


def _has_begun(folder: Path) -> bool:
    """Whether an attempt was recorded, or all were and are gone."""
    recorded = (folder / layout.EPISODES, folder / layout.FAILURES)
    return layout.is_finished(folder) or any(file for each in recorded for file in _entries(each))


def write_tasks(folder: Path, tasks: Sequence[Task]) -> None:
    """Write the files of tasks that come with no package, so that others can play them."""
    for task in tasks:
        carried = carry(task)
        for name, content in carried.files.items() if carried else ():
            file = folder / layout.TASKS / task.name / name
            file.parent.mkdir(parents=True, exist_ok=True)
            if not file.exists():
                write_whole(file, content, sync=True)


# --- the owner's side


Play = Callable[[Sequence[Attempt]], Generator[AttemptResult, None, None]]
"""Plays attempts and writes them, in order."""


def _play_all(
    job: CollectJob, tasks: Mapping[str, Task], report: Report, *, jobs: int, nodes: Map | None
) -> list[AttemptResult]:
    """Play attempts until there are enough episodes of every task."""
    counter = _Counter(_wanted(job.plan, tasks.values()), report)
    every: list[AttemptResult] = []
    with _players(job, jobs, nodes) as play:
        for reference, task in tasks.items():
            series = series_of(job.plan, reference, task)
            while upcoming := list(next_attempts(series)):
                with closing(play([attempt for _, attempt in upcoming])) as played:
                    for (own, _), done in zip(upcoming, played, strict=True):
                        own.results.append(done)
                        every.append(done)
                        counter.count(done)
                        _check_hope(task, series)
    return every


@contextmanager
def _players(job: CollectJob, jobs: int, nodes: Map | None) -> Iterator[Play]:
    """Who plays attempts: this process, several, or the nodes of a cluster."""
    if nodes is not None:
        yield partial(_play_on_nodes, job, nodes)
    elif jobs > 1:
        with workers(jobs) as spread:
            yield partial(_play_in_processes, job, spread)
    else:
        with closing(EpisodePlayer(job)) as player:
            yield partial(_play_here, job, player)


def _play_here(
    job: CollectJob, player: EpisodePlayer, attempts: Sequence[Attempt]
) -> Generator[AttemptResult, None, None]:
    for attempt in attempts:
        yield job.earlier(attempt) or job.write(player.play(attempt))


def _play_in_processes(
    job: CollectJob, spread: Map, attempts: Sequence[Attempt]
) -> Generator[AttemptResult, None, None]:
    yield from spread(partial(play_and_write, job), attempts)


def _play_on_nodes(
    job: CollectJob, nodes: Map, attempts: Sequence[Attempt]
) -> Generator[AttemptResult, None, None]:
    """Have attempts played that are not in the folder yet, and write them here."""
    there = {attempt: job.earlier(attempt) for attempt in attempts}
    missing = [attempt for attempt, result in there.items() if result is None]
    played = nodes(partial(play_elsewhere, job), missing)
    for attempt in attempts:
        yield there[attempt] or job.write(next(played))


class _Counter:
    """Counts attempts and estimates the time that is left.

    The pace is that since the first episode was there: what comes before it, such as compiling the
    renderer, comes only once.
    """

    def __init__(self, wanted: int, report: Report) -> None:
        self._wanted, self._report = wanted, report
        self._kept = self._failed = 0
        self._since = 0.0

    def count(self, done: AttemptResult) -> None:
        self._kept += done.kept
        self._failed += bool(done.reason)
        if done.kept and self._kept == 1:
            self._since = time.monotonic()
        left = None
        if self._kept > 1:
            pace = (time.monotonic() - self._since) / (self._kept - 1)
            left = pace * (self._wanted - self._kept)
        self._report(CollectProgress(self._kept, self._wanted, self._failed, left))


def _check_hope(task: Task, series: Sequence[Series]) -> None:
    """Stop where too few attempts succeed in all series of a task.

    Where only some variations are without hope, the others become a data set.

    Raises:
        CollectingError: So it is.
    """
    if not all(own.is_hopeless for own in series):
        return
    results = [result for own in series for result in own.results]
    kept = sum(result.kept for result in results)
    reason = next(result.reason for result in results if not result.kept)
    raise CollectingError(
        f"{kept} of {len(results)} attempts at {task.name} succeeded; the first failed because "
        f"{reason}\nTry taskbuilder demo {task.name}, or keep failures by --keep-failures"
    )


def finish_folder(folder: Path, about: Mapping[str, Any], played: Sequence[AttemptResult]) -> None:
    """Remove what is left over, and write index, card and manifest.

    Args:
        folder: Of the data set.
        about: What it says of itself.
        played: All attempts, in order.

    Raises:
        OSError: They cannot be written.
    """
    names = [done.name for done in played if done.kept]
    failed = [f"{done.name}.json" for done in played if not done.kept]
    _remove_others(folder / layout.EPISODES, names)
    _remove_others(folder / layout.FAILURES, failed)
    shutil.rmtree(folder / layout.PARTIAL, ignore_errors=True)
    index = make_index(folder, names, failed)
    layout.write_json(folder / layout.INDEX, index)
    write_whole(folder / layout.CARD, card_text(about, index).encode(), sync=True)
    layout.write_manifest(folder)


def _remove_others(folder: Path, names: Sequence[str]) -> None:
    wanted = set(names)
    for file in list(folder.iterdir()) if folder.is_dir() else ():
        if file.name not in wanted:
            shutil.rmtree(file) if file.is_dir() else file.unlink()
    if folder.is_dir() and not wanted:
        folder.rmdir()


def _there(folder: Path) -> str:
    count = sum(1 for _ in _entries(folder / layout.EPISODES))
    return f"{display_path(folder)} has {count} episode{'s' * (count != 1)} so far"


def _entries(folder: Path) -> Iterator[Path]:
    try:
        yield from folder.iterdir()
    except OSError:
        return


def disk_words(error: OSError, folder: Path) -> str:
    """Why nothing can be written to a folder, and what to do."""
    where = display_path(folder)
    reason = error.strerror or str(error)
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return (
            f"the disk of {where} is full\n{_there(folder)}; free space and run the same "
            "command again to continue"
        )
    if error.errno in (errno.EROFS, errno.EACCES, errno.EPERM):
        return f"nothing can be written to {where}: {reason}; name another folder"
    if error.errno in (errno.ENOTDIR, errno.EEXIST):
        return f"{where} is no folder; name another to write to"
    return f"{where}: {reason}\n{_there(folder)}; run the same command again to continue"
