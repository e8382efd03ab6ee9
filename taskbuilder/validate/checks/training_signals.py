"""Progress and setback, which only training uses, in the expert's successful episodes.

Progress must be highest at success: otherwise a learner that is rewarded for progress gains nothing
by the last step to success, or loses by it. No setback may hold: it ends training episodes, so a
learner would be penalised for doing the task as the expert does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from taskbuilder.description.logic import Never
from taskbuilder.rollout.record import Rollout
from taskbuilder.validate.context import Context
from taskbuilder.validate.env_cache import Start
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
