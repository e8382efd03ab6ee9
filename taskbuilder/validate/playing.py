"""Policies of simple probes, and a check of reward terms."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.script.orders import HALF_OPEN
from taskbuilder.rollout.play import Policy, play
from taskbuilder.rollout.players import HoldStill, RandomActions
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.env_cache import EnvCache, Start

DISCOUNT = 0.95
LARGEST = 1e6
"""Maximum size of a reward term at a control step, for which single precision still resolves a
tenth."""

SWING_STEPS = 6
"""Control steps of a throw; the gripper opens half-way."""


def wild_terms(rollout: Rollout) -> Mapping[str, float]:
    """The last value of each reward term that was not finite or above `LARGEST`, by label."""
    found = {}
    for label, values in rollout.terms.items():
        wild = values[~(np.abs(values) <= LARGEST)]  # which finds what is not a number, too
        if len(wild):
            found[label] = float(wild[-1])
    return found


def play_expert(cache: EnvCache, start: Start) -> Rollout:
    """Play the expert up to the end of the episode.

    Starts that only test success end, after the last stage, as soon as the result is known.
    """
    in_turn = start.seed % len(cache.task.file.scenes) == start.variation
    expert = cache.expert(start.variation)
    return expert.play(start.seed, finish=True if in_turn else "undecided", explain=True)


def play_nothing(env: TaskEnv, seed: int, *, until_decided: bool = False) -> Rollout:
    """Play an episode in which all robots hold still; see `UntilDecided`."""
    return play(env, UntilDecided(HoldStill()) if until_decided else HoldStill(), seed)


def play_random(env: TaskEnv, seed: int, *, until_decided: bool = False) -> Rollout:
    """Play an episode of random actions, drawn from the seed; see `UntilDecided`."""
    return play(env, UntilDecided(RandomActions()) if until_decided else RandomActions(), seed)


class UntilDecided:
    """Follows another policy until the episode has succeeded, or cannot succeed any more.

    Once failure has held, success does not count: nothing that comes later changes whether the
    episode succeeds.

    Args:
        policy: The other policy.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode."""
        self._env = env
        self._policy.reset(env, seed)

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The other policy's actions, or None once the success is decided."""
        return None if is_decided(self._env) else self._policy.act(observations)


def is_decided(env: TaskEnv) -> bool:
    """Whether the rest of an episode cannot change whether it succeeds."""
    return env.episode.succeeded or env.episode.failed


def is_whole(rollout: Rollout) -> bool:
    """Whether an episode was played to its end, not only until its success was decided."""
    decided = rollout.success or rollout.failed_at is not None
    return rollout.exploded or not decided or rollout.steps >= rollout.horizon


def random_actions(env: TaskEnv, seed: int) -> Iterator[Actions]:
    """An episode's actions, drawn uniformly from the action spaces."""
    policy = RandomActions()
    policy.reset(env, seed)
    for _ in range(env.episode.horizon):
        yield policy.act({})


class DropAll(HoldStill):
    """Opens all grippers, or closes those that hold from inside, then holds still."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin with the opening."""
        super().reset(env, seed)
        encoder = ActionEncoder(env)
        self._first: Actions | None = encoder.actions(openings=_letting_go(env))

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """Open, then hold."""
        first, self._first = self._first, None
        return super().act(observations) if first is None else first


class ThrowAll(HoldStill):
    """Swings all arms sideways at full speed, opens the grippers half-way, then holds still."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin with the swing."""
        super().reset(env, seed)
        self._env, self._step = env, 0

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """Swing, then hold."""
        step, self._step = self._step, self._step + 1
        if step >= SWING_STEPS:
            return super().act(observations)
        agents = self._env.possible_agents
        joints = {agent: _swung(self._env, agent) for agent in agents}
        openings = _letting_go(self._env) if step >= SWING_STEPS // 2 else {}
        return ActionEncoder(self._env).actions(joints, openings)


def _letting_go(env: TaskEnv) -> dict[str, float]:
    """Openings with which all grippers let go: 1, or 0 where one holds something from inside."""
    world = env.episode.world
    return {
        agent: 0.0
        if world.robots[agent].gripper.told() > HALF_OPEN
        and any(world.held(name, agent) for name in world.movable)
        else 1.0
        for agent in env.possible_agents
    }


def _swung(env: TaskEnv, agent: str) -> list[float]:
    """An arm's commanded joints, with the first one moved by the maximum of a control step."""
    arm = env.episode.actions[agent].arm
    first, *rest = arm.robot.commanded()
    return [min(first + arm.longest[0], arm.ik.upper[0]), *rest]
