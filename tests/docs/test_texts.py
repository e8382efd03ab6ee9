"""The site as plain texts has every page, each with a sentence about it."""

from __future__ import annotations

import re
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from generators.texts import index, sections, whole  # noqa: E402  # found by the line above


def test_the_index_has_every_page_that_is_no_task():
    linked = re.findall(r"^- \[[^\]]+\]\((\S+)\.html\): \S.{20,300}$", index(DOCS), re.M)
    pages = {p.relative_to(DOCS).with_suffix("").as_posix() for p in DOCS.rglob("*.md")}
    tasks = {page for page in pages if page.startswith("tasks/")} - {"tasks/index"}
    assert set(linked) == {page for page in pages if "_build" not in page} - tasks - {"index"}


def test_the_whole_text_has_all_of_them_and_no_pictures():
    text = whole(DOCS)
    for _, pages in sections(DOCS):
        for page in pages:
            assert page.read_text(encoding="utf-8").partition("\n")[0] in text
    assert not re.search(r"^!\[", text, re.M)
