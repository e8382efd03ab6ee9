"""`taskbuilder fix` gives back what was misspelt, and touches nothing else."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from taskbuilder import validate_task
from taskbuilder.errors import UsageError
from taskbuilder.fixes import correct

SOUND = Path(__file__).parents[1] / "broken_tasks" / "sound.yaml"

IN_YAML = {
    "a section": ("observe:", "obsrve:"),
    "a key in braces": ("control_hz", "controlhz"),
    "a robot of the catalogue": ("model: ur5e\n", "model: ur5\n"),
    "an object": ("bring: block", "bring: blok"),
    "a site": ("to: goal", "to: gaol"),
    "a site in quotation marks": ("to: goal", 'to: "gaol"'),
    "a grasp point": ("block.top", "block.tpo"),
    "a verb": ("{bring:", "{brng:"),
    "a channel of the agent": ("self.gripper", "self.griper"),
    "a channel of a site": ("lamp.position", "lamp.positoin"),
    "what a channel is of": ("block.pose", "blok.pose"),
    "a choice": ("across: y", "across: Y"),
    "a decimal point": ("mass: 0.08", "mass: 0,08"),
}
QUICK = ("a site in quotation marks", "a verb", "a channel of a site", "a decimal point")
"""One of each kind: a value, a key, a dotted name, and a number."""
IN_PYTHON = {
    "an object": ('Held("block")', 'Held("blok")'),
    "a frame": ('"right.tcp", "lamp", within', '"right.tpc", "lamp", within'),
    "two in a line": ('Near("block", "goal"', 'Near("blok", "gaol"'),
    "an agent": ('agent="left"', 'agent="lft"'),
    "a condition": ('= Near("block"', '= Naer("block"'),
}


@pytest.fixture
def task(tmp_path):
    """The sound task, as files of one's own."""
    for suffix in (".yaml", ".py"):
        shutil.copy(SOUND.with_suffix(suffix), tmp_path / f"sound{suffix}")
    return tmp_path / "sound.yaml"


def misspell(file, right, wrong):
    text = file.read_text()
    assert right in text
    file.write_text(text.replace(right, wrong, 1))


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        pytest.param(*slip, id=name, marks=() if name in QUICK else pytest.mark.slow)
        for name, slip in IN_YAML.items()
    ],
)
def test_what_is_misspelt_in_the_task_file_is_put_right(right, wrong, task, run):
    before = task.read_text()
    misspell(task, right, wrong)
    ran = run("fix", str(task), "--yes")
    assert (ran.status, ran.err) == (0, "")
    after = task.read_text()
    assert (after if '"' not in wrong else after.replace('"', "")) == before
    assert ran.out.splitlines()[-1] == "the static checks find nothing to correct"


@pytest.mark.parametrize(("right", "wrong"), IN_PYTHON.values(), ids=IN_PYTHON)
def test_what_is_misspelt_in_the_description_is_put_right(right, wrong, task, run):
    file = task.with_suffix(".py")
    before = file.read_text()
    misspell(file, right, wrong)
    assert run("fix", str(task), "--yes").status == 0
    assert file.read_text() == before


def test_the_difference_is_shown_and_nothing_is_written_unasked(task, run):
    misspell(task, "to: goal", "to: gaol")
    before = task.read_text()
    ran = run("fix", str(task))
    assert ran.status == 2
    assert "--yes writes these corrections" in ran.err
    assert "-  - left: {bring: block, to: gaol}\n+  - left: {bring: block, to: goal}" in ran.out
    assert task.read_text() == before


def test_what_takes_a_decision_is_left_and_told(task, run):
    misspell(task, "to: goal", "to: gaol")
    misspell(task, "episode_steps: 20", "episode_steps: 0")
    ran = run("fix", str(task), "--yes")
    assert ran.status == 1
    assert "to: goal" in task.read_text()
    assert ran.out.splitlines()[-1].startswith("sound.yaml:4:")
    assert "must be at least" in ran.out.splitlines()[-1]


def test_a_fix_is_in_the_json_of_its_finding(task, run):
    misspell(task, "to: goal", "to: gaol")
    data = run("validate", str(task), "--level", "static", "--json").data
    (finding,) = data["tasks"][0]["findings"]
    place = {key: finding[key] for key in ("file", "line", "column")}
    assert finding["fix"] == {**place, "old": "gaol", "new": "goal"}


def test_a_file_that_has_changed_meanwhile_is_not_written(task):
    misspell(task, "to: goal", "to: gaol")
    fixes = [finding.fix for finding in validate_task(task, level="static").findings]
    (correction,) = correct(fixes)
    task.write_text(task.read_text() + "# more\n")
    with pytest.raises(UsageError, match="has changed meanwhile"):
        correction.write()
    misspell(task, "gaol", "pole")
    with pytest.raises(UsageError, match='there is no "gaol"'):
        correct(fixes)
