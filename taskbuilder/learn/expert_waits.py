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
from taskbuilder.learn.ladders import LadderReader, range_of
from taskbuilder.learn.run_setup import ExpertWaits, RunSetup
from taskbuilder.learn.training_rewards import TRAINING_REWARDS
from taskbuilder.rollout.progress import EPISODES, longest_wait_s, timeout_for, written_range
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue


def has_timeout(run: RunSetup) -> bool:
    """Whether a run ends training episodes without progress."""
    plan = run.plan
    default = TRAINING_REWARDS[plan.reward].no_progress_timeout_s
    return not plan.data and (default is not None or plan.no_progress_timeout_s is not None)


def has_to_measure(run: RunSetup) -> bool:
    """Whether the expert has to play before a run begins: for how long it waits, or how high."""
    progress = run.task.description.progress if run.plan.ladder == "task" else None
    unbounded = progress is not None and written_range(progress) is None
    return (has_timeout(run) or unbounded) and has_expert(run.task)


def with_measures(
    run: RunSetup, recorded: Sequence[Rollout] = (), catalogue: Catalogue | None = None
) -> RunSetup:
    """A run whose plan has the range of progress, and the time without it that ends an episode.

    A time that is given stays. A reward that never ends episodes keeps that, too.

    Args:
        run: The run as it was planned.
        recorded: Its demonstrations of the expert, if it recorded any, from `SEEDS_FROM` on.
        catalogue: Where other processes look up the task.

    Raises:
        UsageError: It is not known what the greatest progress is.
    """
    played: list[Rollout] = []
    if has_to_measure(run):
        played = list(recorded[:EPISODES])
        if len(played) < EPISODES:
            played = list(_played(run, catalogue))
    if run.plan.ladder == "task":
        range_ = range_of(run.task, played)
        run = replace(run, plan=replace(run.plan, progress_range=range_))
    return _with_timeout(run, played) if has_timeout(run) else run


def _with_timeout(run: RunSetup, played: Sequence[Rollout]) -> RunSetup:
    """A run whose plan says after which time without progress an episode ends."""
    plan = run.plan
    given = plan.no_progress_timeout_s
    default = TRAINING_REWARDS[plan.reward].no_progress_timeout_s
    good = [episode for episode in played if episode.success]
    ladders = LadderReader(run.task, plan, plan.env).along(good)
    waits = [longest_wait_s(*pair) for pair in zip(good, ladders, strict=True)]
    measured = timeout_for(waits, default or 0.0)
    timeout = measured if given is None else given
    plan = replace(plan, no_progress_timeout_s=timeout)
    return replace(run, plan=plan, waits=ExpertWaits(tuple(waits), len(played), timeout))


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
