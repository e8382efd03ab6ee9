"""Where the functions and names of a description were written."""

from __future__ import annotations

import ast
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


def place_of_text(expression: Location, text: str) -> Location | None:
    """Where a text is written in an expression.

    Args:
        expression: Where the expression begins.
        text: A text among its arguments.

    Returns:
        The place of the text, or None if it is not written there, but in a variable, say.
    """
    linecache.checkcache(str(expression.file))
    try:
        tree = ast.parse("".join(linecache.getlines(str(expression.file))))
    except SyntaxError:
        return None
    place = (expression.line, expression.column - 1)
    inside = (
        part
        for node in ast.walk(tree)
        if isinstance(node, ast.expr) and (node.lineno, node.col_offset) == place
        for part in ast.walk(node)
    )
    for part in inside:
        if isinstance(part, ast.Constant) and part.value == text:
            return Location(expression.file, part.lineno, part.col_offset + 1)
    return None
