"""What pages show of the library is what the library is."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from generators import GENERATORS, fill, pages  # noqa: E402  # found by the line above

from taskbuilder.validate.runner import validate_task  # noqa: E402

PAGES = {
    page.relative_to(DOCS.parent).as_posix(): page.read_text(encoding="utf-8") for page in pages()
}

FRONT_PAGE = "docs/index.md"
"""Of the site; in the repository, the README is in its place."""


@pytest.mark.parametrize("name", PAGES)
def test_what_a_page_shows_is_so(name, monkeypatch):
    monkeypatch.setitem(
        inspect.unwrap(validate_task).__kwdefaults__, "apart", True
    )  # as it is outside of tests
    assert fill(PAGES[name]) == PAGES[name], "run `make docs`, which writes it anew"


@pytest.mark.parametrize("name", PAGES)
def test_every_block_has_an_end(name):
    opened = re.findall(r"^<!-- generated: ", PAGES[name], re.MULTILINE)
    assert len(opened) == len(re.findall(r"^<!-- end -->$", PAGES[name], re.MULTILINE))


def test_every_generator_is_asked():
    asked = re.findall(r"^<!-- generated: (\w+)", "".join(PAGES.values()), re.MULTILINE)
    assert {*asked} == {*GENERATORS}


@pytest.mark.parametrize("name", sorted({*PAGES} - {FRONT_PAGE}))
def test_a_page_needs_no_build(name):
    directives = set(re.findall(r"^[`:]{3,}\{(\w+)", PAGES[name], re.MULTILINE))
    assert directives <= {"toctree"}


def test_a_block_is_made_anew_and_nothing_else():
    before = "a\n<!-- generated: kinds -->\nold\n<!-- end -->\nb\n<!-- end -->\n"
    after = fill(before)
    assert after.startswith("a\n<!-- generated: kinds -->\n\n| annotation | a name of |")
    assert after.endswith("\n\n<!-- end -->\nb\n<!-- end -->\n")


def test_a_block_of_no_generator_is_an_error():
    with pytest.raises(LookupError):
        fill("<!-- generated: nothing -->\n<!-- end -->\n")
