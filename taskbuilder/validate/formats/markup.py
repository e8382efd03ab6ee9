"""Markup that is escaped by construction: text becomes markup only through `element`."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable
from dataclasses import dataclass

# What XML 1.0 has no way to write, and what UTF-8 has none for.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

_EMPTY_ELEMENTS = ("br", "img", "meta")


@dataclass(frozen=True)
class Html:
    """Markup that may stand in a page as it is."""

    text: str


Content = str | Html | Iterable["Content"] | None
"""What an element holds: text, which is escaped; markup; several of them; or nothing."""

Value = str | int | float | bool | None
"""Of an attribute; True is one without a value, False and None are left out."""


def printable(text: str) -> str:
    """The text with a mark in place of what no document can hold, such as control characters."""
    return _UNPRINTABLE.sub("\N{REPLACEMENT CHARACTER}", text)


def join(content: Content) -> Html:
    """One piece of markup from text and markup."""
    if content is None:
        return Html("")
    if isinstance(content, Html):
        return content
    if isinstance(content, str):
        return Html(html.escape(printable(content)))
    return Html("".join(join(part).text for part in content))


def element(tag: str, *content: Content, **attributes: Value) -> Html:
    """An element with its attributes and what is in it.

    Args:
        tag: Its name.
        content: What it holds.
        attributes: By name; ``class_`` is ``class``, and ``aria_label`` is ``aria-label``.
    """
    written = "".join(_attribute(name, value) for name, value in attributes.items())
    if tag in _EMPTY_ELEMENTS:
        return Html(f"<{tag}{written}>")
    return Html(f"<{tag}{written}>{join(content).text}</{tag}>")


def _attribute(name: str, value: Value) -> str:
    name = name.rstrip("_").replace("_", "-")
    if value is None or value is False:
        return ""
    return f" {name}" if value is True else f' {name}="{html.escape(printable(str(value)))}"'
