"""The folders of training runs: which may hold a new run, and locking them."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import claim
from taskbuilder.learn.demonstrations import DEMONSTRATIONS_FILE
from taskbuilder.learn.logger import BOARD, TABLES
from taskbuilder.learn.run_setup import RunSetup
from taskbuilder.policies.runs import RUN_FILE
from taskbuilder.policies.zoo import CHECKPOINTS

INIT_FILE = "init.npz"
"""File of a run that has the policy from which it started."""

_BEFORE_CHECKPOINTS: tuple[str, ...] = (DEMONSTRATIONS_FILE, INIT_FILE, BOARD)
_BEFORE_CHECKPOINTS += tuple(f"{table}.csv" for table in TABLES)
"""What a run has written before its first checkpoint, and leaves if it is then refused."""


def default_folder(run: RunSetup) -> Path:
    """The default folder of a run."""
    return Path("runs") / f"{run.task.name}-{run.plan.track}-{run.plan.seed}"


def check_new(folder: Path) -> None:
    """Check that a folder has no run yet, and nothing else that would then lie beside it.

    Raises:
        UsageError: It has.
    """
    name = display_path(folder)
    if (folder / RUN_FILE).exists():
        again = shlex.quote(name)
        raise UsageError(f"{name} is a training run already; --resume {again}, or another --out")
    with suppress(FileNotFoundError, NotADirectoryError):  # the latter is told when it is made
        names = sorted(file.name for file in folder.iterdir())
        strange = [each for each in names if not each.startswith((".", *_BEFORE_CHECKPOINTS))]
        if strange:
            raise UsageError(
                f"{name} holds other files ({', '.join(strange[:3])}); name a new or empty folder"
            )


@contextmanager
def locked(folder: Path, *, new: bool) -> Iterator[None]:
    """Lock a folder against training by other processes.

    A new run that is refused before its first checkpoint leaves the folder to the next one.

    Raises:
        UsageError: The folder is locked, or a new run would replace an existing one.
    """
    if new:
        check_new(folder)
        folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".lock").open("w") as file:
        if not claim(file):
            raise UsageError(f"{display_path(folder)} is being trained in already")
        try:
            yield
        except UsageError:
            if new and not (folder / CHECKPOINTS).exists():
                (folder / RUN_FILE).unlink(missing_ok=True)
            raise
