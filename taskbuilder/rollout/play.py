"""Playing episodes and recording them: the only loop that steps an environment."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol, TypeVar, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.rollout.players import Function, RecordedActions
from taskbuilder.rollout.record import Rollout, ScriptLog
from taskbuilder.rollout.recorder import Recorder
from taskbuilder.rollout.witness import Witness
from taskbuilder.wording import excerpt

Act = Callable[[Mapping[str, Any]], Mapping[str, NDArray[np.floating]] | None]
"""Every agent's action, given every agent's observation; None to stop playing."""

Result = TypeVar("Result")

Watch = Callable[[TaskEnv], None]
"""Called with the environment after its reset and after each control step."""


class Policy(Protocol):
    """Chooses the actions of all agents; deterministic for a given episode seed.

    A policy has two methods: ``reset(env, seed)`` prepares for an episode, and
    ``act(observations)`` returns the action of every agent, or None to stop playing.
    """

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Prepare for an episode; called after the environment was reset with this seed."""

    def act(self, observations: Mapping[str, Any], /) -> Actions | None:
        """Every agent's action, given every agent's observation; None to stop playing."""


@runtime_checkable
class Scripted(Protocol):
    """A policy that follows the stages of a script."""

    def log(self) -> ScriptLog | None:
        """The log of the stages, or None if it followed none; called after the episode."""


class Step(NamedTuple):
    """The result of a reset, without rewards, or of a step."""

    observations: Mapping[str, Any]
    rewards: Mapping[str, float]
    terminations: Mapping[str, bool]
    truncations: Mapping[str, bool]
    infos: Mapping[str, Mapping[str, float]]


def play(
    env: TaskEnv,
    policy: Policy | Act,
    seed: int,
    *,
    observations: bool = False,
    cameras: Sequence[str] = (),
    size: tuple[int, int] | None = None,
    forces: bool = False,
    explain: bool = False,
    watch: Watch | None = None,
    after_success: int | None = None,
) -> Rollout:
    """Play an episode.

    Args:
        env: The environment.
        policy: A `Policy`, or a function from observations to actions.
        seed: Seed passed to `reset`; it determines everything that is random in the environment.
        observations: Whether to record the observations of every agent.
        cameras: Names of the cameras whose images are recorded.
        size: Width and height of the images in pixels; by default, those of each camera.
        forces: Whether to record, for each control step, the largest contact force between two
            robots, in `Rollout.robot_force`.
        explain: Whether to record why success is false, if it is false at the end.
        watch: Function that is called with the environment after reset and after each control step.
        after_success: Number of control steps to play after the episode has succeeded; by default,
            the episode is played to its end.

    Returns:
        The record of the episode, up to its end or to the step at which the policy stopped.

    Raises:
        UnknownNameError: The scene has no such camera.
        UsageError: The environment has dictionary actions (``flat=False``).
    """
    steps = playing(
        env,
        policy,
        seed,
        observations=observations,
        cameras=cameras,
        size=size,
        forces=forces,
        explain=explain,
        watch=watch,
        after_success=after_success,
    )
    return to_the_end(steps)


def to_the_end(steps: Generator[Any, None, Result]) -> Result:
    """Exhaust a generator, and return what it returns."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast("Result", end.value)


def playing(
    env: TaskEnv,
    policy: Policy | Act,
    seed: int,
    *,
    observations: bool = False,
    cameras: Sequence[str] = (),
    size: tuple[int, int] | None = None,
    forces: bool = False,
    explain: bool = False,
    watch: Watch | None = None,
    after_success: int | None = None,
) -> Generator[Step, None, Rollout]:
    """Play an episode step by step, when the caller asks for the next one.

    The arguments and errors are those of `play`.

    Yields:
        The result of the reset, then of each control step.

    Returns:
        The record of the episode.
    """
    recorder = Recorder(env, observations=observations, cameras=cameras, size=size, forces=forces)
    witness = Witness() if explain else None
    played = as_policy(policy)
    last: float = math.inf
    for step in _from_reset(recorder, played, seed):
        for onlooker in (witness, watch):
            if onlooker is not None:
                onlooker(env)
        yield step
        if after_success is not None and env.episode.succeeded:
            last = min(last, env.episode.steps + after_success)
        if env.episode.steps >= last:
            break
    rollout = recorder.rollout(played.log() if isinstance(played, Scripted) else None)
    return replace(rollout, why=witness.reasons(env, rollout)) if witness else rollout


def resume(
    env: TaskEnv,
    policy: Policy | Act,
    before: Rollout,
    observations: Mapping[str, Any] | None = None,
    *,
    watch: Watch | None = None,
) -> Rollout:
    """Continue an episode from the middle.

    Args:
        env: The environment, in the state at the end of ``before``.
        policy: The policy that continues; as for `play`.
        before: The record so far; its observations and pictures are not kept.
        observations: The current observations, for policies that use them.
        watch: Called after each control step.

    Returns:
        The record of the whole episode.
    """
    recorder = Recorder(env, forces=len(before.robot_force) > 0)
    recorder.take_over(before, observations or {})
    played = as_policy(policy)
    played.reset(env, before.seed)
    for _ in _go_on(recorder, played):
        if watch is not None:
            watch(env)
    return recorder.rollout(before.log)


def replay(env: TaskEnv, rollout: Rollout, watch: Watch | None = None) -> Rollout:
    """Replay the actions of a recorded episode. This reproduces the episode bit for bit.

    Args:
        env: An environment with the same task, variation and options as in the record.
        rollout: The record to replay.
        watch: Function that is called with the environment after reset and after each control step.

    Returns:
        The record of the new episode, with the ``log`` of ``rollout``.

    Raises:
        UsageError: The environment has a different task, variation or option.
    """
    _check_same_task(env, rollout)
    played = play(
        env,
        RecordedActions(rollout.actions),
        rollout.seed,
        forces=len(rollout.robot_force) > 0,
        explain=bool(rollout.why),
        watch=watch,
    )
    return replace(played, log=rollout.log)


def replaying(env: TaskEnv, rollout: Rollout) -> Iterator[Step]:
    """Replay the actions of a record, step by step.

    Args:
        env: As for `replay`.
        rollout: The record to replay.

    Yields:
        The result of the reset, then of each control step.

    Raises:
        UsageError: The environment is of another task, variation or option.
    """
    _check_same_task(env, rollout)
    yield from _from_reset(Recorder(env), RecordedActions(rollout.actions), rollout.seed)


def as_policy(policy: Policy | Act) -> Policy:
    """Convert a function of observations to a policy; a policy is returned unchanged.

    Raises:
        UsageError: It is neither.
    """
    if callable(getattr(policy, "act", None)) and callable(getattr(policy, "reset", None)):
        return cast("Policy", policy)
    if callable(policy):
        return Function(policy)
    kind = excerpt(repr(policy)) if isinstance(policy, str) else type(policy).__name__
    raise UsageError(
        f"the policy is {kind}, which has no reset and act; play takes an object with these, or a "
        "function from observations to actions. `Expert(env)` plays the expert, and `evaluate` "
        "takes the names of policies"
    )


def _from_reset(recorder: Recorder, policy: Policy, seed: int) -> Iterator[Step]:
    env = recorder.env
    observations, infos = env.reset(seed=seed)
    recorder.begin(seed, observations)
    policy.reset(env, seed)
    yield Step(observations, {}, {}, {}, infos)
    yield from _go_on(recorder, policy)


def _go_on(recorder: Recorder, policy: Policy) -> Iterator[Step]:
    """Step the environment with the policy until the episode ends or the policy stops."""
    env = recorder.env
    while env.agents:
        actions = policy.act(recorder.latest)
        if actions is None:
            return
        step = Step(*env.step(actions))
        recorder.add(actions, step.observations, step.rewards)
        yield step


def _check_same_task(env: TaskEnv, rollout: Rollout) -> None:
    """Check that a replay can be the same to the bit, as far as the options decide that."""
    if env.task.name != rollout.task:
        raise UsageError(f"a rollout of {rollout.task} cannot be replayed in {env.task.name}")
    timing = env.episode.world.spec.timing
    here = env.options.decisive | {
        "horizon": env.max_episode_steps,
        "control_hz": timing.control_hz,
    }
    then = rollout.options.decisive
    then |= {"horizon": rollout.horizon, "control_hz": rollout.control_hz}
    if here["variation"] != "random":  # the seed draws the same one again
        then["variation"] = rollout.variation
    for name, value in then.items():
        if here[name] != value:
            raise UsageError(
                f"the rollout was recorded with {name}={value!r}, and the environment has "
                f"{name}={here[name]!r}; replay it where these are the same"
            )
