"""A drafter that makes the usual mistakes comes to a sound task by what the commands answer."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

pytestmark = pytest.mark.in_process

BRIEFS = Path(__file__).resolve().parents[2] / "examples" / "briefs.yaml"
TASK, DESCRIPTION = Path("carry.yaml"), Path("carry.py")

MISTAKES = (
    (TASK, "mass:", "mas:"),
    (TASK, "grasp: cube.middle", "grasp: cube.midle"),
    (DESCRIPTION, '"goal"', '"gaol"'),
    (TASK, "control_hz: 10", "control_hz: 7"),
    (TASK, "fixed: true", "fixed: true, mass: -1"),
)
"""In which file, what is right, and what the drafter writes."""


def test_the_loop_ends_with_an_episode_that_succeeds(run, monkeypatch, tmp_path):
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    assert run("new", "carry", "--robots", "1").status == 0
    for file, right, wrong in MISTAKES:
        text = file.read_text()
        assert right in text, right
        file.write_text(text.replace(right, wrong, 1))
    rounds = []
    while findings := checked(run):
        rounds.append({finding["code"] for finding in findings})
        assert len(rounds) < 6, findings
        if any(finding["fix"] for finding in findings):
            assert run("fix", str(TASK), "--yes").status in (0, 1)
        else:
            revise(findings)
    assert len(rounds) > 2
    demo = run("demo", str(TASK), "--json", "--jobs", "1")
    assert demo.data["episodes"][0]["success"]


def checked(run):
    """What a static validation finds."""
    (task,) = run("validate", str(TASK), "--level", "static", "--json").data["tasks"]
    return task["findings"]


def revise(findings):
    """Take back what the findings point at, by file and line."""
    for file, right, wrong in MISTAKES:
        lines = file.read_text().splitlines()
        for finding in findings:
            if finding["file"] == str(file) and wrong in lines[finding["line"] - 1]:
                lines[finding["line"] - 1] = lines[finding["line"] - 1].replace(wrong, right)
        file.write_text("\n".join(lines) + "\n")


def test_there_are_twenty_briefs_of_which_four_cannot_be_done():
    briefs = yaml.safe_load(BRIEFS.read_text(encoding="utf-8"))
    assert len({entry["brief"] for entry in briefs}) == 20
    assert len([entry for entry in briefs if entry.get("impossible")]) == 4
