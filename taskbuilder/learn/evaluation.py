"""Evaluation: what a policy achieves in episodes that it has never seen.

Episodes begin where the task begins them, whatever training began with, and nothing is explored.
Their seeds are apart from those of the expert's episodes and of the evaluations by which policies
are chosen (see `expertise` and `judging`); training draws its own at random from 31 bits.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache, partial
from statistics import fmean, median
from typing import Any

import numpy as np

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.intervals import wilson
from taskbuilder.learn.policy import Network, TrainedPolicy
from taskbuilder.learn.statistics import iqm
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout

SEED = 2_000_000
"""First of the episodes that nothing was chosen by."""

EPISODES = 300
"""That a claim takes."""

Spread = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""A `map`, perhaps over several processes."""

_OPTIONS = ("observe", "frame", "rotation", "variation")


@dataclass(frozen=True)
class EvaluationSummary:
    """What episodes say together.

    Attributes:
        episodes: How many there were.
        successes: In how many success held at some step.
        interval: Of the success rate: Wilson's, 95 %.
        mean_return: Of the team.
        iqm_return: Interquartile mean of the same.
        steps_to_success: Median of the successful ones, or None if there are none.
        successes_at_end: In how many success was reached and held after the last control step.
        interval_at_end: Of the share of those: Wilson's, 95 %.
        success_held_s: Mean and median of how long success held in the successful ones, in
            seconds, or None if there are none.
        peak_robot_force: Median and maximum over the episodes of the largest force between two
            robots, in newtons, or None if it was not metered.
        stages: Episodes by the number of their furthest stage, none (0) first.
        terms: Mean sum of every reward term, by label.
        best: Seed of the best episode: the highest return, success before failure.
        median: Seed of the one in the middle of that order.
        failed: Seed of the one in the middle of those that failed, or None.
    """

    episodes: int
    successes: int
    interval: tuple[float, float]
    mean_return: float
    iqm_return: float
    steps_to_success: float | None
    successes_at_end: int
    interval_at_end: tuple[float, float]
    success_held_s: tuple[float, float] | None
    peak_robot_force: tuple[float, float] | None
    stages: tuple[int, ...]
    terms: Mapping[str, float]
    best: int
    median: int
    failed: int | None

    @property
    def success_rate(self) -> float:
        """Share of the episodes in which success held at some step."""
        return self.successes / self.episodes

    @property
    def success_at_end_rate(self) -> float:
        """Share of the episodes in which success was reached and held at the end."""
        return self.successes_at_end / self.episodes


def evaluate(
    make_env: Callable[[], TaskEnv],
    policy: TrainedPolicy,
    seeds: Iterable[int],
    spread: Spread | None = None,
) -> Generator[Rollout, None, None]:
    """Play episodes, each as soon as it can be, in the order of their seeds.

    Forces between robots are metered, and where success does not hold at the end it is said why.

    Args:
        make_env: Makes the environment, with the policy's options. To be told other processes it
            must be picklable, and equal to what it is unpickled to.
        policy: Who plays; `check_fits` says whether it can.
        seeds: Of the episodes.
        spread: A `map` over several processes; without it they are played in this one.
    """
    if spread is not None:
        yield from spread(partial(_play_elsewhere, make_env, policy), seeds)
        return
    with closing(make_env()) as env:
        for seed in seeds:
            yield _played(env, policy, seed)


def _play_elsewhere(make_env: Callable[[], TaskEnv], policy: TrainedPolicy, seed: int) -> Rollout:
    return _played(_made_once(make_env), policy, seed)


def _played(env: TaskEnv, policy: TrainedPolicy, seed: int) -> Rollout:
    return play(env, policy.act, seed, forces=True, explain=True)


@lru_cache(maxsize=1)
def _made_once(make_env: Callable[[], TaskEnv]) -> TaskEnv:
    """An environment that is kept for as long as its process lives."""
    return make_env()


def summarise(played: Sequence[Rollout], stages: int) -> EvaluationSummary:
    """What episodes say together.

    Args:
        played: At least one.
        stages: How many stages the task has.
    """
    returns = [episode.team_return for episode in played]
    to_success = [e.first_success for e in played if e.first_success is not None]
    at_end = sum(episode.success_at_end for episode in played)
    held = [episode.success_held_s for episode in played if episode.success]
    peaks = [e.peak_robot_force for e in played if e.peak_robot_force is not None]
    order = sorted(played, key=_merit)
    failed = [episode.seed for episode in order if not episode.success]
    furthest = np.bincount([episode.stage[-1] for episode in played], minlength=stages + 1)
    terms = [episode.term_returns for episode in played]
    return EvaluationSummary(
        episodes=len(played),
        successes=len(to_success),
        interval=wilson(len(to_success), len(played)),
        mean_return=fmean(returns),
        iqm_return=float(iqm(returns)),
        steps_to_success=median(to_success) if to_success else None,
        successes_at_end=at_end,
        interval_at_end=wilson(at_end, len(played)),
        success_held_s=(fmean(held), median(held)) if held else None,
        peak_robot_force=(median(peaks), max(peaks)) if peaks else None,
        stages=tuple(furthest.tolist()),
        terms={label: fmean(each[label] for each in terms) for label in terms[0]},
        best=order[-1].seed,
        median=order[len(order) // 2].seed,
        failed=failed[len(failed) // 2] if failed else None,
    )


def _merit(episode: Rollout) -> tuple[bool, float, int]:
    return episode.success, episode.team_return, -episode.seed


def options_of(policy: TrainedPolicy) -> dict[str, Any]:
    """The options of the environment that a policy was trained in, its starts left out.

    Raises:
        UsageError: The policy does not say them.
    """
    options = policy.about.get("env")
    if not isinstance(options, Mapping):
        raise UsageError("the policy does not say what its environment was; train it anew")
    return {name: options[name] for name in _OPTIONS if name in options}


def check_fits(policy: TrainedPolicy, env: TaskEnv, name: str = "the policy") -> None:
    """Refuse a policy of another task, or of the task as it was.

    Args:
        policy: The policy.
        env: Where it is to play, with the policy's options.
        name: What the policy is called.

    Raises:
        UsageError: It was trained on another task, for other agents, or with spaces of other
            sizes.
    """
    task, trained = env.task.name, policy.about.get("task")
    if trained != task:
        raise UsageError(f"{name} was trained on {trained}, not on {task}")
    if set(policy.networks) != set(env.possible_agents):
        theirs, ours = ", ".join(policy.networks), ", ".join(env.possible_agents)
        raise UsageError(f"{name} plays {theirs}, and {task} as it is now has {ours}; train anew")
    for agent, network in policy.networks.items():
        had, has = _sizes(network, name), _numbers(env, agent)
        for does, size, needed in zip(("sees", "acts by"), had, has, strict=True):
            if size != needed:
                now = f"in {task} as it is now {needed}"
                raise UsageError(f"{name}: {agent} {does} {size} numbers, {now}; train it anew")


def _sizes(network: Network, name: str) -> tuple[int, int]:
    """How many numbers a network takes and gives."""
    try:
        takes = len(network.layers[0][0])
        (gives,) = network(np.zeros(takes)).shape
    except (ValueError, TypeError, IndexError):
        raise UsageError(f"{name} is damaged: its layers do not fit each other") from None
    return takes, gives


def _numbers(env: TaskEnv, agent: str) -> tuple[int, int]:
    """How many numbers an agent sees and acts by."""
    shapes = env.observation_space(agent).shape, env.action_space(agent).shape
    seen, said = (shape[0] if shape else 0 for shape in shapes)
    return seen, said
