"""The bounds of measures, as far as their expressions say them."""

from __future__ import annotations

import itertools
import math

from taskbuilder.description.measures import (
    Closeness,
    Constant,
    ContactForce,
    Count,
    Duration,
    Fraction,
    Gap,
    GripperOpening,
    Ladder,
    Mean,
    Measure,
    Minimum,
    Product,
    Speed,
    Sum,
    Tilt,
)

Bounds = tuple[float, float]
"""The least and the greatest value, which may be infinite."""

UNBOUNDED: Bounds = (-math.inf, math.inf)


def bounds_of(measure: Measure) -> Bounds:
    """The least and the greatest value that a measure can have.

    They are those of its expression: parts count as independent of each other. Where the expression
    does not say a bound, as of a `Height` or of a measure of a description's own, it is infinite.
    """
    match measure:
        case Constant():
            return measure.number, measure.number
        case Closeness() | GripperOpening() | Fraction():
            return 0.0, 1.0
        case Tilt():
            return 0.0, 180.0
        case Gap() | Speed() | ContactForce() | Duration():
            return 0.0, math.inf
        case Count():
            return 0.0, float(len(measure.of))
        case Sum():
            lows, highs = zip(*map(bounds_of, measure.of), strict=True)
            return math.fsum(lows), math.fsum(highs)
        case Product():
            ends = list(map(_product, itertools.product(*map(bounds_of, measure.of))))
            return min(ends), max(ends)
        case Mean():
            lows, highs = zip(*map(bounds_of, measure.of), strict=True)
            return math.fsum(lows) / len(lows), math.fsum(highs) / len(highs)
        case Minimum():
            lows, highs = zip(*map(bounds_of, measure.of), strict=True)
            return min(lows), min(highs)
        case Ladder():
            steps = (measure.ground, *(value for _, value in measure.rungs))
            lows, highs = zip(*map(bounds_of, steps), strict=True)
            return min(lows), max(highs)
    return UNBOUNDED


def _product(factors: tuple[float, ...]) -> float:
    """A product in which 0 times an infinite bound is 0."""
    return 0.0 if 0.0 in factors else math.prod(factors)
