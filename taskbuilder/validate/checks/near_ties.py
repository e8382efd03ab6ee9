"""Whether a lead of the expert is sure and yet tiny; of the family "pays for success".

A tiny lead is measured against the largest one at the same discount: by how much all that the task
pays can differ. That is usually the lead over doing nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

from taskbuilder.errors import Finding
from taskbuilder.task import Task
from taskbuilder.validate.checks.rivals import Rival, pairs_of, way_of_playing
from taskbuilder.validate.locate import finding_in_description
from taskbuilder.validate.report import Check, Result

NEAR_TIE = 0.02
"""Share of the largest lead below which a lead is a near tie.

Of the library's tasks, the smallest share is 1 % in Handover and 4 % in all others.
"""


def check_near_ties(task: Task, rivals: Sequence[Rival]) -> Result:
    """Warn of the probe that comes nearest to the expert, if it comes that near.

    Args:
        task: The task.
        rivals: The comparisons, at least one.
    """
    largest: dict[float, Rival] = {}
    for rival in rivals:
        known = largest.setdefault(rival.discount, rival)
        largest[rival.discount] = max(known, rival, key=lambda one: one.lead.mean)
    shares = [(_proportion(rival, largest[rival.discount]), rival) for rival in rivals]
    share, closest = min(shares, key=lambda pair: pair[0])
    near = {rival.baseline for share, rival in shares if share < NEAR_TIE}
    widest = largest[closest.discount]
    findings = [_finding(task, closest, widest, len(near))] if near else []
    return Check("TB559", "leads are no near ties", True, share, None, "share"), findings


def _proportion(rival: Rival, widest: Rival) -> float:
    return rival.lead.mean / widest.lead.mean if widest.lead.mean > 0.0 else 1.0


def _finding(task: Task, rival: Rival, widest: Rival, near: int) -> Finding:
    at = f" at a discount of {rival.discount:g}" if rival.discount < 1.0 else ""
    others = f"; so it is with {near - 1} more" if near > 1 else ""
    message = (
        f"{way_of_playing(task, rival.baseline)} earns {rival.earned:.1f} in the mean, the expert "
        f"{rival.expert:.1f}{at}: its lead of {rival.lead} over {pairs_of(rival)} is sure, but "
        f"only {100 * _proportion(rival, widest):.1f} % of that over "
        f"{way_of_playing(task, widest.baseline)} ({widest.lead.mean:.1f}); pay more for what "
        f"comes after it, so that learners notice{others}"
    )
    term = task.description.reward[0] if task.description.reward else None
    return finding_in_description(task, "TB559", message, "reward", term, severity="warning")
