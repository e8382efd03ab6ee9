"""Work in fresh processes: interpreters that have done nothing before, each with hashes its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

from taskbuilder.jobs import worker_processes
from taskbuilder.validate.studio import Source, Studio, at_work

Give = Callable[[Callable[[Studio, Any], Any], Source, Any], Callable[[], list[Any]]]
"""Gives fresh processes their work; what it returns waits for the results."""


@contextmanager
def fresh_processes(
    count: int, *, limit_s: float | None = None, beat: Callable[[], None] = lambda: None
) -> Iterator[Give]:
    """Have the same work done in several fresh processes, while other things are done here.

    They begin to load what they need at once, before there is any work for them. One that somebody
    kills or stops is replaced by another.

    Args:
        count: How many processes.
        limit_s: How long the work may take.
        beat: Called again and again while results are waited for.

    Yields:
        Gives each of them the same work, once: a function of a module, which is called with the
        process's studio and an item; where the task is found; and the item, which is picklable.
        What this returns waits for the results. It raises DescriptionError if the description
        raised an error, and LostError if a process was lost.
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
            function: Callable[[Studio, Any], Any], source: Source, item: Any
        ) -> Callable[[], list[Any]]:
            begun = [spread(partial(at_work, function, source), [item]) for spread in spreads]
            return lambda: [result for results in begun for result in results]

        yield give
