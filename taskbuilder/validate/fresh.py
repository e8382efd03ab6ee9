"""Work in fresh processes: interpreters that have done nothing before, each with hashes its own."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from tempfile import TemporaryFile
from typing import IO, Any

from taskbuilder.processes import interpreter
from taskbuilder.validate.studio import DescriptionError, Source, Studio, at_work

Give = Callable[[Callable[[Studio, Any], Any], Source, Any], Callable[[], list[Any]]]
"""Gives fresh processes their work; what it returns waits for the results."""


@contextmanager
def fresh_processes(count: int) -> Iterator[Give]:
    """Have the same work done in several fresh processes, while other things are done here.

    They begin to load what they need at once, before there is any work for them.

    Args:
        count: How many processes.

    Yields:
        Gives each of them the same work, once: a function of a module, which is called with the
        process's studio and an item; where the task is found; and the item, which is picklable.
        What this returns waits for the results. It raises DescriptionError if the description
        raised an error, and RuntimeError if a process was lost.
    """
    with ExitStack() as stack:
        said = [stack.enter_context(TemporaryFile()) for _ in range(count)]
        begun = [_begin(number, file) for number, file in enumerate(said, start=1)]
        children = [stack.enter_context(child) for child in begun]

        def give(
            function: Callable[[Studio, Any], Any], source: Source, item: Any
        ) -> Callable[[], list[Any]]:
            # JSON has no functions and no arrays.
            work = pickle.dumps((function, source, item))  # for our own child, over a pipe
            for child in children:
                _give(child, work)
            return lambda: [
                _result(child, file) for child, file in zip(children, said, strict=True)
            ]

        try:
            yield give
        finally:
            for child in children:
                child.kill()


def _begin(number: int, said: IO[bytes]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        interpreter("from taskbuilder.validate.fresh import main; main()"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=said,
        env={**os.environ, "PYTHONHASHSEED": str(number)},
        start_new_session=True,  # Ctrl-C is the owner's, who ends them
    )


def _give(child: subprocess.Popen[bytes], work: bytes) -> None:
    if child.stdin is None:
        raise ValueError("the process takes no work")
    with suppress(BrokenPipeError):  # it was lost; what it said is read with its result
        child.stdin.write(work)
        child.stdin.close()


def _result(child: subprocess.Popen[bytes], said: IO[bytes]) -> Any:
    if child.stdout is None:
        raise ValueError("the process gives nothing back")
    told = child.stdout.read()
    if child.wait() or not told:
        said.seek(0)
        words = said.read().decode(errors="replace").strip()
        raise RuntimeError(f"a process was lost with status {child.returncode}\n{words}".rstrip())
    ok, value = pickle.loads(told)  # noqa: S301  # our own process wrote it
    if not ok:
        raise value
    return value


def main() -> None:
    """Do the work that is written to standard input, in a fresh process.

    Nothing but its result is written to standard output.
    """
    result = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # of what is printed, from C too
    function, source, item = pickle.load(sys.stdin.buffer)  # noqa: S301  # our owner wrote it
    try:
        told = (True, at_work(function, source, item))
    except DescriptionError as error:
        told = (False, error)
    with result:
        pickle.dump(told, result)
