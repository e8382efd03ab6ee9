"""Episodes recorded for the page: where every link is, and how the task stands, at every step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.node import Condition
from taskbuilder.description.reasons import EvaluatedState, label, reasons
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.rollout.play import Policy, play
from taskbuilder.rollout.record import Rollout
from taskbuilder.view.contacts import Contacts, contacts_of
from taskbuilder.world.visible import LinkPoses

MOST_FIGURES = 3
"""Of a condition that holds, at most this many parts are shown."""


class ConditionState(NamedTuple):
    """A named condition at one step.

    Attributes:
        name: Its name in the description.
        on: Whether it holds.
        figure: What was measured and what is needed, such as ``Near(stick, goal): 7.3 cm, within 5
            cm is needed``; "" where there is nothing to say.
    """

    name: str
    on: bool
    figure: str


class RecordedState(NamedTuple):
    """The state of an episode after a reset or a control step.

    Attributes:
        poses: (l, 7) of all links; see `LinkPoses.now`.
        lamps: The named conditions.
        contacts: What touches what.
    """

    poses: NDArray[np.float32]
    lamps: tuple[ConditionState, ...]
    contacts: Contacts


@dataclass(frozen=True)
class Recording:
    """An episode, to be played, paused and scrubbed.

    Attributes:
        player: Who played, as it was asked for.
        rollout: The record of the episode.
        moments: The state after the reset and after each control step.
        instruction: What the robots were told.
    """

    player: str
    rollout: Rollout
    moments: tuple[RecordedState, ...]
    instruction: str

    @property
    def control_hz(self) -> int:
        """Control steps per second."""
        return self.rollout.control_hz

    def verdict(self) -> str:
        """How the episode ended, and if it failed, why."""
        rollout = self.rollout
        if rollout.success:
            return f"success after {rollout.first_success} of {rollout.horizon} control steps"
        if rollout.trouble is not None:
            trouble = rollout.trouble
            return f"failed in stage {trouble.stage} ({trouble.order}): {trouble.message}"
        why = "; ".join(str(reason) for reason in rollout.why)
        return f"no success: {why}" if why else "no success"


class EpisodeRecorder:
    """Notes the state of an episode; called after the reset and after each control step.

    Args:
        shown: Called with each new state while the episode is played.
    """

    def __init__(self, shown: Callable[[RecordedState], None]) -> None:
        self.moments: list[RecordedState] = []
        self._shown = shown
        self._history: list[Sequence[Any]] = []
        self._poses: LinkPoses | None = None

    def __call__(self, env: TaskEnv) -> None:
        """Note the current state of an environment."""
        if env.episode.exploded:
            moment = self.moments[-1]
        else:
            self._poses = self._poses or LinkPoses(env.episode.world)
            self._history.append(env.episode.referee.values)
            moment = RecordedState(
                self._poses.now(), lamps(env, self._history), contacts_of(env.episode.world)
            )
        self.moments.append(moment)
        self._shown(moment)


def lamps(env: TaskEnv, history: Sequence[Sequence[Any]]) -> tuple[ConditionState, ...]:
    """The named conditions of a task as they stand, each with what decides it; stages are not.

    Args:
        env: The environment.
        history: The referee's values after the reset and after every control step so far.
    """
    episode, description = env.episode, env.task.description
    evaluated = episode.referee.moment(episode.world, history)
    named = description.conditions().items()
    return tuple(
        ConditionState(name, bool(evaluated.value(condition)), _figure(condition, evaluated, name))
        for name, condition in named
        if name not in description.stages
    )


def _figure(condition: Condition, evaluated: EvaluatedState, name: str) -> str:
    """What decides a condition: what is missing, or what makes it hold."""
    if not evaluated.value(condition):
        missing = reasons(condition, evaluated, wanted=True, of=name)
        return "; ".join(f"{reason.part}: {reason.says}" for reason in missing)
    held = (leaf for leaf in dict.fromkeys(_leaves(condition)) if evaluated.value(leaf))
    return "; ".join(_held(leaf, evaluated) for leaf in islice(held, MOST_FIGURES))


def _held(leaf: Condition, evaluated: EvaluatedState) -> str:
    """A condition that holds, with its figure and bound, or with what makes it hold."""
    world, memory = evaluated.world, evaluated.memory(leaf)
    figure = leaf.figure(world, memory, wanted=True) or leaf.figure(world, memory, wanted=False)
    return f"{label(leaf)}: {figure}"


def _leaves(condition: Condition) -> Iterator[Condition]:
    """The conditions that a condition is made of, which are made of no others themselves."""
    parts = [part for part in condition.parts if isinstance(part, Condition)]
    if not parts:
        yield condition
    for part in parts:
        yield from _leaves(part)


def record(
    env: TaskEnv,
    player: str,
    policy: Policy,
    seed: int,
    shown: Callable[[RecordedState], None] = lambda _: None,
) -> Recording:
    """Play an episode and record it.

    Args:
        env: The environment.
        player: Who plays, for people.
        policy: The policy that plays.
        seed: Seed of the episode.
        shown: Called with each state as soon as it is reached.
    """
    recorder = EpisodeRecorder(shown)
    rollout = play(
        env, policy, seed, forces=len(env.possible_agents) > 1, explain=True, watch=recorder
    )
    return Recording(player, rollout, tuple(recorder.moments), env.task_description)
