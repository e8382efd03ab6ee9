"""What other packages add, in words: for `taskbuilder explain`, and not for the pages."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any

from taskbuilder.description import Condition, Measure, Term
from taskbuilder.diagnostics.foreign import CheckFamily, foreign_codes, load_family
from taskbuilder.errors import ExtensionError
from taskbuilder.extensions import CHECKS, CONDITIONS, DOORS, ForeignPart
from taskbuilder.reference.codes import entry_of
from taskbuilder.reference.markdown import first_sentences
from taskbuilder.reference.python import prose, signature


def declared() -> Iterator[ForeignPart]:
    """All parts that packages declare, whether they can be used or not."""
    for door in DOORS:
        for parts in door.declared().values():
            yield from parts


Loader = Callable[[ForeignPart], Any]
"""Imports a part, and raises an ExtensionError if it cannot be used."""


def described(part: ForeignPart, load: Loader) -> str:
    """What a part is, in Markdown, or why it cannot be used.

    A part is imported for this, so this may take as long as its package takes.

    Args:
        part: The part.
        load: Imports the kinds of parts that this module does not know: all but checks and
            conditions.
    """
    try:
        if part.noun == CHECKS.noun:
            return _checks(load_family(part))
        if part.noun == CONDITIONS.noun:
            return _condition(part)
        return _meaning(load(part))
    except ExtensionError as error:
        return f"{error}."


def codes() -> Iterator[tuple[str, str, str]]:
    """Code, package and meaning in Markdown of all codes of other packages."""
    for code, about, part in foreign_codes():
        yield code, part.package, entry_of(about)


def _checks(family: CheckFamily) -> str:
    lines = "\n".join(f"- {code}: {about.title}" for code, about in family.codes.items())
    return f"Checks at level {family.level}, with these codes:\n\n{lines}"


def _condition(part: ForeignPart) -> str:
    found = part.load(_no_node)
    call = f"{found.__name__}{' '.join(signature(found).split())}"
    module, _, attribute = part.value.partition(":")
    about = prose(inspect.getdoc(found) or "")
    return f"`{call}`\n\n{about}\n\n`from {module.strip()} import {attribute.strip()}`"


def _no_node(found: object) -> str | None:
    if isinstance(found, type) and issubclass(found, Condition | Measure | Term):
        return None
    return "is no subclass of Condition, Measure or Term of taskbuilder.description"


def _meaning(found: Any) -> str:
    """What an object says of itself, or its docstring."""
    for name in ("meaning", "summary"):
        if isinstance(text := getattr(found, name, None), str):
            return f"{text[:1].upper()}{text[1:]}".rstrip(".") + "."
    return first_sentences(inspect.getdoc(found)) or "It says nothing of itself."
