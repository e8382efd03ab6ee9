"""How well behaviour cloning learns the tasks of the suites, by the rules of the benchmark.

    python benchmarks/suites.py [--suites single pairs trios quads] [--only TASK...] [--jobs 2]

Runs `taskbuilder benchmark SUITE --track imitation --algorithm bc --preset precise --seeds 11` in
runs/suites/SUITE-imitation-bc, and keeps what submissions keep in a folder of that name in
benchmarks/results/suites: the page, the picture and the numbers. Beside them, records.tar.xz has
the records of all cells and their certificates, so that a later run goes on where this one ended,
on another machine, too. Everything is kept after each cell. A cell takes about eight minutes of CPU
time. What was measured of a task that has a new version since is forgotten.
"""

from __future__ import annotations

import argparse
import re
import shlex
import shutil
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path

import taskbuilder
from taskbuilder.benchmark.page import DATA, PAGE, PICTURE, TABLE, write_report
from taskbuilder.benchmark.records import (
    ABOUT,
    CELLS,
    SHARED,
    TASKS,
    CellRecord,
    read_about,
    write,
)
from taskbuilder.benchmark.results import read_results, success_at_end
from taskbuilder.schema.summaries import summarize

RESULTS = Path(__file__).parent / "results" / "suites"
RECORDS = "records.tar.xz"
SUITES = ("single", "pairs", "trios", "quads")
TRACK, ALGORITHM, PRESET, SEEDS = "imitation", "bc", "precise", (11,)
TUNING_RUNS = 13
"""Eight of benchmarks/recovery.py, and five to choose the angle by which scenes are turned."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--suites", nargs="+", default=SUITES, help="suites")
    parser.add_argument("--only", nargs="+", help="tasks; by default all of the suites")
    parser.add_argument("--jobs", type=int, default=1, help="cells at once")
    parser.add_argument("--folder", type=Path, default=Path("runs/suites"), help="for all files")
    arguments = parser.parse_args()
    for suite in arguments.suites:
        tasks = taskbuilder.load_suite(suite).tasks
        only = [task for task in arguments.only or tasks if task in tasks]
        folder = arguments.folder / f"{suite}-{TRACK}-{ALGORITHM}"
        # A few tasks at once, so that what was done in time is whole if time runs out.
        for first in range(0, len(only), arguments.jobs):
            run(suite, only[first : first + arguments.jobs], folder, arguments.jobs)
    return 0


def run(suite: str, only: list[str], folder: Path, jobs: int) -> None:
    """Run tasks of a suite, or go on with them, and keep the results."""
    kept = RESULTS / folder.name
    if not (folder / ABOUT).exists() and (kept / RECORDS).exists():
        with tarfile.open(kept / RECORDS) as archive:
            archive.extractall(folder, filter="data")
    if (folder / ABOUT).exists():
        renew(folder)

    def keep(cell: CellRecord) -> None:
        print(f"{cell.task}: {cell.status} {100.0 * success_at_end(cell):.1f} %", flush=True)
        write_report([read_results(folder)], folder)
        kept.mkdir(parents=True, exist_ok=True)
        for name in (PAGE, PICTURE, TABLE, DATA):
            shutil.copy(folder / name, kept / name)
        pack(folder, kept / RECORDS)

    taskbuilder.benchmark(
        suite,
        folder,
        track=TRACK,
        algorithm=ALGORITHM,
        preset=PRESET,
        seeds=SEEDS,
        tuning_runs=TUNING_RUNS,
        only=only,
        jobs=jobs,
        command=shlex.join(["python", *sys.argv]),
        report=keep,
    )


def renew(folder: Path) -> None:
    """Forget what was measured of tasks that have a new version since."""
    about, catalogue = read_about(folder), taskbuilder.catalogue()
    now = {task: summarize(catalogue.task(task), catalogue).version for task in about.suite.tasks}
    for task, version in now.items():
        if version == about.suite.version(task):
            continue
        print(f"{task}: version {version} is to be measured", flush=True)
        for place in (CELLS, TASKS, SHARED):
            for old in (folder / place).glob("*"):
                if re.fullmatch(rf"{task}(-\d+)?(\.json)?", old.name):
                    shutil.rmtree(old) if old.is_dir() else old.unlink()
    suite = about.suite.model_copy(update={"versions": tuple(now.values())})
    write(folder / ABOUT, about.model_copy(update={"suite": suite}))


def pack(folder: Path, archive: Path) -> None:
    """Keep the records of a benchmark: what goes on from them gives the same results."""
    part = archive.with_name(f"{archive.name}.part")
    with tarfile.open(part, "w:xz") as packed:
        for file in sorted(_records(folder)):
            packed.add(file, file.relative_to(folder), filter=_anonymous)
    part.replace(archive)


def _records(folder: Path) -> Iterator[Path]:
    yield folder / ABOUT
    yield from (folder / TASKS).glob("*.json")
    yield from (folder / SHARED).glob("[!.]*.json")
    for cell in (folder / CELLS).iterdir():
        yield from cell.glob("*.json")


def _anonymous(entry: tarfile.TarInfo) -> tarfile.TarInfo:
    entry.uid = entry.gid = entry.mtime = 0
    entry.uname = entry.gname = ""
    return entry


if __name__ == "__main__":
    sys.exit(main())
