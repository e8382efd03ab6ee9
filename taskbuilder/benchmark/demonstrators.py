"""Who demonstrates a task: its expert, with as much noise as it bears."""

from __future__ import annotations

from taskbuilder.benchmark.tracks import DemonstrationSet
from taskbuilder.evaluation.assessment import evaluate
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task


def demonstrator(
    task: Task, wanted: DemonstrationSet, variation: int, catalogue: Catalogue | None = None
) -> str:
    """The expert with the strongest noise under which it mostly succeeds, as text.

    Args:
        task: The task, which has an expert.
        wanted: The levels of noise, and what they are tried on.
        variation: The variation to try them in.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
    """
    for expert in wanted.experts:
        trials = evaluate(
            expert,
            wanted.trials,
            task=task,
            first_seed=wanted.first_seed,
            jobs=1,
            catalogue=catalogue,
            variation=variation,
        )
        if trials.successes >= wanted.trials_needed:
            return expert
    return "expert"
