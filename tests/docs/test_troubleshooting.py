"""The messages that the page on troubleshooting explains are those of the library."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8")
MESSAGES = re.findall(r"^`(.+)`\n: ", PAGE, flags=re.MULTILINE)


@cache
def texts() -> str:
    """All texts in the source, with a gap for what is filled in."""
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in sources()]
    return "\n".join(
        text for tree in trees for node in ast.walk(tree) if (text := text_of(node)) is not None
    )


def sources():
    return (ROOT / "taskbuilder").rglob("*.py")


def text_of(node: ast.AST) -> str | None:
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) or "…" for part in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def test_there_are_messages():
    assert len(MESSAGES) > 8


@pytest.mark.parametrize("message", MESSAGES)
def test_a_message_is_one_of_the_library(message):
    assert message in texts()
