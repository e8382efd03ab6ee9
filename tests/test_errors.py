"""Findings: how they read, and in which order."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from taskbuilder.errors import (
    FileError,
    Finding,
    Location,
    PlacementError,
    TaskbuilderError,
    display_path,
    in_reading_order,
)

FILE = Path("/elsewhere/handover.yaml")


@pytest.mark.parametrize(
    ("location", "text"),
    [
        (Location(FILE), "/elsewhere/handover.yaml"),
        (Location(FILE, 14), "/elsewhere/handover.yaml:14"),
        (Location(FILE, 14, 15), "/elsewhere/handover.yaml:14:15"),
        (Location(FILE, 0, 15), "/elsewhere/handover.yaml"),
    ],
)
def test_a_location_reads_as_editors_and_terminals_link_it(location, text):
    assert str(location) == text


def test_paths_inside_the_working_directory_are_shown_relative_to_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert display_path(tmp_path / "tasks" / "a.yaml") == "tasks/a.yaml"
    assert display_path(tmp_path.parent / "b.yaml") == str(tmp_path.parent / "b.yaml")
    assert display_path(Path("c.yaml")) == "c.yaml"


def test_paths_are_shown_even_where_the_working_directory_is_gone(tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert display_path(FILE) == str(FILE)


def test_a_finding_reads_as_place_severity_code_path_and_message():
    finding = Finding("TB102", "unknown key", "scene.robots", Location(FILE, 3, 5))
    assert str(finding) == ("/elsewhere/handover.yaml:3:5: error[TB102] scene.robots: unknown key")
    assert str(Finding("TB1", "bad", severity="warning")) == "warning[TB1] bad"
    assert str(Finding("TB1", "bad", excerpt="x = 1")) == "error[TB1] bad\n    x = 1"


def test_a_finding_can_be_placed_elsewhere():
    finding = Finding("TB1", "bad", "a", Location(FILE, 1, 1))
    assert finding.at(Location(FILE, 2, 2)) == Finding("TB1", "bad", "a", Location(FILE, 2, 2))
    assert finding.at(None).location is None


def test_findings_are_read_from_top_to_bottom_and_once():
    late = Finding("TB1", "late", location=Location(FILE, 9, 1))
    early = Finding("TB2", "early", location=Location(FILE, 2, 7))
    right = Finding("TB1", "right", location=Location(FILE, 2, 8))
    other = Finding("TB1", "other", location=Location(Path("/elsewhere/zzz.py"), 1, 1))
    nowhere = Finding("TB1", "nowhere")
    ordered = in_reading_order([late, other, right, early, nowhere, late])
    assert ordered == (nowhere, early, right, late, other)


@pytest.mark.parametrize("sort", [FileError, PlacementError])
def test_an_error_carries_its_findings_in_reading_order(sort):
    findings = [Finding("TB1", "b", location=Location(FILE, 2)), Finding("TB1", "a")]
    error = sort(findings)
    assert isinstance(error, TaskbuilderError)
    assert error.findings == in_reading_order(findings)
    assert str(error) == "error[TB1] a\n/elsewhere/handover.yaml:2: error[TB1] b"


@pytest.mark.parametrize("error", [FileError, PlacementError])
def test_an_error_with_findings_comes_whole_from_another_process(error):
    finding = Finding("TB102", "unknown key", "scene.robot", Location(Path("a.yaml"), 3, 5))
    again = pickle.loads(pickle.dumps(error([finding])))
    assert again.findings == (finding,)
    assert str(again) == str(error([finding]))
