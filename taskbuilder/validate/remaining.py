"""How long the rest of a proof takes, estimated from the families of checks that are done.

For the library's tasks, the estimate after the family ``repeat``, when a tenth of the time is over,
is within a factor of two of the truth in nine of ten proofs; see `RATIOS`.
"""

from __future__ import annotations

from collections.abc import Collection

from taskbuilder.validate.report import TaskReport
from taskbuilder.validate.runner import SEEDS

RATIOS = {
    "repeat": 1.0,
    "contract": 0.3,
    "solvable": 4.3,
    "needs its robots": 5.0,
    "pays for success": 3.1,
    "cost": 0.2,
}
"""Durations of the families in one process, over that of `repeat`, which plays episodes of the
expert without dividing them: medians of the library's proofs (benchmarks/results/proofs), which
have `SEEDS` seeds."""

_BY_SEEDS = ("solvable", "needs its robots")
"""Families that take longer with more seeds. Comparisons of returns are mostly decided after 5."""

_DIVIDED = ("solvable", "needs its robots", "pays for success")
"""Families whose episodes are divided among the processes."""

MEASURED = ("repeat", "solvable")
"""Families by whose durations the others are estimated; the later one is the better measure."""


def remaining_s(
    report: TaskReport, families: Collection[str], seeds: int, jobs: int
) -> float | None:
    """Estimate how long the families take that are not done, in seconds.

    Args:
        report: The report so far.
        families: Names of the families that are asked for.
        seeds: Number of seeds per variation.
        jobs: Number of processes that play episodes.

    Returns:
        The estimate; None before there is anything to measure by, with fewer seeds than those of
        a proof, which take less than a minute, mostly to start, and if a family has failed, after
        which others are skipped.
    """
    done = {family.name: family.seconds for family in report.families}
    measured = next((name for name in reversed(MEASURED) if name in done), None)
    if measured is None or seeds < SEEDS or not all(family.ok for family in report.families):
        return None
    rest = [name for name in RATIOS if name in families and name not in done]
    unit = done[measured] / _work(measured, seeds, jobs)
    return unit * sum(_work(name, seeds, jobs) for name in rest)


def _work(family: str, seeds: int, jobs: int) -> float:
    """The expected duration of a family, over that of `repeat`."""
    by_seeds = seeds / SEEDS if family in _BY_SEEDS else 1.0
    return RATIOS[family] * by_seeds / (jobs if family in _DIVIDED else 1)
