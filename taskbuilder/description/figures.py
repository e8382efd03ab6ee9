"""Figures beside their bounds, in words."""

from __future__ import annotations

from collections.abc import Iterable

_MOST_DIGITS = 6


def beside(value: float, bound: float, unit: str, digits: int = 1) -> tuple[str, str]:
    """A figure and its bound, with as many digits as it takes to tell them apart.

    Args:
        value: The figure.
        bound: What it is held against.
        unit: Of both.
        digits: Behind the point of the figure, at least.
    """
    space = "" if unit.startswith("°") else " "
    for count in range(digits, _MOST_DIGITS + 1):
        if value == bound or f"{value:.{count}f}" != f"{bound:.{count}f}":
            break
    return f"{value:.{count}f}{space}{unit}", f"{bound:.10g}{space}{unit}"


def meters(value: float, bound: float) -> tuple[str, str]:
    """A length and its bound, both given in metres and told in centimetres."""
    return beside(100.0 * value, 100.0 * bound, "cm")


def listed(names: Iterable[str]) -> str:
    """Names in a row: ``a, b and c``."""
    *some, last = names
    return f"{', '.join(some)} and {last}" if some else last
