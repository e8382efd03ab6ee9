"""Checks of what functions are called with: numbers, seeds and names.

A wrong argument is refused before anything is done or written with it.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable
from typing import Any

from taskbuilder.errors import UsageError
from taskbuilder.wording import excerpt, quoted

SEED_LIMIT = 2**63
"""Seeds are below this number."""


def as_whole(value: Any) -> int | None:
    """A whole number of any type, such as NumPy's; None for all else, and for True and False."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def whole(name: str, value: Any, least: int = 0, most: int | None = None) -> int:
    """An argument that is a whole number.

    Args:
        name: The argument.
        value: Its value.
        least: The least that it may be.
        most: The most that it may be, if there is a bound.

    Raises:
        UsageError: It is no whole number, or out of bounds.
    """
    number = as_whole(value)
    if number is not None and least <= number and (most is None or number <= most):
        return number
    bounds = f"from {least}" if most is None else f"from {least} to {most}"
    raise UsageError(f"{name} is {excerpt(repr(value))}; a whole number {bounds}")


def a_seed(value: Any) -> int:
    """The seed of an episode.

    Raises:
        UsageError: It is no whole number from 0 to 2**63 - 1.
    """
    number = as_whole(value)
    if number is not None and 0 <= number < SEED_LIMIT:
        return number
    shown = excerpt(repr(value))
    raise UsageError(f"a seed is a whole number from 0 to 2**63 - 1, not {shown}")


def several(name: str, values: Any) -> tuple[Any, ...]:
    """An argument that is a sequence: a text is none, though Python goes through its letters.

    Raises:
        UsageError: It is a text, or no sequence.
    """
    if isinstance(values, str):
        raise UsageError(f"{name} is {quoted(values)}; it is a tuple, such as ({quoted(values)},)")
    if not isinstance(values, Iterable):
        raise UsageError(f"{name} is {excerpt(repr(values))}; it is a tuple")
    return tuple(values)
