"""How long the expert goes without progress, so that no rule of training cuts it.

A training reward that ends episodes without progress would also end those of an expert that waits,
as in a handover. So the time is measured on episodes of the expert when a run is created.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from taskbuilder.expert.script.player import has_expert
from taskbuilder.learn.demonstrations import SEEDS_FROM, record
from taskbuilder.learn.run_setup import ExpertWaits, RunSetup
from taskbuilder.learn.training_rewards import TRAINING_REWARDS
from taskbuilder.learn.wrappers import ProgressCount
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue

EPISODES = 20
"""Episodes of the expert that are measured."""

MARGIN = 1.5
"""The time without progress after which training ends an episode, as a multiple of the longest
wait of the expert."""


def has_timeout(run: RunSetup) -> bool:
    """Whether a run ends training episodes without progress."""
    plan = run.plan
    default = TRAINING_REWARDS[plan.reward].no_progress_timeout_s
    return not plan.data and (default is not None or plan.no_progress_timeout_s is not None)


def with_timeout(
    run: RunSetup, recorded: Sequence[Rollout] = (), catalogue: Catalogue | None = None
) -> RunSetup:
    """A run whose plan says after which time without progress an episode ends.

    A time that is given stays. A reward that never ends episodes keeps that, too.

    Args:
        run: The run as it was planned.
        recorded: Its demonstrations of the expert, if it recorded any, from `SEEDS_FROM` on.
        catalogue: Where other processes look up the task.
    """
    if not has_timeout(run):
        return run
    plan = run.plan
    given = plan.no_progress_timeout_s
    default = TRAINING_REWARDS[plan.reward].no_progress_timeout_s
    waits: list[float] = []
    episodes = 0
    if has_expert(run.task):
        played = list(recorded[:EPISODES])
        if len(played) < EPISODES:
            played = list(_played(run, catalogue))
        episodes = len(played)
        waits = [longest_wait_s(episode) for episode in played if episode.success]
    measured = max([default or 0.0, *(round(MARGIN * wait, 3) for wait in waits)])
    timeout = measured if given is None else given
    plan = replace(plan, no_progress_timeout_s=timeout)
    return replace(run, plan=plan, waits=ExpertWaits(tuple(waits), episodes, timeout))


def _played(run: RunSetup, catalogue: Catalogue | None) -> Iterator[Rollout]:
    """Episodes of the expert in the variations of a run, which take turns if they are drawn."""
    plan = run.plan
    env: Mapping[str, Any] = plan.env
    variations: tuple[Any, ...] = (plan.options.variation,)
    if plan.options.variation == "random":
        variations = tuple(range(len(run.task.file.scenes)))
    share, rest = divmod(EPISODES, len(variations))
    for number, variation in enumerate(variations):
        if count := share + (number < rest):
            options = {**env, "variation": variation}
            yield from record(plan.task, count, options, first_seed=SEEDS_FROM, catalogue=catalogue)


def longest_wait_s(episode: Rollout) -> float:
    """The longest time without progress before an episode's success, in seconds."""
    count, longest = ProgressCount(float(episode.progress[0])), 0
    last = episode.steps if episode.first_success is None else episode.first_success
    for step in range(1, last + 1):
        held = bool(episode.conditions["success"][step])
        count = count.after(float(episode.progress[step]), success=held)
        longest = max(longest, count.steps)
    return episode.seconds(longest)
