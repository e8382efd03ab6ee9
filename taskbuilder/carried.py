"""Tasks as files that travel with what was made with them, such as a data set.

A task is code. What is carried is therefore data until somebody has said to trust its digest: the
digest covers every file, and only files that it covers are unpacked and imported.
"""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from taskbuilder.digests import digest, digest_of
from taskbuilder.errors import UsageError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.sources import files_to_carry, folders_of_models
from taskbuilder.task import Task, load_task

LARGEST = 64 << 20
"""Most bytes of the files of a task that are carried."""

_HIGHEST = 2
"""Levels above the folder of a task up to which the names of folders are recorded."""


@dataclass(frozen=True)
class CarriedTask:
    """The files of a task that do not belong to a package.

    Attributes:
        file: Name of the task file among them, such as ``mine.yaml`` or ``tasks/mine.yaml``.
        folders: Folders among them in which robots are looked up by name, and assets may lie.
        files: Contents by name.
    """

    file: str
    folders: tuple[str, ...]
    files: Mapping[str, bytes]

    @property
    def name(self) -> str:
        """The name of the task."""
        return Path(self.file).stem

    @property
    def digest(self) -> str:
        """SHA-256 of the names and contents of all files, in hexadecimal."""
        return digest_of_task(self.file, self.folders, digests_of(self.files))


Trust = bool | str
"""Whether to run tasks of somebody else: none, all, or the one of this SHA-256."""


class UntrustedTaskError(UsageError):
    """A task is somebody else's, and nobody has said to trust it.

    Attributes:
        carried: The task.
    """

    def __init__(self, message: str, carried: CarriedTask) -> None:
        super().__init__(message)
        self.carried = carried


def is_trusted(carried: CarriedTask, trust: Trust) -> bool:
    """Whether somebody has said to trust a task."""
    return trust is True or bool(trust and trust == carried.digest)


def digests_of(files: Mapping[str, bytes]) -> dict[str, str]:
    """SHA-256 of each file by name."""
    return {name: digest(content) for name, content in files.items()}


def digest_of_task(file: str, folders: Sequence[str], digests: Mapping[str, str]) -> str:
    """The digest by which a carried task is trusted.

    Args:
        file: Name of the task file.
        folders: As `CarriedTask` has them.
        digests: SHA-256 of each file by name.
    """
    return digest_of({"file": file, "folders": list(folders), "files": dict(digests)})


def carry(task: Task, *, packaged: bool = False) -> CarriedTask | None:
    """The files of a task to carry; None if the task belongs to a package.

    Args:
        task: The task.
        packaged: Whether a task that belongs to a package is carried, too.

    Raises:
        UsageError: Its files are too large.
    """
    paths = sorted(files_to_carry(task, packaged=packaged))
    if not paths:
        return None
    if sum(path.stat().st_size for path in paths) > LARGEST:
        raise UsageError(
            f"the files of {task.name} have more than {LARGEST >> 20} MiB, too many to be "
            "recorded; use smaller meshes"
        )
    bases = _bases(task, paths)
    folders = [folder for folder in task.file.catalogue.folders if _contains(folder, paths)]
    return CarriedTask(
        _name(task.file.entry.file, bases),
        tuple(_name(folder, bases) for folder in folders),
        {_name(path, bases): path.read_bytes() for path in paths},
    )


def _bases(task: Task, paths: Sequence[Path]) -> Mapping[Path, str]:
    """Folders that names are relative to, with what the names then begin with.

    References between files lead up and down folders, so that files keep their places relative to
    each other. Only where they lie far apart does each folder stand on its own, because names would
    tell how the folders of this machine are called.
    """
    root = task.file.entry.root
    base = Path(os.path.commonpath([root, *(path.parent for path in paths)]))
    if len(root.relative_to(base).parts) <= _HIGHEST:
        return {base: ""}
    models = [folder for _, folder, _ in folders_of_models(task)]
    roots = [root, *task.file.catalogue.folders, *models]
    outermost = [one for one in roots if not any(one != o and one.is_relative_to(o) for o in roots)]
    return {one: f"{number}/" for number, one in enumerate(dict.fromkeys(outermost))}


def _contains(folder: Path, paths: Iterable[Path]) -> bool:
    return any(path.is_relative_to(folder) for path in paths)


def _name(path: Path, bases: Mapping[Path, str]) -> str:
    base, prefix = next((b, p) for b, p in bases.items() if path == b or path.is_relative_to(b))
    return (Path(prefix) / path.relative_to(base)).as_posix()


def load_carried(carried: CarriedTask) -> Task:
    """Load a carried task, which runs its Python file; call it only for one that is trusted.

    The files are unpacked to a temporary folder, which is removed when this process ends. A task
    may import Python files of its folder, which is therefore the last place where modules are
    looked for. Robots that are not among the files are looked up in the installed packages.

    Raises:
        FileError: The files of the task have errors.
        UnknownNameError: A robot of the task is not installed.
    """
    folder = _unpacked(tuple(carried.files.items()))
    catalogue = Catalogue(tuple((folder / name).resolve() for name in carried.folders))
    file = folder / carried.file
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))
    return load_task(file, catalogue=catalogue)


@cache
def _unpacked(files: tuple[tuple[str, bytes], ...]) -> Path:
    """The temporary folder of some files, which is there until this process ends."""
    folder = Path(tempfile.mkdtemp(prefix="taskbuilder-")).resolve()
    atexit.register(_remove, folder, os.getpid())
    for name, content in files:
        place = folder / name
        if not place.resolve().is_relative_to(folder):
            raise UsageError(f"{name!r} leads out of the folder of the task")
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
    return folder


def _remove(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # and not in a process that was forked from it
        shutil.rmtree(folder, ignore_errors=True)
