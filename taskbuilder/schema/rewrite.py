"""Change single values in the text of a YAML file; comments, order and layout stay.

The parser tells where each value begins and ends. Only what lies between is replaced, and a key
that is missing is put behind the last one of its mapping.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import yaml

from taskbuilder.errors import UsageError
from taskbuilder.schema.source import LOADER, Path_, dotted

Value = float | Sequence[float] | Mapping[str, "Value"]
"""A number, a list of numbers, or a mapping of such values."""

DECIMALS = 4
"""Numbers are written with at most so many: a tenth of a millimetre, for metres."""


def rewritten(text: str, values: Mapping[Path_, Value]) -> str:
    """The text of a file with other values.

    Args:
        text: The text, which can be read without errors.
        values: The new values, by where they are in the file. If a key is missing, its mapping
            must be there.

    Raises:
        UsageError: A value cannot be changed without changing others, or losing a comment.
    """
    for path, value in values.items():
        text = _with(text, path, written(value))
    return text


def written(value: Value) -> str:
    """A value as it is written in YAML: ``{position: [0.1, 0, 0.25]}``."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {written(each)}' for key, each in value.items())}}}"
    if isinstance(value, Sequence):
        return f"[{', '.join(written(each) for each in value)}]"
    return f"{round(value, DECIMALS) + 0.0:.{DECIMALS}f}".rstrip("0").rstrip(".")


def _with(text: str, path: Path_, value: str) -> str:
    """The text with another value at one place."""
    node: yaml.Node = yaml.compose(text, Loader=LOADER) or yaml.ScalarNode("", "")
    for depth, step in enumerate(path, 1):
        where, (behind, found) = dotted(path[:depth]), _child(node, step)
        if found is None and depth == len(path) and isinstance(node, yaml.MappingNode):
            return _with_key(text, node, f"{step}: {value}")
        if found is None:
            raise UsageError(f"the file has no {where}; write it there first")
        if found.start_mark.index < behind:
            line = found.start_mark.line + 1
            raise UsageError(f"{where} is an alias (*) of what line {line} says; change it there")
        if text.startswith("&", found.start_mark.index):
            raise UsageError(f"{where} is used elsewhere, too (&); change it by hand")
        node = found
    start, end = node.start_mark.index, node.end_mark.index
    if "#" in text[start:end]:
        raise UsageError(f"{dotted(path)} has a comment inside; change it by hand")
    return text[:start] + value + text[end:]


def _child(node: yaml.Node, step: str | int) -> tuple[int, yaml.Node | None]:
    """The value of a key or an item of a list, and the place in the text behind which it stands."""
    behind = int(node.start_mark.index)
    if isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
        if step:
            behind = int(node.value[step - 1].end_mark.index)
        return behind, node.value[step]
    for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
        if key.value == step:
            return int(key.end_mark.index), value
    return behind, None


def _with_key(text: str, node: yaml.MappingNode, entry: str) -> str:
    """The text with another entry at the end of a mapping."""
    if node.flow_style:
        end = node.end_mark.index - 1  # before the closing brace
        kept = text[:end].rstrip()
        return f"{kept}{', ' if node.value else ''}{entry}{text[end:]}"
    first, last = node.value[0][0], node.value[-1][1]
    end = _end(last)
    newline = text.find("\n", end)
    if newline < 0:
        return f"{text}\n{' ' * first.start_mark.column}{entry}"
    return f"{text[:newline]}\n{' ' * first.start_mark.column}{entry}{text[newline:]}"


def _end(node: yaml.Node) -> int:
    """Where a value ends; a block's own mark stands behind comments and empty lines after it."""
    while isinstance(node, yaml.CollectionNode) and not node.flow_style:
        last = node.value[-1]
        node = last[1] if isinstance(node, yaml.MappingNode) else last
    return int(node.end_mark.index)
