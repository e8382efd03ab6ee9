"""What Bullet prints: caught at the level of file descriptors, and told in sentences.

Bullet writes to the process's standard output and error from C, past `sys.stdout`, so only
redirecting the descriptors 1 and 2 keeps a command's output clean.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import IO, Any

_STDOUT, _STDERR = 1, 2
_MOST_BYTES = 2**20
# Two threads that redirected the same descriptors would restore each other's.
_lock = threading.RLock()

_RECORD = re.compile(r"b3(?:Warning|Error)\[[^\]\n]*\]:\n?")
_UNLABELLED_WARNING = re.compile(r"warning|cannot find|convex hull|unsupported", re.IGNORECASE)
_PLACE = re.compile(r"^\S*?[^/\s]+:\d+: ")
_LONGEST = 200
_WORDINGS = {
    "No inertial data for link": "link {} has no <inertial>; Bullet takes a mass of 1 kg",
    "Could not parse visual element for Link": "a <visual> of link {} was not understood",
    "Could not parse collision element for Link": "a <collision> of link {} was not understood",
    "Could not parse inertial element for Link": "the <inertial> of link {} was not understood",
}


@dataclass
class Chatter:
    """What was printed during a `captured` block.

    Attributes:
        text: Empty until the block has ended.
    """

    text: str = ""


@contextmanager
def captured() -> Iterator[Chatter]:
    """Keeps what is written to file descriptors 1 and 2 during the block.

    Blocks may be nested: text goes to the innermost. The descriptors belong to the process, so
    what other threads print meanwhile is caught as well, and a second thread that enters a block
    waits for the first to leave its own. Python's own `print` is caught only where `sys.stdout`
    writes to a descriptor, which it does not under pytest or in a notebook.
    """
    chatter = Chatter()
    with _lock, tempfile.TemporaryFile() as file:
        # What was printed before the block, and is still in a buffer, belongs before it.
        _flush()
        saved = [(descriptor, _duplicate(descriptor)) for descriptor in (_STDOUT, _STDERR)]
        try:
            for descriptor, _ in saved:
                os.dup2(file.fileno(), descriptor)
            yield chatter
        finally:
            try:
                _flush()
            finally:  # Ctrl-C may come right here
                for descriptor, copy in saved:
                    _restore(descriptor, copy)
            chatter.text = _read(file)


def import_pybullet() -> Any:
    """The module pybullet, imported without the line that it prints about its build."""
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    with captured():
        return importlib.import_module("pybullet")


def warnings(text: str) -> tuple[str, ...]:
    """The warnings in what Bullet printed, one sentence each, without repetitions.

    Args:
        text: As in `Chatter.text`.
    """
    unlabelled, *records = _RECORD.split(text)
    sentences = [_without_place(line) for line in _warning_lines(unlabelled)]
    for record in records:
        first, *others = record.strip().splitlines() or [""]
        # Bullet names the part in a record of its own, after the one that says what is wrong.
        if sentences and first and " " not in first:
            sentences[-1] = _about(sentences[-1], first)
        else:
            sentences.append(_without_place(first))
        sentences += [_without_place(line) for line in _warning_lines("\n".join(others))]
    return tuple(dict.fromkeys(filter(None, sentences)))


def _warning_lines(text: str) -> list[str]:
    return [line for line in text.splitlines() if _UNLABELLED_WARNING.search(line)]


def _without_place(line: str) -> str:
    """A line without the place in Bullet's or the asset's source that it begins with."""
    return _PLACE.sub("", line.strip())[:_LONGEST].rstrip(" :.")


def _about(sentence: str, name: str) -> str:
    """What a sentence says, of a part of the asset."""
    name = name[:_LONGEST]
    for beginning, wording in _WORDINGS.items():
        if sentence.startswith(beginning):
            return wording.format(name)
    return f"{sentence}: {name}"


def _duplicate(descriptor: int) -> int | None:
    """A copy of a descriptor; None if it is closed, as a daemon's are."""
    try:
        return os.dup(descriptor)
    except OSError:
        return None


def _restore(descriptor: int, copy: int | None) -> None:
    if copy is None:
        os.close(descriptor)
        return
    os.dup2(copy, descriptor)
    os.close(copy)


def _read(file: IO[bytes]) -> str:
    file.seek(0)
    return file.read(_MOST_BYTES).decode(errors="replace")


def _flush() -> None:
    """Empties the buffers of Python and of the C library into the descriptors."""
    for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
        # None without a console; ValueError once it is closed; a replacement may lack flush.
        with suppress(AttributeError, OSError, ValueError):
            stream.flush()  # type: ignore[union-attr]
    with suppress(AttributeError, OSError, TypeError):  # no such library outside POSIX
        ctypes.CDLL(None).fflush(None)
