"""The vector view: parallel environments of a task, in this process or in several."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from taskbuilder.arguments import as_whole, whole
from taskbuilder.env.backends import Backend, InProcess, Subprocesses
from taskbuilder.env.batch import read_actions, read_seeds
from taskbuilder.env.env_group import Wrap, unwrapped
from taskbuilder.env.errors import EpisodeOverError
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import EnvOptions, Options, make_options
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.shared_buffers import Allocator, Signature, StepView, copied, row_of
from taskbuilder.env.worker import WorkerConfig
from taskbuilder.errors import UsageError
from taskbuilder.task import Task, load_task

VectorValues = dict[str, Any]
Flags = NDArray[np.bool_]


class TaskVectorEnv(VectorEnv[VectorValues, VectorValues, Any]):
    """Parallel environments of one task. Call `make_vec` to make them.

    Observations, actions and rewards are dictionaries keyed by agent. Each value is an array with
    one row per environment. Terminations and truncations are single arrays and not dictionaries,
    because the episodes of all agents in an environment end together. The infos are a dictionary of
    arrays with one element per environment. This dictionary has the keys of the infos of `TaskEnv`
    and the key "lost". The array "lost" is 1.0 for each environment whose episode was cut off
    because its worker died or hung. If episodes have just begun, the infos also have an object
    array "instruction", with the instruction of each of these episodes and None for the others, and
    the mask "_instruction". Returned arrays are copies, which the caller may change.

    Each environment draws the seeds of its episodes like a `TaskEnv` that is reset with a seed once
    and then without a seed. The results therefore depend only on the seeds and the actions, not on
    the number of workers.

    What happens when an episode ends depends on ``metadata["autoreset_mode"]``:

    - same step: the environment is reset within the step. Observations, `state` and infos are those
      after the reset. The last values of the old episode are in the infos "final_obs",
      "final_state" and "final_info". "final_obs" is an object array: a dictionary keyed by agent
      for each environment whose episode ended, and None for the others. The infos "_final_obs",
      "_final_state" and "_final_info" are masks of the environments whose episode ended.
    - next step: the next call of `step` ignores the actions for this environment, resets it and
      returns zero reward for it.

    A worker that dies or hangs is replaced, and a warning is logged. In that step, the episodes of
    its environments are truncated with a reward of zero. The final observation of each of these
    episodes is the last observation that was returned. The environments of the other workers are
    not affected.

    Attributes:
        num_envs: Number of environments.
        config: Their task, their options and how each is wrapped.
    """

    def __init__(self, config: WorkerConfig, backend: Backend, mode: AutoresetMode) -> None:
        self._finalizer = weakref.finalize(self, backend.close)
        self.config = config
        self.num_envs = num_envs = config.num_envs
        name = f"{config.task.name}_v{config.task.version}"
        self.metadata = {"name": name, "render_modes": [], "autoreset_mode": mode}
        self._same_step = mode is AutoresetMode.SAME_STEP
        self._signature = signature = config.signature
        self._backend = backend
        self._buffers = backend.buffers
        # What was returned last. Workers may die while they write to buffers that they share.
        self._seen = StepView(signature, num_envs, Allocator())
        self._running = self._under_way = False
        self._generators = [np.random.default_rng() for _ in range(num_envs)]
        self._draw_seeds(np.ones(num_envs, dtype=np.bool_))
        self._make_spaces()

    def _make_spaces(self) -> None:
        self.single_observation_space = spaces.Dict(dict(self._signature.observation_spaces))
        self.single_action_space = spaces.Dict(dict(self._signature.action_spaces))
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)

    @property
    def agents(self) -> tuple[str, ...]:
        """The robots of the scene, in file order."""
        return self._signature.agents

    @property
    def action_names(self) -> Mapping[str, tuple[str, ...]]:
        """The name of each number of an agent's action, by agent, such as ``left.dx``."""
        return self._signature.action_names

    @property
    def state_space(self) -> spaces.Box:
        """The space of one environment's `state`."""
        return self._signature.state_space

    @property
    def envs(self) -> tuple[Any, ...]:
        """The environments, by row, as in Gymnasium's `SyncVectorEnv`; none with workers."""
        return self._backend.envs

    @property
    def worker_pids(self) -> tuple[int, ...]:
        """Process ids of the workers in order; -1 for one that is not running."""
        return self._backend.pids

    # --- stepping

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[VectorValues, dict[str, Any]]:
        """Reset every environment.

        Args:
            seed: Seed of the first environment, with seed + 1 for the next and so on; or a seed for
                each. Environments without a seed continue their own sequence.
            options: Not used; required by Gymnasium.

        Raises:
            UsageError: The environment is closed, a seed is invalid, or ``reset_mask`` is given,
                which autoreset makes unnecessary.
            WorkerError: A worker is lost repeatedly.
        """
        self._check_open()
        if "reset_mask" in (options or {}):
            raise UsageError("reset_mask is not supported; episodes follow each other as they end")
        seeds = read_seeds(seed, self.num_envs)
        self._running = self._under_way = False
        self._backend.settle()
        for row, number in enumerate(seeds):
            if number is not None:
                self._generators[row] = np.random.default_rng(number)
                self._buffers.seeds[row] = number
        self._buffers.begin[:] = True
        self._backend.go()
        self._backend.wait(begin_anew=True)
        self._draw_seeds(self._buffers.begin)
        self._buffers.begin[:] = False
        self._seen.copy(self._buffers.now)
        self._running = True
        everywhere = np.ones(self.num_envs, dtype=np.bool_)
        return copied(self._seen.observations), self._infos() | self._instructions(everywhere)

    def step(
        self, actions: VectorValues
    ) -> tuple[VectorValues, VectorValues, Flags, Flags, dict[str, Any]]:
        """Run one control step in every environment.

        Args:
            actions: By agent: (num_envs, n), or with ``flat=False`` dictionaries of such arrays.
                Numbers beyond the bounds are clipped.

        Returns:
            Observations by agent, rewards by agent ((num_envs,) float64), terminations and
            truncations ((num_envs,) bool), and infos.

        Raises:
            ActionError: Actions are not finite, or of another shape or kind.
            AgentError: An agent's actions are missing, or there is no such agent.
            EpisodeOverError: There was no reset, or not since a step that was interrupted.
            UsageError: The environment is closed.
            WorkerError: A worker is lost repeatedly.
        """
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: VectorValues) -> None:
        """Start a step without waiting for the workers.

        Args:
            actions: As for `step`.

        Raises:
            ActionError: Actions are not finite, or of another shape or kind.
            AgentError: An agent's actions are missing, or there is no such agent.
            EpisodeOverError: There was no reset, not since a step that was interrupted, or the
                last step was not waited for.
            UsageError: The environment is closed.
        """
        self._check_open()
        self._check_running()
        for agent, values in read_actions(actions, self._signature, self.num_envs).items():
            self._buffers.actions[agent][:] = values
        self._running = False  # until all is well again: an interrupt may come at any moment
        self._backend.go()
        self._under_way = True

    def step_wait(self) -> tuple[VectorValues, VectorValues, Flags, Flags, dict[str, Any]]:
        """Wait for the step that `step_async` started; returns the same as `step`.

        Raises:
            EpisodeOverError: No step was started.
            UsageError: The environment is closed.
            WorkerError: A worker is lost repeatedly.
        """
        self._check_open()
        if not self._under_way:
            raise EpisodeOverError("no step is under way; call step_async")
        self._under_way = False
        buffers = self._buffers
        lost = self._write_off(self._backend.wait(begin_anew=self._same_step))
        ended = buffers.terminated | buffers.truncated
        begun = ended if self._same_step else buffers.begin & ~lost
        self._draw_seeds(begun)
        buffers.begin[:] = ended & (not self._same_step)
        self._seen.copy(buffers.now)
        self._running = True
        infos = {**self._infos(), "lost": lost.astype(np.float64)}
        if begun.any():
            infos |= self._instructions(begun)
        if self._same_step and ended.any():
            infos |= self._final_infos(ended, infos["lost"])
        rewards = dict(zip(self.agents, buffers.rewards.T.copy(), strict=True))
        return (
            copied(self._seen.observations),
            rewards,
            buffers.terminated.copy(),
            buffers.truncated.copy(),
            infos,
        )

    def state(self) -> NDArray[np.float32]:
        """The state for centralised critics after the last reset or step: (num_envs, state_dim).

        Raises:
            EpisodeOverError: There was no reset, not since a step that was interrupted, or a step
                is under way.
        """
        self._check_running()
        return self._seen.state.copy()

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments and end the workers; called by `close`, which can be repeated."""
        del kwargs
        self._running = self._under_way = False
        self._finalizer()

    def _check_open(self) -> None:
        if self.closed:
            raise UsageError("the environment is closed")

    def _check_running(self) -> None:
        if self._under_way:
            raise EpisodeOverError("a step is under way; call step_wait")
        if not self._running:
            raise EpisodeOverError("no episodes are running; call reset")

    def _draw_seeds(self, rows: Flags) -> None:
        """Draw the seeds of the next episodes."""
        for row in np.flatnonzero(rows):
            self._buffers.seeds[row] = self._generators[row].integers(2**31)

    def _write_off(self, lost: Sequence[range]) -> Flags:
        """Truncate the episodes of lost workers at their last observation, and mark them."""
        buffers = self._buffers
        mask = np.zeros(self.num_envs, dtype=np.bool_)
        for rows in lost:
            part = slice(rows.start, rows.stop)
            (buffers.final if self._same_step else buffers.now).copy(self._seen, rows)
            buffers.rewards[part] = 0.0
            buffers.terminated[part] = False
            buffers.truncated[part] = mask[part] = True
        return mask

    # --- infos

    def _infos(self) -> dict[str, Any]:
        infos = dict(zip(self._signature.info_keys, self._seen.infos.T.copy(), strict=True))
        return {**infos, "lost": np.zeros(self.num_envs)}

    def _instructions(self, begun: Flags) -> dict[str, Any]:
        """The instructions of the episodes that have just begun, None elsewhere, and their mask."""
        texts = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(begun):
            texts[row] = self._buffers.instructions[row].decode()
        return {"instruction": texts, "_instruction": begun.copy()}

    def _final_infos(self, ended: Flags, lost: NDArray[np.float64]) -> dict[str, Any]:
        final = self._buffers.final
        observations = np.full(self.num_envs, None, dtype=object)
        for row in np.flatnonzero(ended):
            observations[row] = row_of(final.observations, int(row))
        numbers = np.where(ended, final.infos.T, 0.0)
        infos = dict(zip(self._signature.info_keys, numbers, strict=True))
        return {
            "final_obs": observations,
            "_final_obs": ended,
            "final_state": np.where(ended[:, None], final.state, np.float32(0.0)),
            "_final_state": ended.copy(),
            "final_info": {**infos, "lost": lost.copy()},
            "_final_info": ended.copy(),
        }


@takes_options
def make_vec(
    task: str | Path | Task,
    num_envs: int,
    workers: int = 0,
    *,
    autoreset: AutoresetMode | str = AutoresetMode.SAME_STEP,
    timeout_s: float = 60.0,
    retries: int = 3,
    wrap: Wrap = unwrapped,
    **options: Unpack[EnvOptions],
) -> TaskVectorEnv:
    """Make a vector environment of a task.

    Args:
        task: Name or path of the task, or the task itself.
        num_envs: Number of environments; each takes about 30 MB of memory.
        workers: Number of worker processes; with 0, all environments run in the calling process.
        autoreset: Gymnasium's autoreset mode, "SameStep" or "NextStep".
        timeout_s: Time in seconds that a worker may take to step all its environments once; a
            slower worker is replaced.
        retries: How many times in a row a worker may be replaced without completing a step.
        wrap: Function that wraps each environment. It is called in the process that runs the
            environment. With workers, the function must be picklable, such as a function defined at
            the top level of a module.
        options: Options of the environments; see `Options`.

    Raises:
        UnknownNameError: There is no such task.
        FileError: The files of the task have errors.
        UsageError: An argument is invalid, or an option does not fit the task.
        WorkerError: A worker process does not start.
    """
    mode = _mode(autoreset)
    _check_numbers(num_envs, workers, timeout_s, retries)
    loaded = task if isinstance(task, Task) else load_task(task)
    made = make_options(**options)
    signature = _signature(loaded, made, wrap)
    config = WorkerConfig(loaded, made, wrap, signature, num_envs, mode is AutoresetMode.SAME_STEP)
    backend: Backend = (
        Subprocesses(config, workers, timeout_s=timeout_s, retries=retries)
        if workers
        else InProcess(config)
    )
    return TaskVectorEnv(config, backend, mode)


def _signature(task: Task, options: Options, wrap: Wrap) -> Signature:
    if not callable(wrap):
        raise UsageError(f"wrap is {wrap!r}; a function that wraps an environment")
    env = wrap(TaskEnv(task, options))
    if env is None:
        raise UsageError("wrap returned None; it returns the wrapped environment")
    try:
        return Signature.of(env)
    finally:
        env.close()


def _mode(autoreset: AutoresetMode | str) -> AutoresetMode:
    modes = (AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP)
    for mode in modes:
        if autoreset in (mode, mode.value):
            return mode
    raise UsageError(f'autoreset is {autoreset!r}; "SameStep" or "NextStep"')


def _check_numbers(num_envs: int, workers: int, timeout_s: float, retries: int) -> None:
    whole("num_envs", num_envs, 1)
    if as_whole(workers) is None or not 0 <= workers <= num_envs:
        raise UsageError(f"workers is {workers}; 0 to {num_envs}, the number of environments")
    if timeout_s <= 0.0:
        raise UsageError(f"timeout_s is {timeout_s}; above 0")
    if retries < 0:
        raise UsageError(f"retries is {retries}; at least 0")
