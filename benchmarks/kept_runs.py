"""Training runs that are kept: the plans, tables and results of a group in one compressed file.

    python benchmarks/kept_runs.py GROUP FOLDER    # unpack benchmarks/results/GROUP.tar.xz

Unpacked, a group is a folder with a folder for each run, as `taskbuilder plot` reads them.
"""

from __future__ import annotations

import gzip
import io
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


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


if __name__ == "__main__":
    print(unpack(sys.argv[1], Path(sys.argv[2])))
