"""What a training run works with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from taskbuilder.data.dataset import Dataset
from taskbuilder.learn.plan import Plan
from taskbuilder.task import Task

if TYPE_CHECKING:
    from taskbuilder.learn.expert_waits import ExpertWaits


@dataclass(frozen=True)
class RunSetup:
    """What a run works with, checked once and handed down.

    Attributes:
        plan: The plan.
        task: The task of the plan.
        dataset: The data set to learn from, or None.
        observed: Names of the numbers that robots observe, by agent; only with a data set.
        waits: How long the expert goes without progress, if that was measured for this run.
    """

    plan: Plan
    task: Task
    dataset: Dataset | None = None
    observed: Mapping[str, Sequence[str]] = field(default_factory=dict)
    waits: ExpertWaits | None = None
