"""Ways of playing a task that take no plan, and what validation asks of an episode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.play import play
from taskbuilder.rollout.players import HoldStill, RandomActions
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.studio import Start, Studio

DISCOUNT = 0.95
LARGEST = 1e6
"""How large a reward term may be at a control step: single precision, in which learners compute,
still tells it from a tenth more or less."""

SWING_STEPS = 6
"""Control steps of a throw; the gripper opens half-way."""


def wild_terms(rollout: Rollout) -> Mapping[str, float]:
    """The last value of each reward term, by label, that was not finite or beyond `LARGEST`."""
    found = {}
    for label, values in rollout.terms.items():
        wild = values[~(np.abs(values) <= LARGEST)]  # which finds what is not a number, too
        if len(wild):
            found[label] = float(wild[-1])
    return found


def play_expert(studio: Studio, start: Start) -> Rollout:
    """The expert's own way, up to the end of the episode.

    Starts that only show whether it succeeds are played on, once its stages are done, no longer
    than until that is known.
    """
    in_turn = start.seed % len(studio.task.file.scenes) == start.variation
    expert = studio.expert(start.variation)
    return expert.play(start.seed, finish=True if in_turn else "undecided", explain=True)


def play_nothing(env: TaskEnv, seed: int) -> Rollout:
    """Everyone holds still from the start."""
    return play(env, HoldStill(), seed)


def play_random(env: TaskEnv, seed: int) -> Rollout:
    """Everyone acts at random, as the seed decides."""
    return play(env, RandomActions(), seed)


def random_actions(env: TaskEnv, seed: int) -> Iterator[Actions]:
    """An episode's actions, drawn uniformly from the action spaces."""
    policy = RandomActions()
    policy.reset(env, seed)
    for _ in range(env.episode.horizon):
        yield policy.act({})


class DropAll(HoldStill):
    """All grippers open, and nobody moves any more."""

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin with the opening."""
        super().reset(env, seed)
        encoder = ActionEncoder(env)
        openings = dict.fromkeys(env.possible_agents, 1.0)
        self._first: Actions | None = encoder.actions(openings=openings)

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """Open, then hold."""
        first, self._first = self._first, None
        return super().act(observations) if first is None else first


class ThrowAll(HoldStill):
    """All arms swing sideways at full speed and open their grippers half-way; then they hold."""

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
        openings = dict.fromkeys(agents, 1.0) if step >= SWING_STEPS // 2 else {}
        return ActionEncoder(self._env).actions(joints, openings)


def _swung(env: TaskEnv, agent: str) -> list[float]:
    """An arm's commanded joints with the first one as far on as a control step takes it."""
    arm = env.episode.actions[agent].arm
    first, *rest = arm.robot.commanded()
    return [min(first + arm.longest[0], arm.ik.upper[0]), *rest]
