"""Playing the episodes of a trial: the evaluated policy and its baselines."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from functools import lru_cache, partial
from secrets import token_hex
from typing import Any, NamedTuple

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.leaving import stall_after_stages
from taskbuilder.expert.named import has_expert, policy_named
from taskbuilder.expert.script.player import Expert
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.rollout.play import Policy, as_policy, play
from taskbuilder.rollout.record import Rollout

SUBJECT = "policy"
"""The arm of the evaluated policy."""

EXPERT, RANDOM, NOTHING = "expert", "random", "nothing"
CONTROLS = (EXPERT, RANDOM, NOTHING)
"""The arms of the baselines, other than stalling."""

STALL = "stall after stage "
"""Prefix of the arms that play the expert up to a stage and then hold still."""

Episodes = dict[str, Rollout]
"""The episodes from one seed, by arm."""

Spread = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""A `map`, perhaps over several processes."""


@dataclass(frozen=True, eq=False)
class Arena:
    """The players and environments of a trial, picklable for other processes.

    Attributes:
        player: A trained policy, or the name of another policy.
        place: Makes the environment of the policy; it takes further options.
        controls: Makes the environment of the baselines.
        token: Identifies the arena in processes that receive it more than once.
    """

    player: TrainedPolicy | str
    place: Callable[..., TaskEnv]
    controls: Callable[..., TaskEnv]
    token: str = field(default_factory=lambda: token_hex(8))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Arena) and self.token == other.token

    def __hash__(self) -> int:
        return hash(self.token)


class Job(NamedTuple):
    """An episode to play.

    Attributes:
        seed: Seed of the reset.
        compared: Whether the baselines play too.
    """

    seed: int
    compared: bool


class Stage:
    """Plays the episodes of an arena in this process, and reuses environments and experts."""

    def __init__(self, arena: Arena) -> None:
        self._arena = arena
        self._stack = ExitStack()
        self._env = self._stack.enter_context(closing(arena.place()))
        self._policy = self._hire(arena.player, self._env)
        self._envs: dict[int, TaskEnv] = {}
        self._hired: dict[tuple[str, int], Policy] = {}

    def close(self) -> None:
        """Close all environments."""
        self._stack.close()

    def play(self, job: Job) -> Episodes:
        """Play the arms of a job from its seed."""
        subject = play(self._env, self._policy, job.seed, forces=True, explain=True)
        episodes = {SUBJECT: subject}
        if not job.compared:
            return episodes
        variation = subject.variation
        env = self._control_env(variation)
        for name in CONTROLS:
            if name == EXPERT and not has_expert(env.task):
                continue
            if name == self._arena.player:  # already played
                episodes[name] = subject
                continue
            policy = self._control(name, variation)
            episodes[name] = play(env, policy, job.seed, forces=True, explain=True)
        if EXPERT in episodes:
            stalls = stall_after_stages(env, episodes[EXPERT])
            episodes |= {f"{STALL}{number}": played for number, played in stalls.items()}
        return episodes

    def _control_env(self, variation: int) -> TaskEnv:
        if variation not in self._envs:
            made = self._arena.controls(variation=variation)
            self._envs[variation] = self._stack.enter_context(closing(made))
        return self._envs[variation]

    def _control(self, name: str, variation: int) -> Policy:
        key = (name, variation)
        if key not in self._hired:
            self._hired[key] = self._hire(name, self._control_env(variation))
        return self._hired[key]

    def _hire(self, player: TrainedPolicy | str, env: TaskEnv) -> Policy:
        if not isinstance(player, str):
            return as_policy(player.act)
        made = policy_named(player)(env)
        if isinstance(made, Expert):
            self._stack.callback(made.close)
        return made


def play_all(
    arena: Arena, jobs: Iterable[Job], spread: Spread | None = None
) -> Generator[Episodes, None, None]:
    """Play episodes, and yield them in order.

    Args:
        arena: The players and environments.
        jobs: The episodes to play.
        spread: A `map` over several processes; by default episodes are played in this process.
    """
    if spread is not None:
        yield from spread(partial(_play_elsewhere, arena), jobs)
        return
    with closing(Stage(arena)) as stage:
        yield from map(stage.play, jobs)


def _play_elsewhere(arena: Arena, job: Job) -> Episodes:
    return _opened_once(arena).play(job)


@lru_cache(maxsize=1)
def _opened_once(arena: Arena) -> Stage:
    """A stage that is cached for the lifetime of the process."""
    return Stage(arena)


def jobs_of(seeds: Iterable[int], compared: int) -> list[Job]:
    """The episodes of a trial.

    Args:
        seeds: All seeds.
        compared: Number of first seeds that the baselines play too.
    """
    return [Job(seed, number < compared) for number, seed in enumerate(seeds)]


def by_arm(played: Iterable[Episodes]) -> Mapping[str, tuple[Rollout, ...]]:
    """The episodes of each arm, in order."""
    arms: dict[str, list[Rollout]] = {}
    for episodes in played:
        for name, rollout in episodes.items():
            arms.setdefault(name, []).append(rollout)
    return {name: tuple(rollouts) for name, rollouts in arms.items()}
