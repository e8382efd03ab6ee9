"""Spread work over processes: the same results in the same order, however many there are.

A process that somebody kills or stops is replaced, and its piece of work is done again. One that
its own work ends, crashes or holds up is asked where, and the work is given up.
"""

from __future__ import annotations

import logging
import os
import pickle
import select
import socket
import struct
import sys
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from typing import Any, TypeVar

from taskbuilder.errors import TaskbuilderError
from taskbuilder.processes import ChildProcess, Fault, become_child, tell_exits

Item = TypeVar("Item")
Result = TypeVar("Result")

Map = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""Applies a function to items and yields the results in order, each as soon as it can."""

TRIES = 2
"""How many times a piece of work is begun whose processes are killed or stopped from outside."""

STOPPED_S = 2.0
"""How long a process may stand still before it is taken for lost."""

_LOOK_S = 0.5  # between looks at processes that say nothing
_TAKES_S = 20.0  # how long a process that waits for work may take to take it

_HEADER = struct.Struct("!Q")

DONE, RAISED, SAID = "done", "raised", "said"
"""Kinds of what a process says: what came of its work, or what it says before that."""

_log = logging.getLogger(__name__)


class LostError(TaskbuilderError):
    """A piece of work took the process that did it with it, or did not come back.

    Attributes:
        fault: How the process was lost.
        item: What the work was about.
    """

    def __init__(self, fault: Fault, item: Any = None) -> None:
        super().__init__(fault, item)
        self.fault = fault
        self.item = item

    def __str__(self) -> str:
        again = f" ({TRIES} in a row)" if self.fault.outside else ""
        return f"a process {self.fault.cause}{again}\n{self.fault.words}".rstrip()


@contextmanager
def workers(
    count: int,
    *,
    limit_s: float | None = None,
    beat: Callable[[], None] = lambda: None,
    prepared: str = "",
) -> Iterator[Map]:
    """A `map` over so many processes, or within this one for a count of 1.

    Functions and items must be picklable: functions of a module, not of a class or another
    function. Results come in the order of the items. Left by an exception, Ctrl-C included, the
    processes are ended at once. A result that a process was lost for raises `LostError`.

    Args:
        count: How many processes.
        limit_s: How long a piece of work may take, or None for as long as it takes.
        beat: Called again and again while results are waited for.
        prepared: A module that the processes import before there is work for them.
    """
    if count <= 1:
        yield map
        return
    with worker_processes([{}] * count, limit_s=limit_s, beat=beat, prepared=prepared) as spread:
        yield spread


@contextmanager
def worker_processes(
    environments: Sequence[Mapping[str, str]],
    *,
    limit_s: float | None = None,
    beat: Callable[[], None] = lambda: None,
    prepared: str = "",
) -> Iterator[Map]:
    """A `map` over processes, one for each of several environments; see `workers`."""
    with ExitStack() as stack:
        begun = [stack.enter_context(closing(Worker(e, prepared))) for e in environments]
        yield _Pool(begun, limit_s, beat).spread


# --- the owner's side


class Worker(ChildProcess):
    """A process that does one piece of work after the other.

    Args:
        environment: Variables besides those of this process.
        prepared: A module that it imports before there is work for it.

    Attributes:
        since: When it was last heard of, while it works; else None.
    """

    def __init__(self, environment: Mapping[str, str], prepared: str = "") -> None:
        super().__init__()
        self.since: float | None = None
        self._delayed_before_s = 0.0
        self._environment = environment
        self._prepared = prepared
        self._received = bytearray()
        self._still_since: float | None = None
        self.start()

    def start(self) -> None:
        """Start the process, in place of the one that there was."""
        self._received.clear()
        self.begin(_main(self._prepared), silent=False, environment=self._environment)

    def close(self) -> None:
        """End it."""
        self.end()

    def end(self) -> None:
        """End the child process."""
        super().end()
        self.since = self._still_since = None

    def give(self, work: bytes) -> None:
        """Give it a piece of work, of `packed`; one that is lost is found out by `hear`."""
        if self.connection is None:
            self.start()
        self._heard()
        self._still_since = None
        if self.connection is not None:
            self.connection.settimeout(_TAKES_S)
            try:
                _send(self.connection, work)
            except TimeoutError:  # it stands still, with half of the work
                self.end()
            except OSError:
                return

    def hear(self) -> list[tuple[str, Any]]:
        """What it has said by now, without waiting: kinds, and values.

        Raises:
            LostError: It is gone.
        """
        if self.connection is None:
            raise LostError(Fault("took no work", "", outside=True))
        self.connection.setblocking(False)
        try:
            received = self.connection.recv(1 << 20)
        except BlockingIOError:
            return []
        except OSError:
            received = b""
        if not received:
            raise LostError(self.autopsy())
        self._heard()
        self._received += received
        return list(self._messages())

    def _heard(self) -> None:
        self.since, self._delayed_before_s = time.monotonic(), self.delayed_s

    def check(self, limit_s: float | None) -> None:
        """Raise if it has said nothing for too long, or if it stands still.

        While it waits for a core of a busy machine, its time does not run.

        Raises:
            LostError: So it is; it has been ended.
        """
        now = time.monotonic()
        if not self.stopped:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = now
        elif now - self._still_since > STOPPED_S:
            raise LostError(self.autopsy("was stopped", outside=True))
        if limit_s is None or self.since is None or now - self.since <= limit_s:
            return
        if now - self.since - (self.delayed_s - self._delayed_before_s) > limit_s:
            if self._still_since is not None:
                raise LostError(self.autopsy("was stopped", outside=True))
            raise LostError(self.autopsy(f"did not come back within {limit_s:g} s"))

    def _messages(self) -> Iterator[tuple[str, Any]]:
        while len(self._received) >= _HEADER.size:
            (size,) = _HEADER.unpack_from(self._received)
            end = _HEADER.size + size
            if len(self._received) < end:
                return
            message = bytes(self._received[_HEADER.size : end])
            del self._received[:end]
            yield pickle.loads(message)  # noqa: S301  # our own child wrote it


def _main(prepared: str) -> str:
    imported = f"; import {prepared}" if prepared else ""
    return f"from taskbuilder.jobs import begin, serve; begin(){imported}; serve()"


def packed(function: Callable[[Any], Any], item: Any) -> bytes:
    """A piece of work as it is given to a process."""
    # JSON has no functions and no arrays; pickle is read back by our own child, over a socket.
    return pickle.dumps((function, item))


def wait_for(busy: Sequence[Worker], wait_s: float = _LOOK_S) -> list[Worker]:
    """Those of some workers that have something to say, once there are any, or after a while."""
    connections = {worker.connection: worker for worker in busy if worker.connection}
    ready, _, _ = select.select(list(connections), (), (), wait_s)
    gone = [worker for worker in busy if worker.connection is None]
    return [*gone, *(connections[connection] for connection in ready)]


class _Piece:
    """A piece of work, and what came of it."""

    def __init__(self, function: Callable[[Any], Any], item: Any) -> None:
        self.item = item
        self.work = packed(function, item)
        self.losses = 0
        self.answer: tuple[str, Any] | None = None

    def result(self) -> Any:
        kind, value = self.answer or (RAISED, RuntimeError("there is no answer"))
        if kind == RAISED:
            raise value
        return value


class _Pool:
    """Workers, and what they are to do."""

    def __init__(
        self, workers: Sequence[Worker], limit_s: float | None, beat: Callable[[], None]
    ) -> None:
        self.workers = workers
        self._limit_s = limit_s
        self._beat = beat
        self._waiting: deque[_Piece] = deque()
        self._doing: dict[Worker, _Piece] = {}

    def spread(self, function: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """Have work done; it is begun at once, and its results come in order."""
        pieces = deque(_Piece(function, item) for item in items)
        self._waiting.extend(pieces)
        self._attend(0.0)
        return self._results(pieces)

    def _results(self, pieces: deque[_Piece]) -> Iterator[Any]:
        try:
            while pieces:
                while pieces[0].answer is None:
                    self._attend(_LOOK_S)
                yield pieces.popleft().result()
        finally:  # who does not want the rest does not wait for it
            for piece in pieces:
                if piece in self._waiting:
                    self._waiting.remove(piece)

    def _attend(self, wait_s: float) -> None:
        """Take what workers have done, look after those that are lost, and hand out work."""
        self._hand_out()
        ready = wait_for(list(self._doing), wait_s)
        for worker, piece in list(self._doing.items()):
            try:
                for answer in worker.hear() if worker in ready else ():
                    piece.answer = answer
                if piece.answer is None:
                    worker.check(self._limit_s)
            except LostError as lost:
                self._lose(worker, piece, lost.fault)
            else:
                if piece.answer is not None:
                    self._free(worker)
        self._hand_out()
        self._beat()

    def _hand_out(self) -> None:
        for worker in self.workers:
            if self._waiting and worker not in self._doing:
                piece = self._waiting.popleft()
                self._doing[worker] = piece
                worker.give(piece.work)

    def _free(self, worker: Worker) -> None:
        del self._doing[worker]
        worker.since = None

    def _lose(self, worker: Worker, piece: _Piece, fault: Fault) -> None:
        """Have a piece done again, or give it up."""
        self._free(worker)
        piece.losses += 1
        if fault.outside and piece.losses < TRIES:
            tell_of_loss(fault)
            self._waiting.appendleft(piece)
        else:
            piece.answer = (RAISED, LostError(fault, piece.item))


def tell_of_loss(fault: Fault) -> None:
    """Say that a process was lost whose work is done again."""
    _log.warning("a process %s; its work is done again", fault.cause)


# --- the worker's side

_owner: socket.socket | None = None


def begin() -> None:
    """Become a child of the owner's."""
    global _owner
    connection, lifeline, words = map(int, sys.argv[1:])
    become_child(lifeline, os.fdopen(words, "wb", buffering=0))
    sys.stdout = sys.stderr  # what a task prints is no part of a result
    _owner = socket.socket(fileno=connection)


def serve() -> None:
    """Do the work that the owner gives, until it is gone."""
    leave = tell_exits()
    while _owner and (work := _taken(_owner)):
        _send(_owner, carry_out(work))
    leave(0)  # without waiting for threads or exit handlers of the task's


def say(value: Any) -> None:
    """Tell this process's owner something before its work is done."""
    if _owner is not None:
        _send(_owner, pickle.dumps((SAID, value)))


def carry_out(work: bytes) -> bytes:
    """Do a piece of work, of `packed`; its result or its error, pickled."""
    try:
        function, item = pickle.loads(work)  # noqa: S301  # our owner wrote it
        return pickle.dumps((DONE, function(item)))
    except BaseException as error:  # whatever it is, the owner is told
        return pickle.dumps((RAISED, _told(error)))


def _told(error: BaseException) -> Exception:
    """An error as the owner is to raise it, with what shows where it arose."""
    trace = "".join(traceback.format_exception(error)).rstrip()
    if not isinstance(error, Exception):  # it was to end this process, not the owner
        return LostError(Fault(f"was to end: {type(error).__name__}", trace))
    error.add_note(trace)
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301  # our own
    except Exception:  # not every error survives it
        return RuntimeError(trace)
    return error


def _taken(connection: socket.socket) -> bytes:
    """The next piece of work; b"" when there will be none."""
    header = _exactly(connection, _HEADER.size)
    return _exactly(connection, _HEADER.unpack(header)[0]) if header else b""


def _exactly(connection: socket.socket, size: int) -> bytes:
    found = bytearray()
    while len(found) < size:
        more = connection.recv(min(size - len(found), 1 << 20))
        if not more:
            return b""
        found += more
    return bytes(found)


def _send(connection: socket.socket, message: bytes) -> None:
    connection.sendall(_HEADER.pack(len(message)) + message)
