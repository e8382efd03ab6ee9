"""Progress, its pauses and setback, which only training uses, in the expert's successful episodes.

Progress must be highest at success: otherwise a learner that is rewarded for progress gains nothing
by the last step to success, or loses by it. Training ends episodes in which the progress has not
risen for some time, which it measures on a few of the expert's; this must not end others of its
episodes. No setback may hold: it ends training episodes, too, so a learner would be penalised for
doing the task as the expert does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.logic import Never
from taskbuilder.errors import Finding
from taskbuilder.expert.ladder.ladder import stage_ladder_along
from taskbuilder.rollout.progress import (
    EPISODES,
    longest_wait,
    measured_range,
    timeout_for,
    written_range,
)
from taskbuilder.rollout.record import Rollout
from taskbuilder.task import Task
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import EnvCache, Start
from taskbuilder.validate.locate import finding_in_description
from taskbuilder.validate.report import Check, Result

ROUNDING = 1e-9
"""Difference between two values of progress that counts as none."""


def check_training_signals(context: Context) -> Iterator[Result]:
    """Check the progress and the setback of a description, if it has them."""
    succeeded = {start: demo for start, demo in context.demonstrations.items() if demo.success}
    if not succeeded:
        return
    if context.task.description.progress is not None:
        yield _check_progress(context, succeeded)
    yield _check_waits(context, succeeded)
    if not isinstance(context.task.description.setback, Never):
        yield _check_setback(context, succeeded)


class _Fall(NamedTuple):
    """By how much progress is lower at success than before, in an episode."""

    start: Start
    step: int
    highest: float
    at_success: float
    success: int

    @property
    def size(self) -> float:
        """How much lower; not a number where progress is none."""
        return self.highest - self.at_success


def _fall(start: Start, demo: Rollout) -> _Fall:
    success = demo.first_success or 0
    before = demo.progress[: success + 1]
    step = int(np.argmax(before))
    return _Fall(start, step, float(before[step]), float(before[-1]), success)


def _check_progress(context: Context, succeeded: Mapping[Start, Rollout]) -> Result:
    """Progress is nowhere higher than at success."""
    falls = [_fall(start, demo) for start, demo in succeeded.items()]
    wrong = [fall for fall in falls if not fall.size <= ROUNDING]
    findings = []
    if wrong:
        first = wrong[0]
        message = (
            f"{first.highest:.3g} at control step {first.step}, and only {first.at_success:.3g} "
            f"at step {first.success}, which reaches success ({first.start}); it must be highest "
            "at success"
        )
        progress = context.task.description.progress
        findings = [finding_in_description(context.task, "TB556", message, "progress", progress)]
    name = "progress is highest at success"
    value = wrong[0].size if wrong else 0.0
    return Check("TB556", name, not wrong, value, 0.0, "lower"), findings


class _Wait(NamedTuple):
    """The longest time without progress in an episode, and what training would allow."""

    start: Start
    seconds: float
    step: int
    timeout_s: float


def _check_waits(context: Context, succeeded: Mapping[Start, Rollout]) -> Result:
    """Training does not end an episode of the expert by what it measures on others of them."""
    found = list(_waits(context, succeeded))
    cut = [wait for wait in found if wait.seconds >= wait.timeout_s]
    findings = []
    if cut:
        first = max(cut, key=lambda wait: wait.seconds)
        message = (
            f"the expert makes no progress for {first.seconds:.3g} s until control step "
            f"{first.step} ({first.start}); in other episodes it waits for so little that training "
            f"would end this one after {first.timeout_s:.3g} s without progress. Let the progress "
            "rise during this time, or let the expert wait alike in every episode"
        )
        findings = [_finding_of_progress(context.task, "TB558", message)]
    name = "the expert waits alike in its episodes"
    return Check("TB558", name, not cut, len(cut), 0, "episodes"), findings


def _waits(context: Context, succeeded: Mapping[Start, Rollout]) -> Iterator[_Wait]:
    """Each episode's longest wait, beside those of the next ones of its variation."""
    along = _progress_along(context, succeeded)
    paused = {start: longest_wait(demo, along[start]) for start, demo in succeeded.items()}
    for variation in range(context.variations):
        starts = [start for start in succeeded if start.variation == variation]
        for index, start in enumerate(starts):
            others = [*starts[index + 1 :], *starts[:index]][:EPISODES]
            if others:
                limit = timeout_for(succeeded[o].seconds(paused[o].steps) for o in others)
                mine = paused[start]
                yield _Wait(start, succeeded[start].seconds(mine.steps), mine.until, limit)


def _progress_along(
    context: Context, succeeded: Mapping[Start, Rollout]
) -> Mapping[Start, NDArray[np.float64]]:
    """The progress that training sees, from 0 to 1, along each episode."""
    written = context.task.description.progress
    if written is not None:
        scale = written_range(written) or measured_range(succeeded.values())
        return {s: scale.shares(d) if scale else 0.0 * d.progress for s, d in succeeded.items()}
    read = context.ask(_ladder, list(succeeded), "ladder", about=list(succeeded.items()))
    return dict(zip(succeeded, read, strict=True))


def _ladder(cache: EnvCache, played: tuple[Start, Rollout]) -> NDArray[np.float64]:
    start, demo = played
    return stage_ladder_along(cache.env(start.variation), demo)


def _finding_of_progress(task: Task, code: str, message: str) -> Finding:
    """A finding at the progress of a description, or at the expert where it has none."""
    progress = task.description.progress
    if progress is not None:
        return finding_in_description(task, code, message, "progress", progress)
    location = task.file.source.locate(("expert",), key=True)
    return Finding(code, message, "expert", location)


def _check_setback(context: Context, succeeded: Mapping[Start, Rollout]) -> Result:
    """No setback holds in an episode in which the expert succeeds."""
    held = [start for start, demo in succeeded.items() if demo.conditions["setback"].any()]
    findings = []
    if held:
        first = held[0]
        step = int(np.argmax(succeeded[first].conditions["setback"]))
        message = (
            f"holds at control step {step} although the expert succeeds ({first}), and in "
            f"{len(held)} of its {len(succeeded)} successful episodes; training would end there, "
            "with a penalty"
        )
        setback = context.task.description.setback
        findings = [finding_in_description(context.task, "TB557", message, "setback", setback)]
    name = "no setback where the expert succeeds"
    return Check("TB557", name, not held, len(held), 0, "episodes"), findings
