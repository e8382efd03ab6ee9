"""Noticing that files have changed, whichever way an editor writes them."""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path

from taskbuilder.digests import digest

_STEADY_S = 0.02  # a file that is written has been written when it stays the same for so long
_LONGEST_S = 1.0  # but no longer is waited for it

Stamp = tuple[int, int, int]
"""Number, time of change and size of a file."""


class Polled:
    """Files by the digests of their content, as they were when they were last looked at.

    Editors write files in place, or put another one in their place; both are noticed, and a file
    that was only touched is not taken for changed. A missing file is a file without content.
    """

    def __init__(self) -> None:
        self._stamps: dict[Path, Stamp | None] = {}
        self._digests: dict[Path, str] = {}

    def watch(self, files: Iterable[Path]) -> None:
        """Watch these files from now on, and no others; known ones are as they were last seen."""
        wanted = frozenset(files)
        for file in self._stamps.keys() - wanted:
            del self._stamps[file], self._digests[file]
        for file in wanted - self._stamps.keys():
            self._stamps[file], self._digests[file] = _stamp(file), _digest(file)

    @property
    def files(self) -> frozenset[Path]:
        """The files that are watched."""
        return frozenset(self._stamps)

    def changed(self) -> tuple[Path, ...]:
        """The files whose content is another than when they were last looked at, sorted.

        Where one has just been changed, this waits until it is written.
        """
        touched = [file for file, known in self._stamps.items() if _stamp(file) != known]
        if not touched:
            return ()
        _let_settle(touched)
        found = []
        for file in self._stamps:  # an editor writes more than one at once
            stamp = _stamp(file)
            if stamp == self._stamps[file]:
                continue
            now = _digest(file)
            if now != self._digests[file]:
                found.append(file)
            self._stamps[file], self._digests[file] = stamp, now
        return tuple(sorted(found))


def _let_settle(files: Iterable[Path]) -> None:
    """Wait until files are there and stay the same."""
    listed = list(files)
    end = time.monotonic() + _LONGEST_S
    before: list[Stamp | None] = []
    gone_until = time.monotonic() + 5 * _STEADY_S  # in which a file may be put in its place
    while time.monotonic() < end:
        now = [_stamp(file) for file in listed]
        if now == before and (None not in now or time.monotonic() > gone_until):
            return
        before = now
        time.sleep(_STEADY_S)


def _stamp(file: Path) -> Stamp | None:
    try:
        status = file.stat()
    except (OSError, ValueError):
        return None
    return status.st_ino, status.st_mtime_ns, status.st_size


def _digest(file: Path) -> str:
    try:
        return digest(file.read_bytes())
    except (OSError, ValueError):
        return ""
