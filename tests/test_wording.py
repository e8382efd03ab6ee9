"""Messages name what is wrong, and what was probably meant, in one way."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from taskbuilder.wording import closest, quoted, suggestion

PACKAGE = Path(__file__).resolve().parents[1] / "taskbuilder"


@pytest.mark.parametrize(
    ("wrong", "arguments", "right"),
    [
        ("stik", {}, 'did you mean "stick"?'),
        ("STICK", {"otherwise": "write one"}, 'did you mean "stick"?'),
        ("zzz", {}, "known keys: stick, cube"),
        ("zzz", {"what": "it has"}, "it has: stick, cube"),
        ("zzz", {"otherwise": "write one"}, "write one"),
    ],
)
def test_a_suggestion(wrong, arguments, right):
    assert suggestion(wrong, ("stick", "cube"), **arguments) == right


def test_where_there_is_nothing():
    assert suggestion("stick", ()) == "there are none"
    assert closest("stick", ()) is None


def test_what_cannot_be_seen_in_a_name_is_shown():
    assert quoted("Büchse\n\x00") == '"Büchse\\n\\u0000"'


def test_nothing_else_asks_what_was_meant():
    asking = re.compile("get_close_matches")
    found = [
        path.relative_to(PACKAGE).as_posix()
        for path in sorted(PACKAGE.rglob("*.py"))
        if asking.search(path.read_text(encoding="utf-8"))
    ]
    assert found == ["wording.py"]
