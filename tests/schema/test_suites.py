"""Suites: groups of tasks by name, from a file beside the tasks."""

from __future__ import annotations

import shutil

import pytest

from taskbuilder import catalogue, load_suite
from taskbuilder.errors import FileError, UnknownNameError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.suites import find_suites

SPLITS = "train: {variations: [0], first_seed: 0}, test: {variations: [1], first_seed: 9}"


@pytest.fixture
def folder(tmp_path):
    """A folder with one task, for two robots."""
    entry = catalogue().tasks["handover"]
    for file in (entry.file, entry.description_file):
        shutil.copy(file, tmp_path / file.name.replace("handover", "pass_on"))
    task = tmp_path / "pass_on.yaml"
    task.write_text(task.read_text().replace("task: handover", "task: pass_on"))
    return tmp_path


def findings(folder, text):
    (folder / "suites.yaml").write_text(text)
    with pytest.raises(FileError) as caught:
        find_suites(Catalogue((folder,)))
    return [
        f"{f.location.line}:{f.location.column} {f.code} {f.path}: {f.message}"
        for f in caught.value.findings
    ]


def test_a_suite_lists_its_tasks():
    suite = load_suite("seed")
    assert suite.tasks == ("pick_push_place", "collaborative_lift", "handover")
    assert suite.train.variations == (0, 1)
    assert suite.test.variations == (2,)


def test_a_suite_has_every_task_of_its_folder_with_so_many_robots(folder):
    text = f"suites:\n  mine: {{summary: Mine., robots: 2, {SPLITS}}}\n"
    (folder / "suites.yaml").write_text(text)
    found = find_suites(Catalogue((folder,)))
    assert found["mine"].tasks == ("pass_on",)
    assert "pass_on" not in found["pairs"].tasks


def test_the_file_of_suites_is_no_task(folder):
    (folder / "suites.yaml").write_text("suites: {}\n")
    assert "suites" not in Catalogue((folder,)).tasks


def test_a_suite_that_is_not_there():
    with pytest.raises(UnknownNameError, match='no suite "pair"; did you mean "pairs"'):
        load_suite("pair")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            f"suites:\n  mine: {{summary: x, tasks: [pas_on], {SPLITS}}}\n",
            '2:30 TB009 suites.mine.tasks[0]: no task "pas_on" in this folder; '
            'did you mean "pass_on"?',
        ),
        (
            f"suites:\n  seed: {{summary: x, robots: 2, {SPLITS}}}\n",
            "2:3 TB008 suites.seed: is also the name of a suite in another folder; "
            "rename one of them",
        ),
        (
            f"suites:\n  mine: {{summary: x, {SPLITS}}}\n",
            "2:3 TB101 suites.mine: needs either tasks, a list of names, or robots, a number",
        ),
        (
            "suites:\n  mine: {summary: x, robots: 0, tain: 1}\n",
            "2:30 TB104 suites.mine.robots: is 0; must be at least 1",
        ),
    ],
    ids=["no such task", "taken name", "neither tasks nor robots", "no robots"],
)
def test_what_is_wrong_is_said_with_its_place(folder, text, expected):
    assert expected in findings(folder, text)
