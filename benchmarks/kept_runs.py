"""Training runs that are kept: the plans, tables and results of a group in one compressed file.

    python benchmarks/kept_runs.py GROUP FOLDER            # unpack benchmarks/results/GROUP.tar.xz
    python benchmarks/kept_runs.py GROUP --keep RUN NAME   # put a run into it, under a name

Unpacked, a group is a folder with a folder for each run, as `taskbuilder plot` reads them. In the
tables of a run that is put into a group, numbers have four significant digits.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import io
import shutil
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
KEPT = ("run.json", "episodes.csv", "evaluations.csv", "updates.csv", "policy.npz")
DIGITS = 4


def unpack(group: str, folder: Path) -> Path:
    """Unpack a group of runs into a folder, and return the folder that has the runs."""
    with tarfile.open(RESULTS / f"{group}.tar.xz") as packed:
        packed.extractall(folder, filter="data")
    return folder / group


@contextmanager
def unpacked(group: str) -> Iterator[Path]:
    """A folder with the runs of a group, as long as it is needed."""
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
        yield unpack(group, Path(folder))


@contextmanager
def changed(group: str) -> Iterator[Path]:
    """A folder with the runs of a group; what is in it at the end is kept in its place."""
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
        runs = Path(folder, group)
        if (RESULTS / f"{group}.tar.xz").exists():
            unpack(group, Path(folder))
        runs.mkdir(exist_ok=True)
        yield runs
        pack(runs)


def pack(runs: Path) -> Path:
    """Write the file of a group, the same for the same runs, and return its path."""
    file = RESULTS / f"{runs.name}.tar.xz"
    begun = file.with_suffix(".part")
    with tarfile.open(begun, "w:xz", preset=9) as packed:
        # By kind first: what is alike compresses best side by side.
        for path in sorted(runs.rglob("*"), key=lambda path: (path.name, path)):
            if path.is_file():
                _add(packed, path, runs)
    return begun.replace(file)


def _add(packed: tarfile.TarFile, path: Path, runs: Path) -> None:
    """Add a file under the name of its group, without what would differ the next time."""
    content, name = path.read_bytes(), path.relative_to(runs.parent).as_posix()
    if path.suffix == ".gz":  # compressed twice, it would be larger
        content, name = gzip.decompress(content), name.removesuffix(".gz")
    entry = tarfile.TarInfo(name)
    entry.size = len(content)
    packed.addfile(entry, io.BytesIO(content))


def keep(group: str, run: Path, name: str) -> Path:
    """Put a run into a group, in the place of one of this name, and return the group's file."""
    with changed(group) as runs:
        folder = runs / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for file in (run / each for each in KEPT):
            if file.suffix == ".csv":
                _round(file, folder / file.name)
            else:
                shutil.copyfile(file, folder / file.name)
    return RESULTS / f"{group}.tar.xz"


def _round(table: Path, kept: Path) -> None:
    """Write a table with fewer digits; a last row that is not complete is left out."""
    with table.open(newline="") as lines, kept.open("w", newline="") as written:
        rows, writer = csv.reader(lines), csv.writer(written, lineterminator="\n")
        head = next(rows)
        writer.writerow(head)
        whole = (row for row in rows if len(row) == len(head))
        writer.writerows([_rounded(value) for value in row] for row in whole)


def _rounded(value: str) -> str:
    try:
        number = float(value)
    except ValueError:
        return value
    return value if number.is_integer() else f"{number:.{DIGITS}g}"


def main() -> None:
    """Unpack a group, or put a run into it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("group")
    parser.add_argument("folder", nargs="?", type=Path, help="where to unpack it")
    parser.add_argument("--keep", nargs=2, metavar=("RUN", "NAME"))
    arguments = parser.parse_args()
    if arguments.keep:
        run, name = arguments.keep
        print(keep(arguments.group, Path(run), name))
    else:
        print(unpack(arguments.group, arguments.folder))


if __name__ == "__main__":
    main()
