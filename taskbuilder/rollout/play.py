"""Playing episodes: the one loop that steps an environment, and the record it leaves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.rollout.players import Function, RecordedActions
from taskbuilder.rollout.record import Rollout, ScriptLog
from taskbuilder.rollout.recorder import Recorder
from taskbuilder.rollout.witness import Witness

Act = Callable[[Mapping[str, Any]], Mapping[str, NDArray[np.floating]] | None]
"""Every agent's action, given every agent's observation; None to stop playing."""

Watch = Callable[[TaskEnv], None]
"""Looks at an environment after its reset and after each control step."""


class Policy(Protocol):
    """Chooses the actions of all agents; deterministic in the seed of the episode."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Prepare for an episode, which the environment has just begun from this seed."""

    def act(self, observations: Mapping[str, Any], /) -> Actions | None:
        """Every agent's action, given every agent's observation; None to stop playing."""


@runtime_checkable
class Scripted(Protocol):
    """A policy that plays the stages of a script."""

    def log(self) -> ScriptLog:
        """How the stages went; asked for once the episode has been played."""


class Step(NamedTuple):
    """What the environment returned: of its reset, where there are no rewards yet, or of a step."""

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
) -> Rollout:
    """Play an episode.

    Args:
        env: The environment.
        policy: A `Policy`, or a function from observations to actions.
        seed: Of the reset; it decides all that chance decides.
        observations: Keep what every agent observes.
        cameras: Keep pictures of these cameras of the scene.
        size: Width and height of the pictures; by default each camera's own.
        forces: Keep the force between robots, metered whether or not the task asks for it.
        explain: Say why where success does not hold at the end.
        watch: Called after reset and after each control step.

    Returns:
        The record of the episode, up to its end or to where the policy stopped.

    Raises:
        UnknownNameError: The scene has no such camera.
        UsageError: The actions of the environment are dictionaries.
    """
    recorder = Recorder(env, observations=observations, cameras=cameras, size=size, forces=forces)
    witness = Witness() if explain else None
    played = as_policy(policy)
    for _ in _from_reset(recorder, played, seed):
        for onlooker in (witness, watch):
            if onlooker is not None:
                onlooker(env)
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
    """Play on from the middle of an episode.

    Args:
        env: The environment, as it stood at the end of ``before``.
        policy: Who plays on; as for `play`.
        before: The record so far; observations and pictures that it has are left behind.
        observations: What every agent observes now, for policies that look at it.
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
    """Play the actions of a record again; the episode goes as it went, to the bit.

    Args:
        env: Of the record's task and variation, with options that it was played with.
        rollout: What to play.
        watch: Called after reset and after each control step.

    Returns:
        The record of the episode as it went this time, with the log of the script as it was.

    Raises:
        UsageError: The environment is of another task.
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
    """Play the actions of a record again, step by step.

    Args:
        env: As for `replay`.
        rollout: What to play.

    Yields:
        What the environment returned: first of its reset, then of each control step.

    Raises:
        UsageError: The environment is of another task.
    """
    _check_same_task(env, rollout)
    yield from _from_reset(Recorder(env), RecordedActions(rollout.actions), rollout.seed)


def as_policy(policy: Policy | Act) -> Policy:
    """A policy as it is; a function as the policy that asks it at every step."""
    return Function(policy) if callable(policy) else policy


def _from_reset(recorder: Recorder, policy: Policy, seed: int) -> Iterator[Step]:
    env = recorder.env
    observations, infos = env.reset(seed=seed)
    recorder.begin(seed, observations)
    policy.reset(env, seed)
    yield Step(observations, {}, {}, {}, infos)
    yield from _go_on(recorder, policy)


def _go_on(recorder: Recorder, policy: Policy) -> Iterator[Step]:
    """Step the environment by what the policy chooses, until either ends it."""
    env = recorder.env
    while env.agents:
        actions = policy.act(recorder.latest)
        if actions is None:
            return
        step = Step(*env.step(actions))
        recorder.add(actions, step.observations, step.rewards)
        yield step


def _check_same_task(env: TaskEnv, rollout: Rollout) -> None:
    if env.task.name != rollout.task:
        raise UsageError(f"a rollout of {rollout.task} cannot be replayed in {env.task.name}")
