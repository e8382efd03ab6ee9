"""Conditions and measures as they are written in descriptions."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from taskbuilder.description import Description, Ladder
from taskbuilder.description.measures import Constant, Measure, Product, Sum
from taskbuilder.description.node import AllOf, AnyOf, Node, Not

_QUOTED = re.compile(r'"[^"]*"')
_NAME = re.compile(r"\b[A-Za-z_]\w*\b(?![=(])")


@dataclass(frozen=True)
class Expressions:
    """The expressions of a description.

    Attributes:
        names: Conditions that are written by their name where they are part of an expression.
    """

    names: Mapping[Node, str] = field(default_factory=dict)

    def text(self, node: Node) -> str:
        """A condition or a measure as it is written in a description."""
        if node in self.names:
            return self.names[node]
        match node:
            case AllOf() | AnyOf() if not node.gathers:
                return (" & " if isinstance(node, AllOf) else " | ").join(self._operands(node))
            case Not():
                return f"~{self._in_brackets(node.of)}"
            case Constant():
                return f"{node.number:g}"
            case Sum():
                first, *others = map(self._signed, self._summands(node))
                return "".join((first.removeprefix(" + "), *others)).lstrip()
            case Product():
                return " * ".join(map(self._in_brackets, node.of))
            case Ladder():
                rungs = (f"({self.text(when)}, {self.text(value)})" for when, value in node.rungs)
                return f"Ladder({', '.join((self.text(node.ground), *rungs))})"
        return repr(node) if hasattr(node, "call") else self._call(node)

    def _in_brackets(self, part: Node) -> str:
        """A part as an operand, in brackets where it has an operator of its own."""
        joined = isinstance(part, AllOf | AnyOf | Sum) and not part.gathers
        if joined and part not in self.names:
            return f"({self.text(part)})"
        return self.text(part)

    def _operands(self, node: AllOf | AnyOf) -> Iterator[str]:
        """What is between the operators: ``a & b & c`` is ``both & c`` if ``both`` is ``a & b``."""
        several = [(n.of, name) for n, name in self.names.items() if type(n) is type(node)]
        several.sort(key=lambda pair: -len(pair[0]))
        rest = node.of
        while rest:
            for parts, name in several:
                if rest[: len(parts)] == parts:
                    yield name
                    rest = rest[len(parts) :]
                    break
            else:
                yield self._in_brackets(rest[0])
                rest = rest[1:]

    def _call(self, node: Node) -> str:
        inside: list[str] = []
        described: Any = (
            node  # a node that is not a call is a dataclass, which its type leaves open
        )
        for each in fields(described):
            value = getattr(node, each.name)
            if isinstance(value, tuple) and value and all(isinstance(one, Node) for one in value):
                inside += map(self.text, value)
            elif value != each.default:
                text = self.text(value) if isinstance(value, Node) else _literal(value)
                inside.append(f"{each.name}={text}" if each.kw_only else text)
        return f"{type(node).__name__}({', '.join(inside)})"

    def _summands(self, node: Sum) -> Iterator[Measure]:
        """What is added without brackets: from left to right, as Python does."""
        first, *others = node.of
        yield from self._summands(first) if isinstance(first, Sum) else (first,)
        yield from others

    def _signed(self, part: Measure) -> str:
        """A summand with its sign before it; what is subtracted was multiplied by -1."""
        if isinstance(part, Product) and part.of[0] == Constant(-1.0):
            return f" - {self._in_brackets(part.of[1])}"
        if isinstance(part, Constant) and part.number < 0:
            return f" - {-part.number:g}"
        return f" + {self._in_brackets(part)}"


def expression(node: Node) -> str:
    """A condition or a measure as it is written in a description, with all that is in it."""
    return Expressions().text(node)


def by_name(description: type[Description]) -> tuple[dict[str, str], Expressions]:
    """The named conditions of a description, each written by those before it; and what uses them.

    Conditions that neither success nor failure, stages, reward or progress are made of are left
    out.
    """
    names: dict[Node, str] = {}
    texts: dict[str, str] = {}
    for name, node in description.attributes().items():
        if name not in vars(Description)["__annotations__"] and node not in names:
            texts[name] = Expressions(names).text(node)
            names = names | {node: name}
    texts["success"] = Expressions(names).text(description.success)
    shown = Expressions({description.success: "success"} | names)
    progress = [] if description.progress is None else [description.progress]
    roots = [description.failure, *description.stages.values(), *description.reward, *progress]
    needed = {"success"} | _mentioned([texts["success"], *map(shown.text, roots)], texts)
    return {name: text for name, text in texts.items() if name in needed}, shown


def _mentioned(start: list[str], texts: Mapping[str, str]) -> set[str]:
    """The names in some texts, and in the texts that these stand for."""
    needed: set[str] = set()
    waiting = list(start)
    while waiting:
        found = set(_NAME.findall(_QUOTED.sub("", waiting.pop()))) & texts.keys()
        waiting += (texts[name] for name in found - needed)
        needed |= found
    return needed


def _literal(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value).replace("'", '"')
