"""What a task is about: the things of the scene that its description and its instructions name."""

from __future__ import annotations

import re
import string
from collections.abc import Callable, Iterable, Iterator
from types import CodeType
from typing import Any

from taskbuilder.description.custom import CustomCondition
from taskbuilder.description.description import Description
from taskbuilder.description.measures import CustomMeasure
from taskbuilder.description.node import Node, walk
from taskbuilder.description.origin import is_ours
from taskbuilder.description.space import Near
from taskbuilder.schema.names import SceneNames


def things_named(
    description: type[Description], instructions: Iterable[str], names: SceneNames
) -> dict[str, float]:
    """The objects and sites that a task is about.

    Args:
        description: The description, with the groups of its scene written out.
        instructions: The instructions as they are in the task file.
        names: The names of the scene.

    Returns:
        For each name, the largest ``within`` of a condition `Near` that names it, in metres, or 0.
        Of a name such as ``tray.rim``, the object's is given.
    """
    found: dict[str, float] = {}
    for node in walk(tuple(_expressions(description))):
        around = node.within if isinstance(node, Near) else 0.0
        mentioned = [name for _, name in node.references()]
        mentioned += [text for function in _own_functions(node) for text in _texts(function)]
        for name in mentioned:
            for member in names.members(name) or (name,):
                owner = member.partition(".")[0]
                found[owner] = max(around, found.get(owner, 0.0))
    for instruction in instructions:
        for name in _in_words(instruction, names):
            found.setdefault(name, 0.0)
    return {name: found[name] for name in (*names.objects, *names.sites) if name in found}


def _expressions(description: type[Description]) -> Iterator[Node]:
    yield from description.conditions().values()
    yield from description.reward
    yield description.setback
    if description.progress is not None:
        yield description.progress


def _own_functions(node: Node) -> Iterator[Callable[..., Any]]:
    """The functions of a node that the author of the task wrote."""
    if isinstance(node, CustomCondition | CustomMeasure):
        yield node.call.function
    for base in type(node).__mro__:
        yield from (
            value for value in vars(base).values() if callable(value) and not is_ours(value)
        )


def _texts(function: Callable[..., Any]) -> Iterator[str]:
    """Every text in the code of a function: ``world.pose("tray")`` names the tray."""
    waiting = [code] if isinstance(code := getattr(function, "__code__", None), CodeType) else []
    while waiting:
        for constant in waiting.pop().co_consts:
            if isinstance(constant, CodeType):
                waiting.append(constant)
            elif isinstance(constant, str):
                yield constant


def _in_words(instruction: str, names: SceneNames) -> Iterator[str]:
    """The things that an instruction names, as ``{tray.color}`` or in words: "the left plate"."""
    words = []
    for literal, name, _, _ in string.Formatter().parse(instruction):
        words.append(literal)
        if name:
            yield from names.members(name.partition(".")[0]) or (name.partition(".")[0],)
    text = " ".join(words).lower()
    for name in (*names.objects, *names.sites):
        if re.search(rf"\b{re.escape(name.lower().replace('_', ' '))}s?\b", text):
            yield name
