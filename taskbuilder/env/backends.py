"""Backends of a vector environment: this process, or workers that are replaced when lost.

An owner and a worker exchange single bytes; all other data is in shared buffers. A worker holds
nothing that must outlive it, so it is ended by killing it.
"""

from __future__ import annotations

import io
import logging
import os
import pickle
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, Protocol

from taskbuilder.env.env_group import EnvGroup, Wrap
from taskbuilder.env.process import WorkerProcess
from taskbuilder.env.shared_buffers import Allocator, SharedBuffers, make_block, map_block
from taskbuilder.env.worker import WorkerConfig
from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.processes import Fault

START_LIMIT_S = 120.0
"""Time limit for a worker to build its environments, in seconds."""

_log = logging.getLogger(__name__)


class WorkerError(TaskbuilderError):
    """A worker was lost repeatedly without completing a step in between.

    Attributes:
        worker: Number of the worker.
        environments: Its environments.
        cause: The cause of the last loss.
        words: The traceback that it left, or "".
    """

    def __init__(self, worker: int, environments: range, fault: Fault, times: int) -> None:
        self.worker = worker
        self.environments = environments
        self.cause = fault.cause
        self.words = fault.words
        title = _title(worker, environments)
        super().__init__(f"{title} {fault.cause} ({times} in a row)\n{fault.words}".rstrip())


class Backend(Protocol):
    """The interface of a backend, which runs the environments of a vector."""

    @property
    def buffers(self) -> SharedBuffers:
        """The shared arrays of actions, observations and rewards."""

    @property
    def pids(self) -> tuple[int, ...]:
        """Process ids of the workers, if there are any."""

    @property
    def envs(self) -> tuple[Any, ...]:
        """The environments, by row, if they are in this process."""

    def settle(self) -> None:
        """Wait until no environment is using the buffers, also after an interruption.

        Raises:
            WorkerError: A worker is lost repeatedly.
        """

    def go(self) -> None:
        """Start the work that the buffers describe, without waiting."""

    def wait(self, *, begin_anew: bool) -> list[range]:
        """Wait until all environments have finished.

        Args:
            begin_anew: Reset the environments of a lost worker at once.

        Returns:
            Rows of environments whose step was lost with their worker.

        Raises:
            WorkerError: A worker is lost repeatedly.
        """

    def close(self) -> None:
        """Close the environments; the buffers stay."""


class InProcess:
    """Runs the environments in this process; their errors are raised here."""

    pids: tuple[int, ...] = ()

    def __init__(self, config: WorkerConfig) -> None:
        self.buffers = SharedBuffers(config.signature, config.num_envs, Allocator())
        self._group = EnvGroup(
            config.task,
            config.options,
            config.wrap,
            self.buffers,
            range(config.num_envs),
            same_step=config.same_step,
        )

    @property
    def envs(self) -> tuple[Any, ...]:
        """The environments, by row."""
        return self._group.envs

    def settle(self) -> None:
        """Wait until no environment is using the buffers."""

    def go(self) -> None:
        """Start the work that the buffers describe, without waiting."""

    def wait(self, *, begin_anew: bool) -> list[range]:
        """Wait until all environments have finished, and return the rows that were lost."""
        del begin_anew
        self._group.advance()
        return []

    def close(self) -> None:
        """Close the environments; the buffers stay."""
        self._group.close()


class Subprocesses:
    """Worker processes, each with a group of the environments.

    Args:
        config: Configuration of the environments.
        count: Number of workers, at most one per environment.
        timeout_s: Time limit for a worker to step all its environments.
        retries: Maximum number of replacements of a worker in a row.

    Attributes:
        buffers: The buffers that they share.

    Raises:
        UsageError: The description cannot be sent to other processes.
        WorkerError: A worker does not start.
    """

    envs: tuple[Any, ...] = ()

    def __init__(self, config: WorkerConfig, count: int, *, timeout_s: float, retries: int) -> None:
        self._owner = os.getpid()
        self._timeout_s = timeout_s
        self._retries = retries
        self._config = _packed(config)
        self._memory = make_block(_bytes_of(config))
        self.buffers = SharedBuffers(
            config.signature, config.num_envs, Allocator(map_block(self._memory))
        )
        bounds = [config.num_envs * number // count for number in range(count + 1)]
        self._workers = [
            WorkerProcess(number, range(bounds[number], bounds[number + 1]))
            for number in range(count)
        ]
        try:
            self._start(self._workers)
        except BaseException:
            self.close()
            raise

    @property
    def pids(self) -> tuple[int, ...]:
        """Process ids of the workers; -1 for one that is not running."""
        return tuple(worker.pid for worker in self._workers)

    def settle(self) -> None:
        """Wait until no environment is using the buffers."""
        for worker in self._workers:
            if worker.busy:
                worker.wait(self._timeout_s)
        self._start([worker for worker in self._workers if worker.pid < 0])

    def go(self) -> None:
        """Start the work that the buffers describe, without waiting."""
        for worker in self._workers:
            worker.go()

    def wait(self, *, begin_anew: bool) -> list[range]:
        """Wait until all environments have finished, and return the rows that were lost."""
        faults = [(worker, worker.wait(self._timeout_s)) for worker in self._workers]
        lost = []
        for worker, fault in faults:
            if fault is None:
                worker.losses = 0
            else:
                self._replace(worker, fault, begin_anew=begin_anew)
                lost.append(worker.rows)
        return lost

    def close(self) -> None:
        """Close the environments; the buffers stay."""
        if os.getpid() != self._owner:  # a fork of the owner must leave the workers alone
            return
        for worker in self._workers:
            worker.end()
        if self._memory >= 0:
            os.close(self._memory)
            self._memory = -1

    def _start(self, workers: Sequence[WorkerProcess]) -> None:
        for worker in workers:
            worker.losses = 0
            worker.start(self._config, self._memory)
        for worker in workers:
            fault = worker.wait(START_LIMIT_S)
            if fault:
                self._replace(worker, fault, begin_anew=False)

    def _replace(self, worker: WorkerProcess, fault: Fault, *, begin_anew: bool) -> None:
        reason: Fault | None = fault
        while reason:
            worker.losses += 1
            if worker.losses > self._retries:
                raise WorkerError(worker.number, worker.rows, reason, worker.losses)
            title = _title(worker.number, worker.rows)
            _log.warning("%s %s; it is replaced\n%s", title, reason.cause, reason.words)
            worker.start(self._config, self._memory)
            reason = worker.wait(START_LIMIT_S)
            if begin_anew and not reason:
                self.buffers.begin[worker.rows.start : worker.rows.stop] = True
                worker.go()
                reason = worker.wait(self._timeout_s)


def _packed(config: WorkerConfig) -> bytes:
    file = io.BytesIO()
    try:
        config.write(file)
    except (AttributeError, TypeError, pickle.PicklingError) as error:
        what = f"the description of {config.task.name}" if _packs(config.wrap) else "wrap"
        raise UsageError(
            f"workers cannot import {what} ({error}); define it at the top of a module, or use "
            "workers=0"
        ) from error
    return file.getvalue()


def _packs(wrap: Wrap) -> bool:
    # Pickle raises any of these for what another process cannot import.
    with suppress(AttributeError, TypeError, pickle.PicklingError):
        pickle.dumps(wrap)
        return True
    return False


def _bytes_of(config: WorkerConfig) -> int:
    allocator = Allocator()
    SharedBuffers(config.signature, config.num_envs, allocator)
    return allocator.size


def _title(number: int, rows: Sequence[int]) -> str:
    several = f"environments {rows[0]} to {rows[-1]}"
    return f"worker {number} ({several if len(rows) > 1 else f'environment {rows[0]}'})"
