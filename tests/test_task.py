"""Whole tasks: found, read, imported and checked in one call."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskbuilder.description import Description
from taskbuilder.errors import FileError, Finding, UnknownNameError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

YAML = """\
task: small
summary: An arm and a cube.
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    cube: {shape: {box: [0.1, 0.1, 0.1]}, mass: 0.1, position: [0.5, 0, 0.05]}
"""

PYTHON = """\
from taskbuilder.description import Bonus, Description, Held


class Small(Description):
    success = Held("cube", by="arm")
    reward = (Bonus("hold", success, 1.0, agent="arm"),)
"""

TASKS = sorted(Catalogue().tasks)


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Writes the small task, with some text replaced, and gives its path."""
    monkeypatch.chdir(tmp_path)

    def _write(*changes: tuple[str, str]) -> Path:
        texts = [YAML, PYTHON]
        for old, new in changes:
            assert sum(old in text for text in texts) == 1, old
            texts = [text.replace(old, new) for text in texts]
        Path("small.yaml").write_text(texts[0])
        Path("small.py").write_text(texts[1])
        return Path("small.yaml")

    return _write


def codes(path: Path) -> list[str]:
    with pytest.raises(FileError) as caught:
        load_task(path)
    return [f"{f.location.file.name}:{f.location.line} {f.code}" for f in caught.value.findings]


@pytest.mark.parametrize("name", TASKS)
def test_every_task_of_the_library_loads_without_a_warning(name):
    task = load_task(name)
    assert task.name == name
    assert task.warnings == ()
    assert issubclass(task.description, Description)


def test_a_task_knows_its_name_agents_and_description(write):
    task = load_task(write())
    assert task.name == "small"
    assert task.agents == ("arm",)
    assert task.description.__name__ == "Small"
    assert task.file.spec.summary == "An arm and a cube."


def test_agents_are_in_the_order_of_the_file():
    assert load_task("handover").agents == ("left", "right")


def test_a_path_may_be_text(write):
    assert load_task(str(write())).name == "small"


def test_a_catalogue_of_one_s_own_is_searched(write, tmp_path):
    write()
    assert load_task("small", catalogue=Catalogue((tmp_path,))).name == "small"
    with pytest.raises(UnknownNameError, match='no task "small"'):
        load_task("small")


def test_what_is_wrong_with_both_files_is_told_in_one_run(write):
    path = write(("mass: 0.1", "mass: heavy"), ("import Bonus", "import Bonnus"))
    assert codes(path) == ["small.py:1 TB208", "small.yaml:7 TB103"]


def test_a_description_is_checked_against_its_scene(write):
    assert codes(write(('"cube", by', '"cub", by'))) == ["small.py:5 TB207"]


ABOVE = (("import Bonus, Description, Held", "import Above, Bonus, Description"),)
WITH_PARTS = (
    "shape: {box: [0.1, 0.1, 0.1]}, mass: 0.1",
    "parts: {lid: {box: [0.1, 0.1, 0.1]}}, mass: 0.1",
)


@pytest.mark.parametrize(
    ("right", "wrong", "code"),
    [
        (", mass: 0.1", "", "TB101"),
        ("mass: 0.1", "mass: heavy", "TB103"),
        ("mass: 0.1", "mass: 0.1, friction: -1", "TB104"),
    ],
)
def test_a_mistake_elsewhere_in_an_object_does_not_hide_a_wrong_part(write, right, wrong, code):
    parts = (WITH_PARTS[0], WITH_PARTS[1].replace(right, wrong))
    path = write(parts, ('Held("cube", by="arm")', 'Above("cube.lit", height=0.1)'), *ABOVE)
    assert codes(path) == ["small.py:5 TB207", f"small.yaml:7 {code}"]


@pytest.mark.parametrize("wrong", ["parts: 3, mass: 0.1", "pats: {lid: {}}, mass: 0.1"])
def test_a_mistake_in_the_parts_themselves_may_hide_a_part(write, wrong):
    changes = ((WITH_PARTS[0], wrong), ('Held("cube", by="arm")', 'Above("cube.lid", height=0.1)'))
    assert {found.split()[0] for found in codes(write(*changes, *ABOVE))} == {"small.yaml:7"}


def test_a_description_whose_robot_is_not_in_the_scene_is_refused(write):
    assert codes(write(('agent="arm"', 'agent="left"'))) == ["small.py:6 TB207"]


def test_a_finding_of_no_expression_is_placed_at_the_class(write):
    path = write(
        ('    success = Held("cube", by="arm")\n', ""), ("success, 1.0", 'Held("cube"), 1')
    )
    assert codes(path) == ["small.py:4 TB210"]


def test_a_task_file_that_is_not_there_is_refused_by_its_path(write):
    write()
    with pytest.raises(
        UnknownNameError, match=r"there is no file smal\.yaml; did you mean small\."
    ):
        load_task("smal.yaml")


def test_warnings_are_kept_and_do_not_forbid_the_task(write, monkeypatch):
    doubt = Finding("TB499", "looks odd", severity="warning")
    monkeypatch.setattr("taskbuilder.task.check_description", lambda *_: [doubt])
    assert load_task(write()).warnings == (doubt,)


def test_a_warning_beside_an_error_is_told_too(write, monkeypatch):
    doubt = Finding("TB499", "looks odd", severity="warning")
    wrong = Finding("TB299", "is wrong")
    monkeypatch.setattr("taskbuilder.task.check_description", lambda *_: [doubt, wrong])
    with pytest.raises(FileError) as caught:
        load_task(write())
    assert {*caught.value.findings} == {doubt, wrong}
