"""A worker: a process that runs a group of environments.

`taskbuilder.env.backends` starts it as a fresh interpreter. It reads its configuration from
standard input. Then it calls `EnvGroup.advance` for every byte from its socket, and answers with a
byte. It never prints; the output of a crash goes to a file that its owner reads.
"""

from __future__ import annotations

import os
import pickle
import socket
import sys
import traceback
from dataclasses import dataclass
from typing import TYPE_CHECKING, BinaryIO

from taskbuilder.processes import become_child
from taskbuilder.quiet import drop

if TYPE_CHECKING:  # imported by main, when a failure to import can already be told
    from taskbuilder.env.env_group import EnvGroup, Wrap
    from taskbuilder.env.options import Options
    from taskbuilder.env.shared_buffers import Signature
    from taskbuilder.task import Task


@dataclass(frozen=True)
class WorkerConfig:
    """The configuration of workers.

    Attributes:
        task: The task.
        options: The options of the environments.
        wrap: Wraps each environment.
        signature: The spaces and keys of the environments.
        num_envs: Number of environments, including those of other workers.
        same_step: See `EnvGroup`.
    """

    task: Task
    options: Options
    wrap: Wrap
    signature: Signature
    num_envs: int
    same_step: bool

    def write(self, file: BinaryIO) -> None:
        """Write the configuration for `read`.

        The task's entry goes first: reading it imports the description, under the name by which
        the task then refers to it. That name holds a digest of a description outside packages, so
        a worker that starts after its file was edited fails, instead of using another reward.

        Raises:
            AttributeError, TypeError, pickle.PicklingError: The description is not importable.
        """
        # Pickle is read back only by a child that this process starts, from a pipe of its own.
        pickle.dump(self.task.file.entry, file)
        pickle.dump(self, file)

    @classmethod
    def read(cls, file: BinaryIO) -> WorkerConfig:
        """Read the configuration that `write` wrote."""
        from taskbuilder.description.load import load_description

        load_description(pickle.load(file))  # noqa: S301  # written by the parent process
        config: WorkerConfig = pickle.load(file)  # noqa: S301  # written by the parent process
        return config

    def group(self, memory: int, rows: range) -> EnvGroup:
        """Build the environments of some rows of the shared buffers in a block of memory."""
        from taskbuilder.env.env_group import EnvGroup
        from taskbuilder.env.shared_buffers import Allocator, SharedBuffers, map_block

        buffers = SharedBuffers(self.signature, self.num_envs, Allocator(map_block(memory)))
        return EnvGroup(self.task, self.options, self.wrap, buffers, rows, same_step=self.same_step)


def main() -> None:
    """Run the group of the command line and standard input until the owner is gone."""
    connection, lifeline, words, memory, start, stop = map(int, sys.argv[1:])
    last_words = os.fdopen(words, "wb", buffering=0)
    become_child(lifeline, last_words)
    drop(2)  # standard error: until now, it was kept with the last words
    try:
        group = WorkerConfig.read(sys.stdin.buffer).group(memory, range(start, stop))
        _serve(group, socket.socket(fileno=connection))
    except BaseException:  # whatever it is, the owner replaces this process
        last_words.write(traceback.format_exc().encode())
        os._exit(1)
    os._exit(0)  # without waiting for threads or exit handlers of the task's


def _serve(group: EnvGroup, connection: socket.socket) -> None:
    connection.sendall(b"!")
    while connection.recv(1):
        group.advance()
        connection.sendall(b"!")
