"""Pieces of Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; a bar in a cell is escaped."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(_cell(cell) for cell in line)} |" for line in lines)


def fence(language: str, text: str) -> str:
    """A block of code."""
    return f"```{language}\n{text.rstrip()}\n```"


def code(text: str) -> str:
    """A word of code."""
    return f"`{text}`"


def number(value: float) -> str:
    """A number as people write it, with a true minus."""
    return f"{value:g}".replace("-", "−")


def side_by_side(cards: Iterable[str]) -> str:
    """Cards in a row where a page has room, below each other where it has no style."""
    return in_gallery((card, {}) for card in cards)


def in_gallery(cards: Iterable[tuple[str, Mapping[str, str]]]) -> str:
    """Cards side by side, each with what it can be filtered by: words by name."""
    inner = "\n\n".join(f"<div{_data(tags)}>\n\n{card}\n\n</div>" for card, tags in cards)
    return f'<div class="gallery">\n\n{inner}\n\n</div>'


def _data(tags: Mapping[str, str]) -> str:
    return "".join(f' data-{name}="{words}"' for name, words in tags.items())


def first_sentences(doc: str | None) -> str:
    """The first paragraph of a docstring, on one line, its code marked for Markdown."""
    paragraph = (doc or "").strip().split("\n\n")[0]
    return " ".join(paragraph.replace("``", "`").split())


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
