"""Ctrl-C ends a command, wherever it strikes, and with our exit status."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_AGAIN = 0.02
"""Seconds until an interrupt is delivered again; by then what was being freed is freed."""


@contextmanager
def interrupts_heeded() -> Iterator[None]:
    """Deliver interrupts again that strike within a finalizer, such as that of a closed archive.

    Python can raise nothing out of a finalizer: it would report the KeyboardInterrupt, and go on.
    """
    before = sys.unraisablehook

    def report(unraisable: sys.UnraisableHookArgs) -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            again = threading.Timer(_AGAIN, _interrupt, (threading.get_ident(),))
            again.daemon = True
            again.start()
        else:
            before(unraisable)

    sys.unraisablehook = report
    try:
        yield
    finally:
        sys.unraisablehook = before


def _interrupt(thread: int) -> None:
    """Interrupt the thread itself, where one can, so that it wakes if it waits for something."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(thread, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


def forget_interrupt() -> None:
    """Let the process end with our status and not by a signal.

    CPython marks the process as interrupted whenever Ctrl-C strikes within `exec` or `eval` of a
    string, as dataclasses and namedtuples do while modules are imported, and forgets it only when
    the next string is executed; a handled interrupt would still kill the process as it exits.
    """
    exec("")  # noqa: S102  # our own string, and empty: only that one is executed matters
