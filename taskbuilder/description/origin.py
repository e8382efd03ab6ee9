"""Where the functions of a description were written."""

from __future__ import annotations

import linecache
from collections.abc import Callable
from pathlib import Path
from typing import Any

from taskbuilder.errors import Location


def is_ours(function: Callable[..., Any]) -> bool:
    """Whether a function belongs to this package, and not to a description."""
    module: str | None = getattr(function, "__module__", None)
    return (module or "").startswith("taskbuilder.description.")


def place_of(function: Callable[..., Any]) -> Location | None:
    """The line of a function's name, below its decorators."""
    code = getattr(function, "__code__", None)
    if code is None:
        return None
    first = code.co_firstlineno
    lines = linecache.getlines(code.co_filename)[first - 1 :]
    begun = (n for n, line in enumerate(lines, start=first) if line.lstrip().startswith("def "))
    return Location(Path(code.co_filename), next(begun, first), 1)
