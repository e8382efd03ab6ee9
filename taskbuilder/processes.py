"""Child processes: started, watched, and asked why they died.

A child is a fresh interpreter. It ends when its owner does, leaves Ctrl-C to it, and keeps its last
words, such as the line at which it hung or crashed, in a file that the owner reads.
"""

from __future__ import annotations

import faulthandler
import logging
import os
import signal
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, BinaryIO, NoReturn

from taskbuilder.errors import TaskbuilderError
from taskbuilder.interpreters import interpreter
from taskbuilder.quiet import HINTS

_FAREWELL_S = 0.2  # for a child that hangs to say where
_LONGEST = 20_000  # bytes of last words

_THREADS = ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")

_CRASHES = ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL")

CHILDREN = os.name == "posix"
"""Whether child processes can be started: they inherit descriptors, which takes a POSIX system."""


@dataclass(frozen=True)
class Fault:
    """How a child was lost.

    Attributes:
        cause: What happened, after "worker 1 (environments 4 to 7)".
        words: What it said last: a traceback, or "".
        outside: Somebody else killed or stopped it, as far as can be told; doing its work again
            may go well.
    """

    cause: str
    words: str
    outside: bool = False


class ChildProcess:
    """A child, and the owner's ends of what connects to it.

    Attributes:
        connection: To the child, while there is one.
    """

    def __init__(self) -> None:
        self.connection: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._lifeline = -1
        self._words: IO[bytes] | None = None

    @property
    def pid(self) -> int:
        """The process, or -1."""
        return self._process.pid if self._process else -1

    def begin(
        self,
        code: str,
        orders: bytes = b"",
        *numbers: int,
        passed: Sequence[int] = (),
        silent: bool = True,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """Start a process, in place of the one that there was.

        Args:
            code: The Python that it runs. Its arguments are the descriptors of its end of the
                connection, of its lifeline, of the file for its last words, and those that are
                passed; then the numbers.
            orders: What it reads from standard input.
            numbers: Further arguments.
            passed: Descriptors that it inherits.
            silent: What it prints is kept with its last words; else it goes to standard error.
            environment: Variables besides those of this process.

        Raises:
            TaskbuilderError: This system has no child processes of this kind.
        """
        if not CHILDREN:
            raise TaskbuilderError(
                "child processes take a POSIX system such as Linux or macOS; "
                "do without workers, and play in one process"
            )
        self.end()
        self._words = tempfile.TemporaryFile()  # noqa: SIM115  # closed by end
        self.connection, far = socket.socketpair()
        near, self._lifeline = os.pipe()
        with far, tempfile.TemporaryFile() as told:  # unlike a pipe, a file is never full
            told.write(orders)
            told.seek(0)
            given = (far.fileno(), near, self._words.fileno(), *passed)
            try:
                self._process = subprocess.Popen(
                    interpreter(code, *map(str, (*given, *numbers))),
                    stdin=told,
                    stdout=subprocess.DEVNULL if silent else _standard_error(),
                    stderr=self._words if silent else _standard_error(),
                    pass_fds=given,
                    env=environment_of_children() | dict(environment or {}),
                    process_group=0,  # Ctrl-C in a terminal is for the owner
                )
            finally:
                os.close(near)

    @property
    def stopped(self) -> bool:
        """It stands still, as after SIGSTOP; not known on every system."""
        if self._process is None or not hasattr(os, "waitid"):
            return False
        how = os.WSTOPPED | os.WNOHANG | os.WNOWAIT
        try:
            state = os.waitid(os.P_PID, self._process.pid, how)
        except ChildProcessError:
            return False
        return state is not None and state.si_code == os.CLD_STOPPED

    @property
    def delayed_s(self) -> float:
        """How long it has waited for a core, in seconds; 0 where the system does not tell."""
        return delayed_s(self.pid)

    def end(self) -> None:
        """Kill the process, if there is one, and close what connects to it."""
        if self._process:
            self._process.kill()
            self._process.wait()
            self._process = None
        if self.connection:
            self.connection.close()
            self.connection = None
        if self._lifeline >= 0:
            os.close(self._lifeline)
            self._lifeline = -1
        if self._words:
            self._words.close()
            self._words = None

    def autopsy(self, cause: str = "", *, outside: bool = False) -> Fault:
        """End it and find out what happened.

        Args:
            cause: What is known; "" for a process that ended by itself.
            outside: What is known was somebody else's doing.
        """
        words = ""
        if self._process and self._words:
            if cause and not outside:
                self._process.send_signal(signal.SIGABRT)  # makes it write where it hangs
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_FAREWELL_S)
            words = _tail(self._words)
            if not cause:
                status = self._process.poll()
                cause, outside = _end_of(status, words), _by_others(status)
        self.end()
        return Fault(cause, words, outside)


def cores() -> int:
    """The cores that this process may use; 1 where it can start no child processes."""
    if not CHILDREN:
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def delayed_s(pid: int) -> float:
    """How long a process has waited for a core, in seconds; 0 where the system does not tell."""
    try:
        _, nanoseconds, *_ = Path(f"/proc/{pid}/schedstat").read_text().split()
        return int(nanoseconds) / 1e9
    except (OSError, ValueError):
        return 0.0


def ends_within(process: subprocess.Popen[bytes], limit_s: float) -> bool:
    """Wait until a process ends, at most for a time; its waiting for a core does not count."""
    since = time.monotonic()
    while (left := limit_s + delayed_s(process.pid) - (time.monotonic() - since)) > 0:
        with suppress(subprocess.TimeoutExpired):
            process.wait(left)
            return True
    return False


def _standard_error() -> int:
    """A descriptor for what children print; standard error's, unless that is closed."""
    try:
        os.fstat(2)
    except OSError:
        return subprocess.DEVNULL
    return 2


def environment_of_children() -> dict[str, str]:
    """A child's environment: this process's, and one thread a library."""
    return {**os.environ, **{f"{library}_NUM_THREADS": "1" for library in _THREADS}}


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
    return f"failed: {said[-1]}" if "Traceback" in words else f"ended with status {status}"


def _by_others(status: int | None) -> bool:
    """Whether it takes another process to end one so, as far as can be told."""
    return status is not None and status < 0 and signal.Signals(-status).name not in _CRASHES


# --- in the child

_last_words: BinaryIO | None = None


def owned() -> bool:
    """Whether this process is a child that leaves Ctrl-C to its owner."""
    return _last_words is not None


def become_child(lifeline: int, last_words: BinaryIO) -> None:
    """Do as a child does: end with the owner, leave Ctrl-C to it, and leave last words."""
    import resource  # POSIX only, as child processes are

    global _last_words
    _last_words = last_words
    _die_with_owner(lifeline)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the owner decides
    logging.getLogger(HINTS).setLevel(logging.ERROR)  # the owner gives them, once
    faulthandler.enable(last_words)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def tell_exits() -> Callable[[int], NoReturn]:
    """Have whoever ends this process by `os._exit` leave last words.

    Returns:
        Ends it without a word.
    """
    leave = os._exit

    def tell(status: int) -> NoReturn:
        with suppress(OSError):
            faulthandler.dump_traceback(_last_words or 2, all_threads=False)
        leave(status)

    os._exit = tell
    return leave


def _die_with_owner(lifeline: int) -> None:
    """End this process when the other end of a pipe is closed, as it is when the owner dies.

    On Linux the kernel sees to it, even while this process is stopped or hangs in C code.
    """
    import fcntl  # POSIX only, as child processes are

    if hasattr(fcntl, "F_SETSIG"):
        fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
        fcntl.fcntl(lifeline, fcntl.F_SETSIG, signal.SIGKILL)
        flags = fcntl.fcntl(lifeline, fcntl.F_GETFL)
        fcntl.fcntl(lifeline, fcntl.F_SETFL, flags | os.O_ASYNC)
    else:
        threading.Thread(target=_wait_for_end, args=(lifeline,), daemon=True).start()


def _wait_for_end(lifeline: int) -> None:
    os.read(lifeline, 1)
    os._exit(1)
