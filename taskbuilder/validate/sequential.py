"""When comparisons of returns are looked at, and how sure each look must be.

The expert's mean return is compared with that of a probe, from pairs of episodes with the same
seed. Most comparisons are plain after a few pairs, and some need all of them. So every comparison
is looked at several times, and ends at the first look that decides it. Somebody who looked four
times at an interval of 95 % would be wrong far more often than once in twenty. Therefore each look
gets a share of the error, and a wider interval.

A comparison that is to be wrong at most with the probability `ERROR` spends `ERROR` × (n/N)³ of it
up to its look at n of N seeds, so that hardly any is spent early and nearly all is left for the
last look. An error-spending function is that of Lan and DeMets (*Discrete sequential boundaries for
clinical trials*, Biometrika 70, 1983), and this power is that of Kim and DeMets (*Design and
analysis of group sequential tests based on the type I error spending rate function*, Biometrika 74,
1987). The power 3 comes near the boundaries of O'Brien and Fleming (*A multiple testing procedure
for clinical trials*, Biometrics 35, 1979).

At look k, the one-sided error of the interval by Student's t is what is spent between the looks
k - 1 and k. By Boole's inequality, the probability that any look is wrong is at most the sum over
all looks, which is `ERROR`, however the looks depend on each other. For differences that are
normally distributed, this bound holds exactly, as each interval does. Boundaries that take the
dependence of the looks into account would be a little narrower: at the last of four looks, the
quantile of Student's t is 2.08 here, and 2.02 for a single look.

`python benchmarks/stopping.py` measures the error for differences that are not normally
distributed. It is far above the bound if a rare outcome decides about the mean: the first few pairs
may all lack it.
"""

from __future__ import annotations

from dataclasses import dataclass

ERROR = 0.025
"""Probability, for each comparison, that the expert's lead is wrongly found to be above zero."""

POWER = 3
"""Power of the share of seeds by which the error is spent."""

ENOUGH = 40
"""Number of seeds from which on the error is spent over looks; fewer are too few for that."""

FIRST = 5
"""Minimum number of seeds at the first look."""

IN_EACH_VARIATION = 2
"""Minimum number of seeds in each variation at the first look: one to drop, and one to throw."""


@dataclass(frozen=True)
class InterimLook:
    """A look at all undecided comparisons.

    Attributes:
        seeds: Number of seeds up to this look.
        tail: Probability that the true mean lies beyond either end of the interval.
    """

    seeds: int
    tail: float


@dataclass(frozen=True)
class Looks:
    """The looks at the comparisons of a task.

    Attributes:
        listed: The looks, in order.
        both_ways: Whether also a comparison in which the expert is behind must be sure before the
            last look.
    """

    listed: tuple[InterimLook, ...]
    both_ways: bool

    @property
    def first(self) -> int:
        """Number of seeds at the first look."""
        return self.listed[0].seeds


def looks(seeds: int, variations: int = 1) -> Looks:
    """The looks for a number of seeds.

    With `ENOUGH` seeds or more, there are looks at 5, 10, 20, … seeds up to this number, with the
    error spent over them; the first look covers every variation. With fewer, as with ``--quick``,
    the first look is at these, by an interval of 95 %. Probes that leave the expert's script and
    are undecided by then are looked at again in the same way, with twice as many seeds each time,
    up to `ENOUGH`.

    Args:
        seeds: Number of seeds.
        variations: Number of variations, which take turns.
    """
    if seeds < ENOUGH:
        return Looks(tuple(InterimLook(n, ERROR) for n in _doubled(seeds, ENOUGH)), both_ways=False)
    first = min(max(FIRST, IN_EACH_VARIATION * variations), seeds)
    spent, listed = 0.0, []
    for n in _doubled(first, seeds):
        up_to_now = ERROR * (n / seeds) ** POWER
        listed.append(InterimLook(n, up_to_now - spent))
        spent = up_to_now
    return Looks(tuple(listed), both_ways=True)


def _doubled(first: int, last: int) -> list[int]:
    """Numbers that double from the first to the last, which is the end in any case."""
    numbers = []
    while first < last:
        numbers.append(first)
        first *= 2
    return [*numbers, last]
