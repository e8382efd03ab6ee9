"""What others print, kept out of what a command prints: libraries, the physics engine, tasks.

Code in C writes to the descriptors 1 and 2 of the process, past `sys.stdout`, so descriptors are
what is redirected.
"""

from __future__ import annotations

import ctypes
import io
import os
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from dataclasses import dataclass

HINTS = "taskbuilder.hints"
"""Name of the logger for hints to people, which child processes leave to their owner."""

_STDOUT, _STDERR = 1, 2
_MOST_BYTES = 2**20
# Two threads that redirected the same descriptors would restore each other's.
_lock = threading.RLock()


@dataclass
class Printed:
    """What was printed during a `captured` block.

    Attributes:
        text: Empty until the block has ended.
    """

    text: str = ""


@contextmanager
def captured() -> Iterator[Printed]:
    """Keeps what is written to file descriptors 1 and 2 during the block.

    Blocks may be nested: text goes to the innermost. The descriptors belong to the process, so
    what other threads print meanwhile is caught as well, and a second thread that enters a block
    waits for the first to leave its own. Python's own `print` is caught only where `sys.stdout`
    writes to a descriptor, which it does not under pytest or in a notebook.
    """
    printed = Printed()
    with _lock, tempfile.TemporaryFile() as file:
        try:
            with _redirected(file.fileno(), _STDOUT, _STDERR):
                yield printed
        finally:
            file.seek(0)
            printed.text = file.read(_MOST_BYTES).decode(errors="replace")


@contextmanager
def printing_to_stderr() -> Iterator[None]:
    """What is printed meanwhile goes to standard error, from C too."""
    with _redirected(_STDERR, _STDOUT), redirect_stdout(sys.stderr):
        yield


@contextmanager
def without_remarks() -> Iterator[None]:
    """Drops what Python code prints and warns of meanwhile; its errors are raised."""
    with redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def drop(descriptor: int) -> None:
    """From now on, what is written to a descriptor goes nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, descriptor)
    if nowhere != descriptor:
        os.close(nowhere)


@contextmanager
def _redirected(target: int, *descriptors: int) -> Iterator[None]:
    # What was printed before the block, and is still in a buffer, belongs before it.
    _flush()
    saved = [(descriptor, _duplicate(descriptor)) for descriptor in descriptors]
    try:
        for descriptor in descriptors:
            with suppress(OSError):  # the target is closed, as a daemon's standard error is
                os.dup2(target, descriptor)
        yield
    finally:
        try:
            _flush()
        finally:  # Ctrl-C may come right here
            for descriptor, copy in saved:
                _restore(descriptor, copy)


def _duplicate(descriptor: int) -> int | None:
    """A copy of a descriptor; None if it is closed, as a daemon's are."""
    try:
        return os.dup(descriptor)
    except OSError:
        return None


def _restore(descriptor: int, copy: int | None) -> None:
    if copy is None:
        with suppress(OSError):  # it stayed closed
            os.close(descriptor)
        return
    os.dup2(copy, descriptor)
    os.close(copy)


def _flush() -> None:
    """Empties the buffers of Python and of the C library into the descriptors."""
    for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
        # None without a console; ValueError once it is closed; a replacement may lack flush.
        with suppress(AttributeError, OSError, ValueError):
            stream.flush()  # type: ignore[union-attr]
    with suppress(AttributeError, OSError, TypeError):  # no such library outside POSIX
        ctypes.CDLL(None).fflush(None)
