"""Evaluating policies in episodes that they have never seen.

Episodes begin in the task's own initial states, and actions have no exploration noise. The seeds
are separate from those of demonstrations and of the evaluations that policies are chosen by (see
`demonstrations` and `checkpoint_evaluator`). Training draws its seeds at random from 31 bits.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache, partial
from statistics import fmean, median
from typing import Any

import numpy as np
from gymnasium import spaces

from taskbuilder.env.options import from_json, option_infos, options_about
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError
from taskbuilder.intervals import wilson
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.statistics import iqm
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import looks_like_path
from taskbuilder.schema.grasping import rules_of
from taskbuilder.schema.other_robots import other_robots

SEED = 2_000_000
"""First seed of held-out evaluations: no policy is chosen by these episodes."""

EPISODES = 300
"""Default number of episodes of an evaluation."""

Spread = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""A `map`, perhaps over several processes."""

OPTIONS = tuple(name for name, info in option_infos().items() if info.decides_policy)
"""Options of environments that a policy records, because it depends on them."""


@dataclass(frozen=True)
class EvaluationSummary:
    """The results of an evaluation.

    Attributes:
        episodes: Number of episodes.
        successes: Number of episodes in which success held at some step.
        interval: 95 % Wilson interval of the success rate.
        mean_return: Mean team return.
        iqm_return: Interquartile mean of the team return.
        steps_to_success: Median over the successful episodes, or None if there are none.
        successes_at_end: Number of successful episodes in which success held at the last step.
        interval_at_end: 95 % Wilson interval of the success rate at the end.
        success_held_s: Mean and median time for which success held in the successful episodes, in
            seconds, or None if there are none.
        peak_robot_force: Median and maximum over the episodes of the largest force between two
            robots, in newtons, or None if it was not measured.
        stages: Number of episodes by the last stage reached, none (0) first.
        terms: Mean sum of every reward term, by label.
        best: Seed of the best episode: success first, then the highest return.
        median: Seed of the median episode in this order.
        failed: Seed of the median unsuccessful episode, or None.
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
        """Fraction of the episodes in which success held at some step."""
        return self.successes / self.episodes

    @property
    def success_at_end_rate(self) -> float:
        """Fraction of the episodes that succeeded and in which success held at the end."""
        return self.successes_at_end / self.episodes


def evaluate(
    make_env: Callable[[], TaskEnv],
    policy: TrainedPolicy,
    seeds: Iterable[int],
    spread: Spread | None = None,
) -> Generator[Rollout, None, None]:
    """Play episodes of a policy, and yield them in the order of their seeds.

    Forces between robots are measured. Each episode without success at its end has the reason.

    Args:
        make_env: Makes the environment, with the policy's options. For several processes it must
            be picklable, and equal to its unpickled copy.
        policy: The policy, which must fit the environment; see `check_fits`.
        seeds: Seeds of the episodes.
        spread: A `map` over several processes; by default episodes are played in this process.
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
    return play(env, policy.player(), seed, forces=True, explain=True)


@lru_cache(maxsize=1)
def _made_once(make_env: Callable[[], TaskEnv]) -> TaskEnv:
    """An environment that is cached for the lifetime of the process."""
    return make_env()


def summarise(played: Sequence[Rollout], stages: int) -> EvaluationSummary:
    """Summarise episodes.

    Args:
        played: At least one episode.
        stages: Number of stages of the task.
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
    """The options of the environment that a policy was trained in, without its start states.

    Raises:
        UsageError: The policy does not record them.
    """
    options = policy.about.get("env")
    if not isinstance(options, Mapping):
        raise UsageError("the policy does not say what its environment was; train it anew")
    return env_options(options)


def env_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options of an environment that a policy depends on, from a file's JSON."""
    return {name: value for name, value in from_json(options).items() if name in OPTIONS}


def options_for(policy: TrainedPolicy, asked: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The options of the environment in which a policy plays.

    Args:
        policy: The policy.
        asked: Options that are asked for.
        name: Name of the policy, for messages.

    Raises:
        UsageError: With one of them, the policy would observe or act otherwise than in training.
    """
    trained = options_of(policy)
    for robot, model in () if "robots" in asked else other_robots(trained.get("robots", ())):
        if looks_like_path(model):  # of the machine that reads it, and a policy may be anybody's
            raise UsageError(
                f"{name} was trained with a robot of a file; name the file: --robot {robot}=FILE"
            )
    for option in options_about("observed"):
        free = option_infos()[option].disturbs or option not in trained
        if not free and asked.get(option, trained[option]) != trained[option]:
            raise UsageError(
                f"{name} was trained with {option} {trained[option]}, and plays with no other; "
                f"it is asked for {option} {asked[option]}"
            )
    return {**trained, **asked}


def check_fits(
    policy: TrainedPolicy, env: TaskEnv, name: str = "the policy", *, any_grasp: bool = False
) -> None:
    """Check that a policy fits an environment.

    Args:
        policy: The policy.
        env: The environment, with the policy's options.
        name: Name of the policy, for messages.
        any_grasp: Whether grippers may hold objects by another rule than in training.

    Raises:
        UsageError: It was trained on another task, for other agents, with spaces of other sizes, or
            with another rule of grasping.
    """
    task, trained = env.task.name, policy.about.get("task")
    if trained != task:
        raise UsageError(f"{name} was trained on {trained}, not on {task}")
    if set(policy.networks) != set(env.possible_agents):
        theirs, ours = ", ".join(policy.networks), ", ".join(env.possible_agents)
        raise UsageError(f"{name} plays {theirs}, and {task} as it is now has {ours}; train anew")
    if not any_grasp:
        _check_grasp(policy, env, name)
    policy.check_env(env, name)
    for agent in policy.networks:
        had, has = _sizes(policy, agent, name), _numbers(env, agent)
        for does, size, needed in zip(("sees", "acts by"), had, has, strict=True):
            if size != needed:
                now = f"in {task} as it is now {needed}"
                raise UsageError(f"{name}: {agent} {does} {size} numbers, {now}; train it anew")


def _check_grasp(policy: TrainedPolicy, env: TaskEnv, name: str) -> None:
    """Check that grippers hold objects by the rules of training; early policies state none."""
    world = env.episode.world
    now = rules_of(world.scene, world.task.robots)
    trained = policy.about.get("grasp_rules", {})
    for agent, rule in now.items():
        if (was := trained.get(agent, "friction")) != rule:
            raise UsageError(
                f"{name} was trained with grasp {was}, and {agent} holds objects by {rule} here; "
                f"to play it all the same, ask for it: --grasp {rule}, or grasp={rule!r}"
            )


def _sizes(policy: TrainedPolicy, agent: str, name: str) -> tuple[int, int]:
    """How many numbers a policy takes for an agent, and how many it gives."""
    try:
        return policy.sizes(agent)
    except (ValueError, TypeError, IndexError):
        raise UsageError(f"{name} is damaged: its layers do not fit each other") from None


def _numbers(env: TaskEnv, agent: str) -> tuple[int, int]:
    """The sizes of an agent's observation and action."""
    observed = env.observation_space(agent)
    if isinstance(observed, spaces.Dict) and VECTOR in observed.spaces:
        observed = observed[VECTOR]
    shapes = observed.shape, env.action_space(agent).shape
    seen, said = (shape[0] if shape else 0 for shape in shapes)
    return seen, said
