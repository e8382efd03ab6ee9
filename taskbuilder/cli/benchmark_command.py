"""`taskbuilder benchmark`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path

from taskbuilder.benchmark.page import write_report
from taskbuilder.benchmark.records import CellRecord
from taskbuilder.benchmark.results import MethodResults, as_data, read_several, success_at_end
from taskbuilder.benchmark.running import benchmark
from taskbuilder.benchmark.tables import beside_table, marks, suite_table, task_table
from taskbuilder.cli.output import paint, print_json, print_table, print_title, say
from taskbuilder.cli.spreading import check_spread
from taskbuilder.cli.tasks import catalogue_of, make_folder
from taskbuilder.errors import UsageError, display_path

OPTIONS = {
    "track": "--track",
    "algorithm": "--algorithm",
    "policy": "--policy",
    "preset": "--preset",
    "set": "--set",
    "seeds": "--seeds",
    "smoke": "--smoke",
    "only": "--only",
    "shared": "--shared",
    "tuning_runs": "--tuning-runs",
    "jobs": "--jobs",
    "ray": "--ray",
}
"""What only a run takes, and no report."""


def run(arguments: argparse.Namespace) -> int:
    """Run a benchmark, or report what has been run; status 1 if a cell failed or is missing."""
    several = _reported(arguments) if arguments.report else [_ran(arguments)]
    folder: Path = arguments.out or several[0].folder
    files = write_report(several, folder)
    if arguments.json:
        print_json({**as_data(several), "files": [display_path(file) for file in files]})
    else:
        _print(several, files)
    return int(any(each.missing or each.problems for each in several))


def _ran(arguments: argparse.Namespace) -> MethodResults:
    """The results of a run.

    Raises:
        UsageError: An argument is missing.
    """
    check_spread(arguments)
    if not arguments.suite:
        raise UsageError("which suite? name one, such as seed, or --report DIR")
    for name in ("track", "out"):
        if not getattr(arguments, name):
            raise UsageError(f"which {'folder' if name == 'out' else name}? give --{name}")
    make_folder(arguments.out)
    return benchmark(
        arguments.suite,
        arguments.out,
        track=arguments.track,
        algorithm=arguments.algorithm,
        policy=arguments.policy,
        preset=arguments.preset,
        settings=arguments.set or (),
        seeds=arguments.seeds,
        smoke=arguments.smoke,
        only=arguments.only,
        shared=arguments.shared,
        tuning_runs=arguments.tuning_runs,
        jobs=arguments.jobs or 1,
        ray=arguments.ray,
        catalogue=catalogue_of(arguments),
        command=shlex.join(["taskbuilder", *arguments.words]),
        report=(lambda _: None) if arguments.json else _tell,
    )


def _reported(arguments: argparse.Namespace) -> list[MethodResults]:
    """The results of the folders of --report.

    Raises:
        UsageError: There are more arguments, or nothing says where the report goes.
    """
    given = [flag for name, flag in OPTIONS.items() if getattr(arguments, name)]
    if arguments.suite or given:
        more = " and ".join(given or [arguments.suite])
        raise UsageError(f"--report reports what is there; leave {more} out")
    several = read_several(arguments.report)
    if len(several) > 1 and not arguments.out:
        raise UsageError("where is the report of several methods to go? give --out DIR")
    if arguments.out:
        make_folder(arguments.out)
    return several


def _tell(cell: CellRecord) -> None:
    """A line about a cell that is finished."""
    head = f"{cell.task}, seed {cell.seed}: "
    if cell.status == "done":
        rate = paint(f"{success_at_end(cell):.1%}", "bold")
        minutes = (cell.train_cpu_s + cell.evaluate_cpu_s) / 60.0
        say(f"{head}{rate} at the last step, {minutes:.1f} CPU min")
        return
    what = "not possible on this track" if cell.status == "impossible" else "failed"
    say(f"{head}{paint(what, 'red')}: {cell.reason.partition(chr(10))[0]}")


# Showing


def _print(several: Sequence[MethodResults], files: Sequence[Path]) -> None:
    about = several[0].about
    print()
    print_title(f"{about.suite.name} · {about.track.label}")
    for results in several:
        print()
        if len(several) > 1:
            print(paint(results.name, "bold"))
        print_table(task_table(results))
        for each in results.problems:
            print(f"{each.task}: {each.reason.partition(chr(10))[0]}")
        if results.missing:
            what = "cell is" if results.missing == 1 else "cells are"
            print(f"{results.missing} {what} missing; the same command without --only goes on")
    print_table(marks(several))
    if len(several) > 1:
        print()
        print_table(beside_table(several))
    print()
    _print_figures(several)
    print("\n" + "\n".join(display_path(file) for file in files))


def _print_figures(several: Sequence[MethodResults]) -> None:
    """The figures of the suite, a method after the other: names may be long."""
    head, *rows = suite_table(several)
    for row in rows:
        print(paint(row[0], "bold"))
        print_table([list(pair) for pair in zip(head[1:], row[1:], strict=True)], indent="  ")
