"""Files that are there whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import secrets
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any


def cache_folder(name: str) -> Path:
    """A folder of ours in the user's cache folder, which need not exist.

    It is in ``$XDG_CACHE_HOME``, or in ``~/.cache``.
    """
    configured = os.environ.get("XDG_CACHE_HOME", "")
    # The specification has relative paths ignored.
    if Path(configured).is_absolute():
        base = Path(configured)
    else:
        base = Path(os.path.expanduser("~")) / ".cache"  # noqa: PTH111 - Path.home() may raise
    return base / "taskbuilder" / name


def write_whole(path: Path, content: bytes, *, sync: bool = False) -> None:
    """Write a file aside and rename it, so that it is there whole or not at all.

    Args:
        path: Where; what was there is replaced.
        content: All of it.
        sync: Wait until the disk has it, so that it outlives a loss of power too.

    Raises:
        OSError: It cannot be written.
    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder; name a file", str(path))
    with kept_aside(path, f".{path.name}") as aside, aside.open("wb") as file:
        file.write(content)
        if sync:
            file.flush()
            os.fsync(file.fileno())
    if sync:
        _sync_folder(path.parent)


@contextmanager
def kept_aside(path: Path, stem: str, suffix: str = "") -> Iterator[Path]:
    """A file to write aside, which takes a path's place once the block has ended well.

    What processes left aside that were killed while they wrote the same is swept up first.

    Args:
        path: The place.
        stem: How its name aside begins.
        suffix: How it ends.

    Raises:
        OSError: It cannot be written.
    """
    _sweep(path.parent, re.compile(rf"{re.escape(stem)}\.[0-9a-f]{{8}}{re.escape(suffix)}"))
    # Named before it is there, so that nothing can come between making it and minding it.
    aside = path.with_name(f"{stem}.{secrets.token_hex(4)}{suffix}")
    try:
        with aside.open("xb") as file:
            claim(file)
            yield aside
            aside.chmod(0o644)
            if os.name == "posix":  # elsewhere, an open file cannot be renamed
                aside.replace(path)
        if os.name != "posix":
            aside.replace(path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def _sweep(folder: Path, name: re.Pattern[str]) -> None:
    """Remove files of a name that nobody writes any more: their locks went with their owners."""
    with suppress(OSError):  # what cannot be swept is no reason not to write
        for left in [file for file in folder.iterdir() if name.fullmatch(file.name)]:
            with left.open("rb") as file:
                if claim(file):
                    left.unlink(missing_ok=True)


def claim(file: IO[Any] | int) -> bool:
    """Lock a file for as long as it is open; False if another process has locked it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            number = file if isinstance(file, int) else file.fileno()
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _sync_folder(folder: Path) -> None:
    """Have the disk know of a rename within a folder, where folders can be opened."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
