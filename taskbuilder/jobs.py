"""Spread work over processes: the same results in the same order, however many there are."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any, TypeVar

from taskbuilder.processes import safe_path

Item = TypeVar("Item")
Result = TypeVar("Result")

Map = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""Applies a function to items and yields the results in order, each as soon as it can."""


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def workers(count: int) -> Iterator[Map]:
    """A `map` over so many processes, or within this one for a count of 1.

    Functions and items must be picklable: functions of a module, not of a class or another
    function. Results come in the order of the items. Left by an exception, Ctrl-C included, the
    processes are stopped at once.
    """
    if count <= 1:
        yield map
        return
    # Spawned, not forked: a renderer or torch may have threads by now.
    with safe_path():
        pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_begin)
        try:
            yield pool.map
        except BaseException:
            for process in list(getattr(pool, "_processes", {}).values()):
                process.terminate()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
        pool.shutdown(wait=True)


def _begin() -> None:
    """Leave Ctrl-C and standard output to the owner, and take one core, not all of them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.stdout = sys.stderr  # what a task prints is no part of a result
    for kind in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{kind}_NUM_THREADS"] = "1"
