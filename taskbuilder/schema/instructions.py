"""Instructions: texts such as ``bring the {stick.color} stick``, filled in for an episode."""

from __future__ import annotations

import string
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from taskbuilder.errors import UnknownNameError
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.task import TaskSpec
from taskbuilder.schema.values import Model, color_name
from taskbuilder.wording import suggestion

DIGITS = 3
"""Significant digits of a number that was drawn from an interval."""

Drawn = Mapping[str, Any]
"""Values of randomised quantities by name, such as ``stick.color``; of a group, under its name."""


def fill(instruction: str, scene: SceneSpec, drawn: Drawn | None = None) -> str:
    """An instruction with ``{stick.color}`` and the like filled in.

    A colour in numbers becomes the nearest name of a colour.

    Args:
        instruction: The text.
        scene: The scene of the variation.
        drawn: What the episode drew in place of the scene's values.

    Raises:
        UnknownNameError: The scene has no such value.
        ValueError: The braces do not pair.
    """
    words = []
    for literal, name in _pieces(instruction):
        words.append(literal)
        if name is not None:
            words.append(_word(name, scene, drawn or {}))
    return "".join(words)


def longest_instruction(spec: TaskSpec, scenes: Sequence[SceneSpec]) -> int:
    """An upper bound of the length of the instruction of any episode, in bytes of UTF-8.

    Args:
        spec: The task.
        scenes: Its variations.
    """
    lengths = [len(spec.summary.encode())]
    for text in spec.instructions:
        parts = list(_pieces(text))
        names = [name for _, name in parts if name is not None]
        words = (max(len(_word(n, scene, {}).encode()) for scene in scenes) for n in names)
        literals = sum(len(literal.encode()) for literal, _ in parts)
        lengths.append(literals + sum(max(word, _LONGEST_DRAWN) for word in words))
    return max(lengths)


_LONGEST_DRAWN = 24
"""No name of a colour and no number is longer."""


def _pieces(instruction: str) -> Iterator[tuple[str, str | None]]:
    for literal, name, _, _ in string.Formatter().parse(instruction):
        yield literal, name


def _word(name: str, scene: SceneSpec, drawn: Drawn) -> str:
    thing, _, key = name.partition(".")
    things: Mapping[str, Model] = {**scene.robots, **scene.objects, **scene.sites}
    first = scene.objects.get(f"{thing}_1")
    owner = first if first is not None and first.count else things.get(thing)
    value = getattr(owner, key) if owner and key in type(owner).model_fields else None
    if key == "color" and value is not None:
        return color_name(_drawn_value(name, scene, drawn, value))
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        known: Sequence[str] = [f"{name}.color" for name in (*scene.objects, *scene.sites)]
        raise UnknownNameError(f'"{{{name}}}" is no value; {suggestion(name, known, what="try")}')
    now = _drawn_value(name, scene, drawn, value)
    return str(value) if now == value else f"{now:.{DIGITS}g}"


def _drawn_value(name: str, scene: SceneSpec, drawn: Drawn, written: Any) -> Any:
    """The value that an episode drew; that of its group, for a member."""
    thing, _, key = name.partition(".")
    member = scene.objects.get(thing)
    if member is not None and member.count:
        name = f"{thing.rpartition('_')[0]}.{key}"
    return drawn.get(name, written)
