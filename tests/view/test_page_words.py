"""Names and messages from files are shown as they are written; none of them is markup."""

from __future__ import annotations

import re

import pytest

from taskbuilder.errors import Finding
from taskbuilder.fixes import Correction
from taskbuilder.geometry import Pose
from taskbuilder.view.recording import ConditionState
from taskbuilder.view.words import conditions, difference, findings, plain, pose_yaml, stages

ATTACKS = (
    "<img src=x onerror=alert(1)>",
    "[click](javascript:alert(1))",
    "![x](http://elsewhere/x.png)",
    "`a` **b** <script>alert(1)</script>",
    "&lt;b&gt;",
    "a\n# heading",
)


@pytest.mark.parametrize("text", ATTACKS)
def test_no_character_of_markup_is_left(text):
    shown = plain(text)
    assert not re.search(r"(?<!\\)[<>\[\]()!*`&#]", shown)
    assert "\n" not in shown
    assert shown.replace("\\", "") == text.replace("\n", " ").replace("\\", "")


@pytest.mark.parametrize("text", ATTACKS)
def test_names_in_lists_are_plain(text):
    made = (
        conditions([ConditionState(text, False, text)]),
        stages([text], 0),
        findings([Finding("TB102", text, text)]),
    )
    for markdown in made:
        assert plain(text) in markdown
        assert "<" not in markdown.replace(r"\<", "")


def test_the_difference_has_the_changed_lines_alone_and_none_ends_its_block(tmp_path):
    before = "a: 1\n# ```\nb: [1,\n```\n  2]\nc: 3\n"
    after = before.replace("```\n  2", "  3")
    words = difference(Correction(tmp_path / "x_y.yaml", before, after))
    assert "x\\_y.yaml changes so:" in words
    assert words.endswith("so:\n\n```diff\n-```\n-  2]\n+  3]\n```")
    assert difference(Correction(tmp_path / "x.yaml", before, before)) == ""


def test_a_pose_can_be_copied_into_a_task_file():
    text = pose_yaml("stick", Pose.from_rpy_deg((0.1, -0.25, 0.5), (0.0, 0.0, 90.0)))
    assert "position: [0.1, -0.25, 0.5]" in text
    assert "rpy_deg: [0.0, 0.0, 90.0]" in text
