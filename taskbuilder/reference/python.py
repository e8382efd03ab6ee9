"""Signatures and docstrings as Markdown."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

from taskbuilder.reference.markdown import fence


class _Written:
    """An annotation as its source has it: a signature shows those that are text in quotes."""

    def __init__(self, annotation: Any) -> None:
        bare = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
        self._text = bare.strip("\"'")

    def __repr__(self) -> str:
        return self._text


def signature(thing: Any) -> str:
    """The parameters with their types, one a line where they are many."""
    try:
        found = inspect.signature(thing)
    except ValueError:
        return ""
    empty = inspect.Signature.empty
    parameters = [
        p if p.annotation is empty else p.replace(annotation=_Written(p.annotation))
        for p in found.parameters.values()
        if p.name not in ("self", "cls")
    ]
    plain = inspect.isclass(thing) or found.return_annotation is empty
    returned = empty if plain else _Written(found.return_annotation)
    text = str(found.replace(parameters=parameters, return_annotation=returned))
    text = re.sub(r"<(?:\w+\.)*(\w+)\.(\w+): [^>]*>", r"\1.\2", text)  # members of enumerations
    text = re.sub(r"<function [^\n]*? at 0x[0-9a-f]+>", "...", text)
    if len(text) <= 90:
        return text
    inside, _, rest = text[1:].rpartition(")")
    lines = "".join(f"    {part},\n" for part in _parts(inside))
    return f"(\n{lines}){rest}"


def _parts(text: str) -> Iterator[str]:
    depth, start = 0, 0
    for index, sign in enumerate(text):
        depth += (sign in "([{") - (sign in ")]}")
        if sign == "," and not depth:
            yield text[start:index].strip()
            start = index + 1
    yield text[start:].strip()


def prose(doc: str) -> str:
    """A docstring of Google's style as Markdown."""
    parts = []
    for paragraph in _paragraphs(doc.replace("``", "`")):
        head, _, body = paragraph.partition("\n")
        if head in ("Args:", "Attributes:", "Raises:", "Returns:", "Yields:"):
            listed = _items(body) if head not in ("Returns:", "Yields:") else _joined(body)
            parts.append(f"**{head}**\n\n{listed}")
        elif paragraph != "::":  # which only announces the program after it
            parts.append(re.sub(r"::$", ":", paragraph))
    return _fenced("\n\n".join(parts))


def _paragraphs(text: str) -> list[str]:
    """The parts between empty lines; more than one empty line belongs to the part before it."""
    return re.split(r"\n\n(?!\n)", text)


def _items(body: str) -> str:
    items: list[str] = []
    for line in inspect.cleandoc("\n" + body).splitlines():
        if line.startswith(" ") and items:
            items[-1] += f" {line.strip()}"
        else:
            items.append(re.sub(r"^(\*{0,2}\w+):", r"- `\1`:", line))
    return "\n".join(items)


def _joined(body: str) -> str:
    return " ".join(inspect.cleandoc(body).split())


def _fenced(text: str) -> str:
    """Paragraphs that are indented are programs."""
    parts, program = [], []
    for paragraph in [*_paragraphs(text), ""]:
        if paragraph.startswith("    "):
            program.append(paragraph)
            continue
        if program:
            parts.append(fence("python", inspect.cleandoc("\n" + "\n\n".join(program))))
            program = []
        parts.append(paragraph)
    return "\n\n".join(parts).strip()
