"""A worker as its owner sees it: started, told to work, waited for, and asked why it died."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from typing import IO

_MAIN = "from taskbuilder.env.worker import main; main()"

_FAREWELL_S = 0.2  # for a worker that hangs to say where
_LONGEST = 20_000  # bytes of last words

_THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")


@dataclass(frozen=True)
class Fault:
    """How a worker was lost.

    Attributes:
        cause: What happened, after "worker 1 (environments 4 to 7)".
        words: What it said last: a traceback, or "".
    """

    cause: str
    words: str


class WorkerProcess:
    """One worker: a process, and the owner's ends of what connects to it.

    Attributes:
        number: Counts from 0.
        rows: The environments that it runs.
        losses: How many times in a row it was lost.
        busy: It owes an answer.
    """

    def __init__(self, number: int, rows: range) -> None:
        self.number = number
        self.rows = rows
        self.losses = 0
        self.busy = False
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: socket.socket | None = None
        self._lifeline = -1
        self._words: IO[bytes] | None = None

    @property
    def pid(self) -> int:
        """The process, or -1."""
        return self._process.pid if self._process else -1

    def start(self, orders: bytes, memory: int) -> None:
        """Start a process; it answers when its environments are built.

        Args:
            orders: What it is to run, for `WorkerConfig.read`.
            memory: Descriptor of the board's memory.
        """
        self.end()
        self._words = tempfile.TemporaryFile()  # noqa: SIM115  # closed by end
        self._connection, far = socket.socketpair()
        near, self._lifeline = os.pipe()
        with far, tempfile.TemporaryFile() as told:  # unlike a pipe, a file is never full
            told.write(orders)
            told.seek(0)
            passed = (far.fileno(), near, memory)
            numbers = (*passed, self.rows.start, self.rows.stop)
            try:
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-c", _MAIN, *map(str, numbers)],
                    stdin=told,
                    stdout=subprocess.DEVNULL,
                    stderr=self._words,
                    pass_fds=passed,
                    env=_environment(),
                    process_group=0,  # Ctrl-C in a terminal is for the owner
                )
            finally:
                os.close(near)
        self.busy = True

    def go(self) -> None:
        """Let it work; one that is lost is found out by `wait`."""
        self.busy = True
        if self._connection:
            with suppress(OSError):
                self._connection.sendall(b"!")

    def wait(self, limit_s: float) -> Fault | None:
        """Wait for its answer; if none comes, end it and say why."""
        if self._connection is None:
            return Fault("is not running", "")
        self._connection.settimeout(limit_s)
        try:
            answer = self._connection.recv(1)
        except TimeoutError:
            return self._autopsy(f"did not answer within {limit_s:g} s")
        except OSError:
            answer = b""
        if not answer:
            return self._autopsy("")
        self.busy = False
        return None

    def end(self) -> None:
        """Kill the process, if there is one, and close what connects to it."""
        if self._process:
            self._process.kill()
            self._process.wait()
            self._process = None
        if self._connection:
            self._connection.close()
            self._connection = None
        if self._lifeline >= 0:
            os.close(self._lifeline)
            self._lifeline = -1
        if self._words:
            self._words.close()
            self._words = None
        self.busy = False

    def _autopsy(self, cause: str) -> Fault:
        """End it and find out what happened.

        Args:
            cause: What is known; "" for a process that ended by itself.
        """
        words = ""
        if self._process and self._words:
            if cause:
                self._process.send_signal(signal.SIGABRT)  # makes it write where it hangs
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_FAREWELL_S)
            words = _tail(self._words)
            cause = cause or _end_of(self._process.poll(), words)
        self.end()
        return Fault(cause, words)


def _environment() -> dict[str, str]:
    """A worker's environment: this process's, its import path, and one thread a library."""
    paths = [path or os.getcwd() for path in sys.path]  # noqa: PTH109  # as text
    threads = {f"{library}_NUM_THREADS": "1" for library in _THREADS}
    return {**os.environ, **threads, "PYTHONPATH": os.pathsep.join(paths)}


def _tail(file: IO[bytes]) -> str:
    end = file.seek(0, os.SEEK_END)
    file.seek(max(0, end - _LONGEST))
    return file.read().decode(errors="replace").strip()


def _end_of(status: int | None, words: str) -> str:
    """How a process ended, in words."""
    if status is None:
        return "closed its connection"
    if status < 0:
        return f"was killed by {signal.Signals(-status).name}"
    said = words.splitlines()
    return f"failed: {said[-1]}" if said else f"ended with status {status}"
