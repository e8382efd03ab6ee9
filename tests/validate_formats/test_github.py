"""Reports as workflow commands."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskbuilder.errors import Finding, Location
from taskbuilder.validate.formats.github import workflow_commands
from taskbuilder.validate.report import Check, FamilyResult, TaskReport


def commands(*findings, checks=()):
    return list(
        workflow_commands(TaskReport("lift", "", (FamilyResult("static", checks, findings, ""),)))
    )


def test_a_finding_is_placed_relative_to_the_working_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    finding = Finding("TB102", "unknown key", "scene.x", Location(tmp_path / "a" / "b.yaml", 3, 7))
    assert commands(finding) == [
        "::error file=a/b.yaml,line=3,col=7,title=TB102::scene.x: unknown key"
    ]


@pytest.mark.parametrize(
    ("location", "properties"),
    [
        (Location(Path("a.yaml"), 3), "file=a.yaml,line=3,title=TB102"),
        (Location(Path("a.yaml")), "file=a.yaml,title=TB102"),
    ],
)
def test_what_is_not_known_of_a_place_is_left_out(location, properties):
    assert commands(Finding("TB102", "x", "", location)) == [f"::error {properties}::x"]


def test_a_finding_of_no_file_names_the_task():
    assert commands(Finding("TB308", "x", severity="warning")) == ["::warning title=TB308::lift: x"]


def test_what_would_end_a_command_is_escaped():
    finding = Finding("TB1", "100 %\r\nof a, b: ::error::", "", Location(Path("a,b:c%.yaml"), 1, 1))
    assert commands(finding) == [
        "::error file=a%2Cb%3Ac%25.yaml,line=1,col=1,title=TB1::100 %25%0D%0Aof a, b: ::error::"
    ]


def test_a_check_that_fails_without_a_finding_is_an_error():
    check = Check("TB306", "comes to rest", False, 7.25, 5.0, "mm")
    expected = "::error title=TB306::lift: comes to rest: 7.25 mm, limit 5 mm"
    assert commands(checks=(check,)) == [expected]


def test_a_check_with_its_finding_is_said_once():
    check = Check("TB306", "comes to rest", False, 7.25, 5.0, "mm")
    assert len(commands(Finding("TB306", "moves"), checks=(check,))) == 1


def test_a_sound_task_says_nothing(passed):
    assert list(workflow_commands(passed)) == []
