"""Conditions and measures as they are written in descriptions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

from taskbuilder.description import Ladder
from taskbuilder.description.measures import Constant, Measure, Product, Sum
from taskbuilder.description.node import AllOf, AnyOf, Node, Not


def expression(node: Node) -> str:
    """A condition or a measure as it is written in a description."""
    match node:
        case AllOf() | AnyOf() if not node.gathers:
            return (" & " if isinstance(node, AllOf) else " | ").join(
                f"({expression(part)})" if isinstance(part, AllOf | AnyOf) else expression(part)
                for part in node.of
            )
        case Not():
            inner = expression(node.of)
            return f"~({inner})" if isinstance(node.of, AllOf | AnyOf) else f"~{inner}"
        case Constant():
            return f"{node.number:g}"
        case Sum():
            first, *others = map(_signed, _summands(node))
            return "".join((first.removeprefix(" + "), *others)).lstrip()
        case Product():
            return " * ".join(
                f"({expression(factor)})" if isinstance(factor, Sum) else expression(factor)
                for factor in node.of
            )
        case Ladder():
            rungs = (f"({expression(when)}, {expression(value)})" for when, value in node.rungs)
            return f"Ladder({', '.join((expression(node.ground), *rungs))})"
    return repr(node) if hasattr(node, "call") else _call(node)


def _call(node: Node) -> str:
    inside = []
    for field in fields(node):  # type: ignore[arg-type]  # every node that is not a call is one
        value = getattr(node, field.name)
        if isinstance(value, tuple) and value and all(isinstance(one, Node) for one in value):
            inside += map(expression, value)
        elif value != field.default:
            text = expression(value) if isinstance(value, Node) else _literal(value)
            inside.append(f"{field.name}={text}" if field.kw_only else text)
    return f"{type(node).__name__}({', '.join(inside)})"


def _literal(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value).replace("'", '"')


def _summands(node: Sum) -> Iterator[Measure]:
    """What is added without brackets: from left to right, as Python does."""
    first, *others = node.of
    yield from _summands(first) if isinstance(first, Sum) else (first,)
    yield from others


def _signed(part: Measure) -> str:
    """A summand with its sign before it; what is subtracted was multiplied by -1."""
    if isinstance(part, Product) and part.of[0] == Constant(-1.0):
        rest = part.of[1]
        return f" - ({expression(rest)})" if isinstance(rest, Sum) else f" - {expression(rest)}"
    if isinstance(part, Constant) and part.number < 0:
        return f" - {-part.number:g}"
    return f" + ({expression(part)})" if isinstance(part, Sum) else f" + {expression(part)}"
