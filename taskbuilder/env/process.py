"""The owner's handle on a worker process."""

from __future__ import annotations

from contextlib import suppress

from taskbuilder.processes import ChildProcess, Fault

_MAIN = "from taskbuilder.env.worker import main; main()"


class WorkerProcess(ChildProcess):
    """One worker.

    Attributes:
        number: Its number, from 0.
        rows: Rows of its environments.
        losses: Number of losses in a row.
        busy: Whether an answer is pending.
    """

    def __init__(self, number: int, rows: range) -> None:
        super().__init__()
        self.number = number
        self.rows = rows
        self.losses = 0
        self.busy = False

    def start(self, orders: bytes, memory: int) -> None:
        """Start a process, which answers when its environments are built.

        Args:
            orders: Its configuration, for `WorkerConfig.read`.
            memory: Descriptor of the shared memory.
        """
        self.begin(_MAIN, orders, self.rows.start, self.rows.stop, passed=[memory])
        self.busy = True

    def go(self) -> None:
        """Start work; `wait` detects a lost process."""
        self.busy = True
        if self.connection:
            with suppress(OSError):
                self.connection.sendall(b"!")

    def wait(self, limit_s: float) -> Fault | None:
        """Wait for its answer; without one, end it and return the cause."""
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
        """End the worker process."""
        super().end()
        self.busy = False
