"""Where the progress comes from that training sees, and what is mapped to 0 and to 1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.expert.ladder.ladder import stage_ladder_along
from taskbuilder.learn.plan import Plan
from taskbuilder.learn.training_rewards import reads_progress
from taskbuilder.rollout.progress import ProgressRange, measured_range, written_range
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task


def needs_progress(plan: Plan) -> bool:
    """Whether training goes by the progress: its reward, or the rule that ends episodes."""
    return not plan.data and (reads_progress(plan.reward) or plan.no_progress_timeout_s is not None)


def with_ladder(plan: Plan, task: Task) -> Plan:
    """A new plan that says where the progress comes from: the description, if it has any.

    Raises:
        UsageError: Nothing says how far an episode has come, or nothing asks for it.
    """
    if not needs_progress(plan):
        if plan.ladder is not None and not plan.data:
            raise UsageError(
                f"--reward {plan.reward} does not depend on progress; leave --ladder out, or "
                "choose --reward ratchet or shaped"
            )
        return plan
    written = task.description.progress is not None
    plan = replace(plan, ladder=plan.ladder or ("task" if written else "expert"))
    check_ladder(plan, task)
    return plan


def check_ladder(plan: Plan, task: Task) -> None:
    """Check that a task has the progress that a plan goes by.

    Raises:
        UsageError: It has not.
    """
    if not needs_progress(plan):
        return
    written, expert = task.description.progress is not None, bool(task.file.spec.expert)
    if expert if plan.ladder == "expert" else written:
        return
    if written or expert:
        lacking = "expert to make a ladder from" if written else "progress"
        advice = "leave --ladder out"
    else:
        lacking = "progress, and no expert to make a ladder from"
        advice = "leave --no-progress-timeout-s out"
        if reads_progress(plan.reward):
            advice = "write progress into its description, or choose --reward team"
    raise UsageError(f"{task.name} has no {lacking}; {advice}")


def range_of(task: Task, episodes: Sequence[Rollout]) -> ProgressRange:
    """The values of a description's progress that training maps to 0 and to 1.

    They are the least and the greatest value that its expression can have; where it does not say
    them, those in the episodes in which the expert succeeds.

    Raises:
        UsageError: Neither is known.
    """
    progress = task.description.progress
    range_ = written_range(progress) if progress is not None else None
    range_ = range_ or measured_range(episodes)
    if range_ is None:
        raise UsageError(
            f"the progress of {task.name} has no greatest value: its expression has measures "
            "without bounds, and no episode of the expert says what it comes to; put such measures "
            "into Fraction(..., of=...), or choose --ladder expert or --reward team"
        )
    return range_


class LadderReader:
    """Reads the progress, from 0 to 1, along recorded episodes.

    Args:
        task: The task.
        plan: The plan of a run, which says where the progress comes from.
        options: Options of the environments that the episodes were played in.
    """

    def __init__(self, task: Task, plan: Plan, options: Mapping[str, Any]) -> None:
        self._task, self._plan, self._options = task, plan, options

    def along(self, episodes: Sequence[Rollout]) -> Iterator[NDArray[np.float64]]:
        """The progress of each episode, after reset and after each control step."""
        if self._plan.ladder != "expert":
            range_ = self._plan.progress_range
            for episode in episodes:
                yield ProgressRange(*range_).shares(episode) if range_ else episode.progress
            return
        for episode in episodes:
            options = {**self._options, "variation": episode.variation}
            with closing(parallel_env(self._task, **options)) as env:
                yield stage_ladder_along(env, episode)
