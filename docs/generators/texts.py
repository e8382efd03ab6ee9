"""The site as plain texts: `llms.txt`, an index of its pages, and `llms-full.txt`, all of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

TITLE = "# taskbuilder\n\n> Author, prove and render multi-robot manipulation tasks on PyBullet.\n"
_TREE = re.compile(r"^```\{toctree\}\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_CAPTION = re.compile(r"^:caption: (.+)$", re.MULTILINE)
_LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")


def sections(docs: Path) -> Iterator[tuple[str, list[Path]]]:
    """The sections of the site, each with its pages in order."""
    for tree in _TREE.findall((docs / "index.md").read_text(encoding="utf-8")):
        caption = _CAPTION.search(tree)
        names = [line for line in tree.splitlines() if line and not line.startswith(":")]
        yield caption[1] if caption else "", [docs / f"{name}.md" for name in names]


def title_of(page: str) -> str:
    """The title of a page."""
    return page.partition("\n")[0].removeprefix("# ")


def first_sentence(page: str) -> str:
    """The first sentence of a page's prose, without links."""
    page = re.sub(r"^```.*?^```$|^<.*?>$|^\|.*$", "", page, flags=re.MULTILINE | re.DOTALL)
    prose = (part for part in page.split("\n\n") if part.strip() and not part.startswith("#"))
    text = " ".join(_LINK.sub(r"\1", next(prose, "")).split())
    return re.split(r"(?<=\.) ", text)[0].rstrip(":")


def index(docs: Path) -> str:
    """An index of the pages, as https://llmstxt.org describes it."""
    lines = [TITLE]
    for caption, pages in sections(docs):
        lines.append(f"## {caption}\n")
        for page in pages:
            text = page.read_text(encoding="utf-8")
            name = page.relative_to(docs).with_suffix(".html")
            lines.append(f"- [{title_of(text)}]({name.as_posix()}): {first_sentence(text)}")
        lines.append("")
    return "\n".join(lines)


def whole(docs: Path) -> str:
    """All pages, one after the other, without pictures."""
    pages = [page for _, listed in sections(docs) for page in listed]
    texts = (re.sub(r"^!\[.*$", "", page.read_text(encoding="utf-8"), flags=re.M) for page in pages)
    return "\n\n".join([TITLE, *texts])
