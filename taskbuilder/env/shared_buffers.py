"""Shared arrays of a vector environment and its workers, in one block of memory.

Each environment has a row of every array. The block is anonymous: it leaves no name behind, and is
freed with the last process that uses it.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import DTypeLike, NDArray

from taskbuilder.env.parallel import TaskEnv

_ALIGNMENT = 64  # bytes of a cache line, so that processes do not share one

EnvRows = range | slice


@dataclass(frozen=True)
class Signature:
    """The spaces and keys that all environments of a task share.

    Attributes:
        agents: The robots, in file order.
        observation_spaces: Observation space of every agent.
        action_spaces: Action space of every agent.
        action_names: Name of each number of each agent's action, such as ``left.dx``.
        state_space: Space of the centralised state.
        info_keys: Keys of every agent's info.
        instruction_bytes: Upper bound of the length of an instruction, in bytes of UTF-8.
    """

    agents: tuple[str, ...]
    observation_spaces: Mapping[str, spaces.Space[Any]]
    action_spaces: Mapping[str, spaces.Space[Any]]
    action_names: Mapping[str, tuple[str, ...]]
    state_space: spaces.Box
    info_keys: tuple[str, ...]
    instruction_bytes: int

    @classmethod
    def of(cls, env: TaskEnv) -> Signature:
        """The spaces and keys of an environment, which need not have been reset."""
        return cls(
            agents=tuple(env.possible_agents),
            observation_spaces=dict(env.observation_spaces),
            action_spaces=dict(env.action_spaces),
            action_names=env.action_names,
            state_space=env.state_space,
            info_keys=env.info_keys,
            instruction_bytes=env.unwrapped.episode.longest_instruction,
        )


class Allocator:
    """Allocates consecutive arrays in a block of memory, or on the heap without one.

    Attributes:
        size: Bytes of the arrays allocated so far.
    """

    def __init__(self, block: mmap.mmap | None = None) -> None:
        self.size = 0
        self._block = block

    def take(self, shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
        """Allocate an array, of zeros in a new block."""
        start = self.size
        bytes_ = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
        self.size += -(-bytes_ // _ALIGNMENT) * _ALIGNMENT
        if self._block is None:
            return np.zeros(shape, dtype)
        return np.ndarray(shape, dtype, self._block, start)


class StepView:
    """Observations, states and infos of all environments after a step.

    Attributes:
        observations: By agent: (num_envs, …), or a dictionary of such arrays.
        state: (num_envs, state_dim) float32, for centralised critics.
        infos: (num_envs, keys) float64, in the order of the signature's `info_keys`.
    """

    def __init__(self, signature: Signature, num_envs: int, allocator: Allocator) -> None:
        self._keys = signature.info_keys
        self.observations: dict[str, Any] = {
            agent: _rows_of(space, num_envs, allocator)
            for agent, space in signature.observation_spaces.items()
        }
        self.state = allocator.take((num_envs, *signature.state_space.shape), np.float32)
        self.infos = allocator.take((num_envs, len(signature.info_keys)), np.float64)
        self._arrays = (*_leaves(self.observations), self.state, self.infos)

    def write(
        self,
        row: int,
        observations: Mapping[str, Any],
        state: NDArray[np.float32],
        info: Mapping[str, float],
    ) -> None:
        """Write the view of one environment."""
        _write(self.observations, row, observations)
        self.state[row] = state
        self.infos[row] = [info[key] for key in self._keys]

    def copy(self, source: StepView, rows: EnvRows = slice(None)) -> None:
        """Copy rows of another view."""
        part = slice(rows.start, rows.stop)
        for mine, theirs in zip(self._arrays, source._arrays, strict=True):
            mine[part] = theirs[part]


class SharedBuffers:
    """All arrays of a vector environment.

    The owner writes actions, lets the environments step, and reads the results. Nobody writes while
    another process may read.

    Attributes:
        actions: By agent: (num_envs, n) float64.
        begin: (num_envs,) bool: reset instead of acting.
        seeds: (num_envs,) int64: seeds of the next episodes.
        now: The view after the step.
        final: The view at the end of episodes that were followed by a reset within the step.
        rewards: (num_envs, agents) float64.
        terminated: (num_envs,) bool.
        truncated: (num_envs,) bool.
        instructions: (num_envs,) UTF-8: the instruction of each episode.
    """

    def __init__(self, signature: Signature, num_envs: int, allocator: Allocator) -> None:
        self.actions: dict[str, NDArray[np.float64]] = {
            agent: allocator.take((num_envs, len(names)), np.float64)
            for agent, names in signature.action_names.items()
        }
        self.begin: NDArray[np.bool_] = allocator.take((num_envs,), np.bool_)
        self.seeds: NDArray[np.int64] = allocator.take((num_envs,), np.int64)
        self.now = StepView(signature, num_envs, allocator)
        self.final = StepView(signature, num_envs, allocator)
        self.rewards: NDArray[np.float64] = allocator.take(
            (num_envs, len(signature.agents)), np.float64
        )
        self.terminated: NDArray[np.bool_] = allocator.take((num_envs,), np.bool_)
        self.truncated: NDArray[np.bool_] = allocator.take((num_envs,), np.bool_)
        kind = f"S{signature.instruction_bytes}"
        self.instructions: NDArray[np.bytes_] = allocator.take((num_envs,), kind)


def make_block(size: int) -> int:
    """Make memory to share with child processes: a file descriptor for `map_block`."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("taskbuilder")
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, size)
    return descriptor


def map_block(descriptor: int) -> mmap.mmap:
    """Map a block of shared memory into this process."""
    return mmap.mmap(descriptor, os.fstat(descriptor).st_size)


def copied(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Copies of arrays, or of dictionaries of arrays."""
    return {
        key: copied(value) if isinstance(value, dict) else value.copy()
        for key, value in tree.items()
    }


def row_of(tree: Mapping[str, Any], row: int) -> dict[str, Any]:
    """The observations of one environment, in new arrays."""
    return {
        key: row_of(value, row) if isinstance(value, dict) else value[row].copy()
        for key, value in tree.items()
    }


def _rows_of(space: spaces.Space[Any], num_envs: int, allocator: Allocator) -> Any:
    if isinstance(space, spaces.Dict):
        return {key: _rows_of(part, num_envs, allocator) for key, part in space.items()}
    if space.shape is None or space.dtype is None:
        raise TypeError(f"observations in {space} cannot be laid out in arrays")
    return allocator.take((num_envs, *space.shape), space.dtype)


def _leaves(tree: Mapping[str, Any]) -> Iterator[NDArray[Any]]:
    for value in tree.values():
        if isinstance(value, dict):
            yield from _leaves(value)
        else:
            yield value


def _write(tree: Mapping[str, Any], row: int, values: Mapping[str, Any]) -> None:
    for key, array in tree.items():
        if isinstance(array, dict):
            _write(array, row, values[key])
        else:
            array[row] = values[key]
