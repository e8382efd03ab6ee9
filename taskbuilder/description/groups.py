"""Groups in descriptions: ``All(Inside("cubes", "bin"))`` is about each of the cubes.

A description is written without its scene. Once its names are checked, every part of an expression
that gathers several is repeated for each member of the groups that the part names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from copy import copy
from dataclasses import fields, is_dataclass, replace
from itertools import product
from math import prod
from typing import Any, TypeVar

from taskbuilder.description.custom import Call
from taskbuilder.description.node import Node, hints_of, kinds_of
from taskbuilder.schema.names import SceneNames

Expression = TypeVar("Expression", bound=Node)

Members = Mapping[str, str]
"""Group -> the member that takes its place."""


def of_groups(node: Node, names: SceneNames) -> Iterator[tuple[Node, str]]:
    """Every name of a group in an expression, outside of what gathers several, and who names it."""
    # An annotation that cannot be read is a finding of its own.
    with suppress(NameError, AttributeError, TypeError, SyntaxError):
        yield from ((node, name) for _, name in node.references() if names.members(name))
    for part in node.parts:
        if isinstance(part, Node) and not part.gathers:
            yield from of_groups(part, names)


def is_about_each(value: Any, names: SceneNames) -> bool:
    """Whether an attribute is an expression about each member of a group."""
    return isinstance(value, Node) and not value.gathers and any(of_groups(value, names))


def times(part: Node, names: SceneNames) -> int:
    """How often an expression that gathers several repeats one of its parts."""
    return prod(len(names.groups[group]) for group in _groups(part, names))


def expanded(value: Any, names: SceneNames) -> Any:
    """An attribute of a description with its groups written out, member by member."""
    if isinstance(value, tuple):
        return tuple(expanded(item, names) for item in value)
    if isinstance(value, dict):
        return {key: expanded(item, names) for key, item in value.items()}
    if not isinstance(value, Node):
        return value
    if value.gathers:
        return changed(value, {"of": tuple(_each(value, names))})
    if not is_dataclass(value) or not value.parts:
        return value
    return changed(value, {f.name: expanded(getattr(value, f.name), names) for f in fields(value)})


def _each(gathering: Node, names: SceneNames) -> Iterator[Node]:
    """The parts of an expression that gathers several, each for every member it is about."""
    for part in gathering.parts:
        groups = _groups(part, names)
        for members in product(*(names.groups[group] for group in groups)):
            yield expanded(_about(part, dict(zip(groups, members, strict=True))), names)


def _groups(part: Node, names: SceneNames) -> tuple[str, ...]:
    if part.gathers:
        return ()
    return tuple(dict.fromkeys(name.partition(".")[0] for _, name in of_groups(part, names)))


def _about(node: Node, members: Members) -> Node:
    """An expression with members in place of their groups."""
    if not members or not is_dataclass(node):
        return node
    hints = hints_of(type(node))
    values = {f.name: getattr(node, f.name) for f in fields(node)}
    return changed(node, {key: _put(value, hints[key], members) for key, value in values.items()})


def _put(value: Any, annotation: Any, members: Members) -> Any:
    if isinstance(value, tuple):
        return tuple(_put(item, annotation, members) for item in value)
    if isinstance(value, Node):
        return value if value.gathers else _about(value, members)
    if isinstance(value, Call):
        told = ((a.name, _put(a.value, a.annotation, members)) for a in value.annotated())
        return replace(value, arguments=tuple(told))
    if not isinstance(value, str) or not any(kinds_of(annotation)):
        return value
    owner, dot, inner = value.partition(".")
    return f"{members.get(owner, owner)}{dot}{inner}"


def changed(node: Expression, values: Mapping[str, Any]) -> Expression:
    """The same expression, written in the same place, with other values of its fields."""
    other = copy(node)
    for key, value in values.items():
        object.__setattr__(other, key, value)
    return other
