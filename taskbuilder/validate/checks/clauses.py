"""Whether robots are needed for more than a clause of success; of the family "needs its robots".

The probes are judged again, by success without the clauses that speak of the missing robots only.
If this is reached, the robots that are there can do everything else.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from taskbuilder.description.reasons import label
from taskbuilder.errors import Finding
from taskbuilder.expert.baselines import Baseline, BaselineKind
from taskbuilder.task import Task
from taskbuilder.validate.env_cache import Start
from taskbuilder.validate.locate import finding_in_description
from taskbuilder.validate.proportion import Proportion
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.rest_of_success import missing_robots, reduced_success

Reached = Mapping[Baseline, Collection[Start]]
"""The starts from which each probe reached the rest of success."""


def check_clauses(task: Task, reached: Reached, played: Mapping[Baseline, int]) -> Result:
    """Warn of robots without whom everything is reached but the clauses about themselves.

    Args:
        task: The task.
        reached: The starts from which each probe reached the rest of success.
        played: Number of episodes of each probe.
    """
    by_missing: dict[tuple[str, ...], list[Baseline]] = {}
    for baseline in sorted(reached, key=lambda baseline: -len(reached[baseline])):
        if reached[baseline]:
            by_missing.setdefault(missing_robots(task, baseline), []).append(baseline)
    findings = [
        _finding(task, missing, found[0], reached[found[0]], played[found[0]])
        for missing, found in by_missing.items()
    ]
    count = sum(map(len, reached.values()))
    name = "robots are needed for more than a clause"
    return Check("TB546", name, True, count, None, "episodes"), findings


def _finding(
    task: Task, missing: tuple[str, ...], baseline: Baseline, starts: Collection[Start], played: int
) -> Finding:
    dropped = reduced_success(task, missing).dropped
    clauses = " and ".join(dict.fromkeys(map(label, dropped)))
    who, verb = " and ".join(missing), "is" if len(missing) == 1 else "are"
    how = f"playing {baseline}" if baseline.kind is BaselineKind.WITHOUT else str(baseline)
    share = Proportion(len(starts), played)
    message = (
        f"{who} {verb} needed only because success asks for {clauses}: {how} reaches all else "
        f"from {share} seeds ({min(starts)}); let the others need what it does, such as to hold "
        "what they work on"
    )
    return finding_in_description(task, "TB546", message, "success", dropped[0], severity="warning")
