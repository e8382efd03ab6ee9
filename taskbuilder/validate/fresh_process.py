"""Work in fresh processes, each a new interpreter with a hash seed of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

from taskbuilder.jobs import worker_processes
from taskbuilder.validate.env_cache import EnvCache, EnvSource, at_work

Give = Callable[[Callable[[EnvCache, Any], Any], EnvSource, Any], Callable[[], list[Any]]]
"""Gives work to fresh processes; the returned function waits for the results."""


@contextmanager
def fresh_processes(
    count: int, *, limit_s: float | None = None, beat: Callable[[], None] = lambda: None
) -> Iterator[Give]:
    """Run the same work in several fresh processes in the background.

    The processes start to load their modules at once, before they get work. A process that is
    killed or stopped from outside is replaced.

    Args:
        count: Number of processes.
        limit_s: Time limit of the work.
        beat: Called repeatedly while waiting for results.

    Yields:
        A function that gives the same work to each process, once. It takes a function of a module,
        which is called with the process's cache and an item; the source of the task; and the
        picklable item. It returns a function that waits for the results, and raises
        DescriptionError if the description raised an error, or LostError if a process was lost.
    """
    with ExitStack() as stack:
        spreads = [
            stack.enter_context(
                worker_processes(
                    [{"PYTHONHASHSEED": str(number)}],
                    limit_s=limit_s,
                    beat=beat,
                    prepared=__name__,
                )
            )
            for number in range(1, count + 1)
        ]

        def give(
            function: Callable[[EnvCache, Any], Any], source: EnvSource, item: Any
        ) -> Callable[[], list[Any]]:
            begun = [spread(partial(at_work, function, source), [item]) for spread in spreads]
            return lambda: [result for results in begun for result in results]

        yield give
