"""Running a benchmark: the cells of a suite in several processes or on a cluster, resumable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path

from taskbuilder.benchmark.cells import Cell, Report, Work, lost, run_cell, share
from taskbuilder.benchmark.page import drawing_needed, write_report
from taskbuilder.benchmark.records import LOCK, SHARED, About, Method, SuiteTasks, begin
from taskbuilder.benchmark.results import MethodResults, read_results
from taskbuilder.benchmark.tracks import Track, find_track
from taskbuilder.cluster import cluster
from taskbuilder.errors import TaskbuilderError, UsageError, display_path
from taskbuilder.files import claim
from taskbuilder.jobs import LostError, Map, workers
from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.runs import check_torch
from taskbuilder.learn.settings import read_settings
from taskbuilder.policies.grammar import PolicyLike, parse_policy
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.suites import Suite, find_suite
from taskbuilder.schema.summaries import summarize
from taskbuilder.wording import suggestion

SEEDS = (11, 12, 13)
"""Default training seeds."""

_AGAIN = "what is there stays; run the same command again to continue"


class BenchmarkError(TaskbuilderError):
    """A benchmark cannot go on; what there is stays."""


Places = Callable[[int], AbstractContextManager[Map]]
"""Makes a `map` over places of work, given the number of pieces."""


def benchmark(
    suite: str | Suite,
    out: str | Path,
    *,
    track: str | Track = "imitation",
    algorithm: str | None = None,
    policy: PolicyLike | None = None,
    preset: str | None = None,
    settings: Sequence[str] = (),
    seeds: Iterable[int] | None = None,
    smoke: bool = False,
    only: Iterable[str] | None = None,
    shared: str | Path | None = None,
    tuning_runs: int | None = None,
    jobs: int = 1,
    ray: str | None = None,
    catalogue: Catalogue | None = None,
    command: str = "",
    report: Report = lambda _: None,
) -> MethodResults:
    """Measure a method on a suite by the protocol of a track, or go on with that.

    Args:
        suite: The suite, or its name.
        out: Folder of the benchmark: new, empty, or one of the same suite, track and method.
        track: The track, or its name. A changed track can be run, and is marked as such.
        algorithm: The algorithm that trains the policies, the library's own or of a package.
        policy: In place of an algorithm: policies that exist, which are only evaluated, as
            `parse_policy` reads them. In a text, ``{task}`` and ``{seed}`` stand for the task and
            the seed of a cell.
        preset: Preset of the algorithm's settings.
        settings: Settings of the algorithm, such as ``noise=0.1``.
        seeds: Training seeds; by default 11, 12 and 13.
        smoke: Whether to run the short version of the track, whose results are not comparable.
        only: Names of tasks of the suite to run now; by default all.
        shared: Folder of demonstrations and baselines that several methods share; by default within
            the first.
        tuning_runs: Training runs that were spent on choosing the settings, as the report declares.
        jobs: Number of processes. Results do not depend on it.
        ray: Address of a Ray cluster in place of processes; all nodes need the folder.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        command: The command, to be recorded.
        report: Called with the record of every cell.

    Returns:
        The results, as far as they are there. The folder has them as a table, a picture and a page.

    Raises:
        UnknownNameError: There is no such suite, track or policy.
        UsageError: A value is invalid, the method does not fit the track, or the folder holds
            something else.
        BenchmarkError: Somebody ended the processes.
        OSError: Something cannot be written.
    """
    catalogue = catalogue or Catalogue.discover()
    found = suite if isinstance(suite, Suite) else find_suite(suite, catalogue)
    if not found.tasks:
        raise UsageError(f'the suite "{found.name}" has no tasks')
    if isinstance(track, Track) and smoke:
        raise UsageError("smoke shortens a track of the library by its name; shorten yours itself")
    chosen = track if isinstance(track, Track) else find_track(track, smoke=smoke)
    method = _method(chosen, algorithm, policy, preset, settings)
    about = About(
        suite=SuiteTasks(
            name=found.name,
            tasks=found.tasks,
            train=found.train.variations,
            test=found.test.variations,
            versions=tuple(summarize(catalogue.task(n), catalogue).version for n in found.tasks),
        ),
        track=chosen,
        method=method,
        seeds=_seeds(method, seeds),
        tuning_runs=tuning_runs,
        command=command,
    )
    tasks = _tasks(about, only)
    with drawing_needed():  # not after hours of training
        import taskbuilder.visual.profiles  # noqa: F401 - to find out now whether it can be imported; the report at the end needs it
    folder = Path(out).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    own = None if policy is None or isinstance(policy, str | Path) else policy
    places = partial(_cluster, ray) if ray else partial(_processes, jobs)
    with _locked(folder):
        cells = [Cell(task, seed) for task in tasks for seed in about.seeds]
        there = begin(folder, about)
        place = Path(shared).resolve() if shared else folder / SHARED
        _run(Work(there, folder, place, catalogue, own), tasks, cells, places, report)
        results = read_results(folder)
        write_report([results], folder)
    return results


def _method(
    track: Track,
    algorithm: str | None,
    policy: PolicyLike | None,
    preset: str | None,
    settings: Sequence[str],
) -> Method:
    """The method, if the track can have it.

    Raises:
        UsageError: It cannot.
    """
    if (algorithm is None) == (policy is None):
        raise UsageError(
            "name either an algorithm, which trains policies, or a policy; one of them"
        )
    if policy is not None:
        if preset or settings:
            raise UsageError("a policy has no preset and no settings; those are of algorithms")
        text = policy if isinstance(policy, str | Path) else parse_policy(policy).name
        if "{" not in str(text):
            parse_policy(policy)  # what is wrong with it is told before anything begins
        return Method(policy=str(text))
    name = algorithm or ""
    kind = find_algorithm(name)
    check_torch()
    if kind.from_data != bool(track.demonstrations):
        how = "learns from a data set" if kind.from_data else "learns by acting"
        what = "has demonstrations alone" if track.demonstrations else "has no demonstrations"
        others = "reinforcement" if track.demonstrations else "imitation or vision"
        raise UsageError(f"{name} {how}, and the track {track.name} {what}; take --track {others}")
    if preset and preset not in kind.presets:
        raise UsageError(f'no preset "{preset}"; {suggestion(preset, kind.presets, what="one of")}')
    read_settings(kind.settings, settings)
    return Method(algorithm=name, preset=preset or "", settings=tuple(settings))


def _seeds(method: Method, given: Iterable[int] | None) -> tuple[int, ...]:
    """The seeds of the cells of a task.

    Raises:
        UsageError: There are none, or the policy does not depend on them.
    """
    if given is not None and not (method.algorithm or "{seed}" in method.policy):
        raise UsageError(
            f"{method.policy} is not trained here, so it has no seeds; leave them out, or write "
            "{seed} into the name of the policy"
        )
    if given is None:
        return SEEDS if method.algorithm or "{seed}" in method.policy else SEEDS[:1]
    seeds = tuple(dict.fromkeys(given))
    if not seeds or min(seeds) < 0:
        raise UsageError("there is at least one seed, and seeds are at least 0")
    return seeds


def _tasks(about: About, only: Iterable[str] | None) -> tuple[str, ...]:
    """The tasks to run now.

    Raises:
        UsageError: One is not in the suite.
    """
    asked = about.suite.tasks if only is None else tuple(dict.fromkeys(only))
    for task in asked:
        if task not in about.suite.tasks:
            help_ = suggestion(task, about.suite.tasks, what="it has")
            raise UsageError(f'the suite {about.suite.name} has no task "{task}"; {help_}')
    return asked


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Lock a folder against other processes.

    Raises:
        UsageError: Another process has it.
    """
    with (folder / LOCK).open("w") as file:
        if not claim(file):
            raise UsageError(f"another process is running the benchmark in {display_path(folder)}")
        yield


def _processes(jobs: int, pieces: int) -> AbstractContextManager[Map]:
    # A last cell that may end its process does not get this one, where several were asked for.
    return workers(min(jobs, max(pieces, 2)))


def _cluster(address: str, pieces: int) -> AbstractContextManager[Map]:
    del pieces
    return cluster(address)


def _run(
    work: Work, tasks: Sequence[str], cells: Sequence[Cell], places: Places, report: Report
) -> None:
    """Do everything that is not there yet.

    Raises:
        BenchmarkError: Somebody ended a process, or what cells share took one with it.
    """
    left = list(cells)
    while left:
        try:
            with places(len(left)) as spread:
                for _ in spread(partial(share, work), tasks):
                    pass
                for record in spread(partial(run_cell, work), tuple(left)):
                    report(record)
                    left.pop(0)
        except LostError as gone:  # its processes have ended, before others go on with the rest
            if gone.fault.outside or gone.item not in left:
                raise BenchmarkError(f"{gone}\n{_AGAIN}") from gone
            left.remove(gone.item)
            report(lost(work, gone.item, str(gone)))
