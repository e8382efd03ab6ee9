"""Intervals: how sure a share of episodes, or a difference between paired episodes, is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist, fmean, stdev

LEVEL = 0.95
"""How sure intervals are to hold the true value."""

_STUDENT = (
    *(12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228),
    *(2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086),
    *(2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042),
)
"""Quantiles of Student's t of a two-sided interval of 95 %, from 1 degree of freedom on."""


def wilson(successes: int, trials: int, level: float = LEVEL) -> tuple[float, float]:
    """The score interval of a share (Wilson 1927): low and high, from 0 to 1.

    Unlike the usual ± it is right for few trials, and for none or all of them successful.

    Args:
        successes: How many succeeded.
        trials: Of how many.
        level: How sure it is to hold the true share.

    Raises:
        ValueError: There were no trials, or more successes than trials.
    """
    if trials < 1 or not 0 <= successes <= trials:
        raise ValueError(f"{successes} successes in {trials} trials")
    z = NormalDist().inv_cdf(0.5 + level / 2.0)
    share, weight = successes / trials, z * z / trials
    middle = (share + weight / 2.0) / (1.0 + weight)
    half = z * (share * (1.0 - share) / trials + weight / (4.0 * trials)) ** 0.5 / (1.0 + weight)
    # None or all: the ends are 0 and 1 exactly, which rounding may miss.
    low = 0.0 if successes == 0 else middle - half
    high = 1.0 if successes == trials else middle + half
    return low, high


@lru_cache
def student(df: int, tail: float) -> float:
    """What Student's t exceeds with a given probability.

    The distribution is the finite series for whole degrees of freedom in Abramowitz and Stegun,
    *Handbook of Mathematical Functions* (1964), 26.7.3 and 26.7.4, and is inverted by bisection.

    Args:
        df: Degrees of freedom, at least 1.
        tail: The probability, from 1e-9 to 0.5.
    """
    low, high = 0.0, 1.0
    while _beyond(df, high) > tail:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if _beyond(df, middle) > tail else (low, middle)
    return high


def _beyond(df: int, t: float) -> float:
    """The probability that Student's t is above a value that is not negative."""
    angle = math.atan2(t, math.sqrt(df))
    cosine, sine = math.cos(angle), math.sin(angle)
    odd = df % 2
    term, terms = (cosine if odd else 1.0), []
    for number in range(2 + odd, df + 1, 2):
        terms.append(term)
        term *= cosine * cosine * (number - 1) / number
    within = sine * math.fsum(terms)
    if odd:
        within = (angle + within) * 2.0 / math.pi
    return (1.0 - within) / 2.0


@dataclass(frozen=True)
class PairedDifference:
    """The mean difference between two returns from the same seeds, and its interval.

    Attributes:
        mean: Of the differences.
        half_width: Of the interval, by Student's t; infinite for a single pair. The interval is one
            of 95 % unless another was asked for.
        pairs: How many there are.
    """

    mean: float
    half_width: float
    pairs: int

    @classmethod
    def of(
        cls, ours: Sequence[float], theirs: Sequence[float], tail: float | None = None
    ) -> PairedDifference:
        """The difference of pairs: ours minus theirs.

        Args:
            ours: Returns.
            theirs: Returns from the same seeds.
            tail: The probability that the true mean lies beyond either end of the interval; by
                default 0.025, for an interval of 95 %.

        Raises:
            ValueError: There are no pairs, or one sequence is longer.
        """
        differences = [one - other for one, other in zip(ours, theirs, strict=True)]
        if not differences:
            raise ValueError("the difference of no pairs")
        count = len(differences)
        if count == 1:
            return cls(differences[0], float("inf"), 1)
        if tail is None:
            quantile = _STUDENT[min(count - 1, len(_STUDENT)) - 1]
        else:
            quantile = student(count - 1, tail)
        return cls(fmean(differences), quantile * stdev(differences) / count**0.5, count)

    @property
    def low(self) -> float:
        """The lower end of the interval; of a single pair, which has none, the difference."""
        return self.mean - (self.half_width if self.pairs > 1 else 0.0)

    @property
    def high(self) -> float:
        """The upper end of the interval; of a single pair, which has none, the difference."""
        return self.mean + (self.half_width if self.pairs > 1 else 0.0)

    def __str__(self) -> str:
        return f"{self.mean:.2f}" + (f" ± {self.half_width:.2f}" if self.pairs > 1 else "")
