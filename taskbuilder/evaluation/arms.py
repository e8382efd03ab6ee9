"""Playing the episodes of a trial: the evaluated policy and its baselines."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from functools import lru_cache, partial
from secrets import token_hex
from typing import NamedTuple

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.baselines import EXPERT, NOTHING, RANDOM, Baseline, BaselineKind
from taskbuilder.expert.leaving import stall_after_stages
from taskbuilder.expert.script.player import has_expert
from taskbuilder.jobs import Map
from taskbuilder.policies.grammar import Player, Word, player_of
from taskbuilder.rollout.play import Policy, play
from taskbuilder.rollout.record import Rollout

SUBJECT = Baseline(BaselineKind.POLICY)
"""The arm of the evaluated policy."""

BASELINES: Mapping[Baseline, Word] = {
    EXPERT: Word("expert", "expert"),
    RANDOM: Word("random", "random"),
    NOTHING: Word("hold", "hold"),
}
"""The arms of the baselines, other than stalling, and who plays them."""

Episodes = dict[Baseline, Rollout]
"""The episodes from one seed, by arm."""


@dataclass(frozen=True, eq=False)
class TrialConfig:
    """The players and environments of a trial, picklable for other processes.

    Attributes:
        player: Who is evaluated.
        make_env: Makes the environment of the policy; it takes further options.
        make_control_env: Makes the environment of the baselines.
        any_grasp: Whether grippers may hold objects by another rule than in training.
        forces: Whether forces between robots are measured.
        token: Identifies the config in processes that receive it more than once.
    """

    player: Player
    make_env: Callable[..., TaskEnv]
    make_control_env: Callable[..., TaskEnv]
    any_grasp: bool = False
    forces: bool = True
    token: str = field(default_factory=lambda: token_hex(8))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TrialConfig) and self.token == other.token

    def __hash__(self) -> int:
        return hash(self.token)


class Job(NamedTuple):
    """An episode to play.

    Attributes:
        seed: Seed passed to `reset`.
        compared: Whether the baselines play too.
    """

    seed: int
    compared: bool


class TrialPlayer:
    """Plays the episodes of a trial in this process, and reuses environments and experts."""

    def __init__(self, config: TrialConfig) -> None:
        self._config = config
        self._stack = ExitStack()
        self._env = self._stack.enter_context(closing(config.make_env()))
        grasp = config.any_grasp
        self._policy = config.player.prepare(self._env, self._stack, any_grasp=grasp)
        self._envs: dict[int, TaskEnv] = {}
        self._policies: dict[tuple[Baseline, int], Policy] = {}

    def close(self) -> None:
        """Close all environments."""
        self._stack.close()

    def play(self, job: Job) -> Episodes:
        """Play the arms of a job from its seed."""
        forces = self._config.forces
        subject = play(self._env, self._policy, job.seed, forces=forces, explain=True)
        if self._config.player.kind == "own" and self._env.agents:
            raise UsageError(
                f"{self._config.player.name} returned None after {subject.steps} of "
                f"{subject.horizon} control steps; an evaluation plays whole episodes, so return "
                "the actions of all agents at each step"
            )
        episodes = {SUBJECT: subject}
        if not job.compared:
            return episodes
        variation = subject.variation
        env = self._control_env(variation)
        for baseline, word in BASELINES.items():
            if baseline == EXPERT and not has_expert(env.task):
                continue
            if self._config.player.kind == word.kind:  # it has been played
                episodes[baseline] = subject
                continue
            policy = self._control(baseline, variation)
            episodes[baseline] = play(env, policy, job.seed, forces=True, explain=True)
        if EXPERT in episodes:
            episodes |= stall_after_stages(env, episodes[EXPERT])
        return episodes

    def _control_env(self, variation: int) -> TaskEnv:
        if variation not in self._envs:
            made = self._config.make_control_env(variation=variation)
            self._envs[variation] = self._stack.enter_context(closing(made))
        return self._envs[variation]

    def _control(self, baseline: Baseline, variation: int) -> Policy:
        key = (baseline, variation)
        if key not in self._policies:
            env = self._control_env(variation)
            self._policies[key] = player_of(BASELINES[baseline]).prepare(env, self._stack)
        return self._policies[key]


def play_all(
    config: TrialConfig, jobs: Iterable[Job], spread: Map = map
) -> Generator[Episodes, None, None]:
    """Play episodes, and yield them in order.

    Args:
        config: The players and environments.
        jobs: The episodes to play.
        spread: A `map`, perhaps over several processes.
    """
    if spread is not map:
        yield from spread(partial(_play_elsewhere, config), jobs)
        return
    with closing(TrialPlayer(config)) as player:
        yield from map(player.play, jobs)


def _play_elsewhere(config: TrialConfig, job: Job) -> Episodes:
    return _player_made_once(config).play(job)


@lru_cache(maxsize=1)
def _player_made_once(config: TrialConfig) -> TrialPlayer:
    """A player that is cached for the lifetime of the process."""
    return TrialPlayer(config)


def jobs_of(seeds: Iterable[int], compared: int) -> list[Job]:
    """The episodes of a trial.

    Args:
        seeds: All seeds.
        compared: Number of first seeds that the baselines play too.
    """
    return [Job(seed, number < compared) for number, seed in enumerate(seeds)]


def by_arm(played: Iterable[Episodes]) -> Mapping[Baseline, tuple[Rollout, ...]]:
    """The episodes of each arm, in order."""
    arms: dict[Baseline, list[Rollout]] = {}
    for episodes in played:
        for baseline, rollout in episodes.items():
            arms.setdefault(baseline, []).append(rollout)
    return {baseline: tuple(rollouts) for baseline, rollouts in arms.items()}
