"""A worker as its owner sees it: started, told to work, waited for, and asked why it died."""

from __future__ import annotations

from contextlib import suppress

from taskbuilder.processes import ChildProcess, Fault

_MAIN = "from taskbuilder.env.worker import main; main()"


class WorkerProcess(ChildProcess):
    """One worker.

    Attributes:
        number: Counts from 0.
        rows: The environments that it runs.
        losses: How many times in a row it was lost.
        busy: It owes an answer.
    """

    def __init__(self, number: int, rows: range) -> None:
        super().__init__()
        self.number = number
        self.rows = rows
        self.losses = 0
        self.busy = False

    def start(self, orders: bytes, memory: int) -> None:
        """Start a process; it answers when its environments are built.

        Args:
            orders: What it is to run, for `WorkerConfig.read`.
            memory: Descriptor of the shared memory.
        """
        self.begin(_MAIN, orders, self.rows.start, self.rows.stop, passed=[memory])
        self.busy = True

    def go(self) -> None:
        """Let it work; one that is lost is found out by `wait`."""
        self.busy = True
        if self.connection:
            with suppress(OSError):
                self.connection.sendall(b"!")

    def wait(self, limit_s: float) -> Fault | None:
        """Wait for its answer; if none comes, end it and say why."""
        if self.connection is None:
            return Fault("is not running", "")
        self.connection.settimeout(limit_s)
        try:
            answer = self.connection.recv(1)
        except TimeoutError:
            return self.autopsy(f"did not answer within {limit_s:g} s")
        except OSError:
            answer = b""
        if not answer:
            return self.autopsy()
        self.busy = False
        return None

    def end(self) -> None:
        """See `ChildProcess.end`."""
        super().end()
        self.busy = False
