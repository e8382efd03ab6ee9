"""Keeping what a description prints while it is imported out of what a command prints."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Iterator

_STDOUT, _STDERR = 1, 2


@contextlib.contextmanager
def printing_aside() -> Iterator[None]:
    """What is printed meanwhile goes to standard error, from C too, as on importing pybullet."""
    with contextlib.redirect_stdout(sys.stderr), contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # a descriptor is closed, as in a daemon
            _flush_c()
            copy = os.dup(_STDOUT)
            stack.callback(os.close, copy)
            stack.callback(os.dup2, copy, _STDOUT)
            stack.callback(_flush_c)
            os.dup2(_STDERR, _STDOUT)
        yield


def _flush_c() -> None:
    with contextlib.suppress(AttributeError, OSError, TypeError):  # no such library outside POSIX
        ctypes.CDLL(None).fflush(None)
