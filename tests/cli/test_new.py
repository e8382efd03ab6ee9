"""`taskbuilder new`: what it writes is sound as it is."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest
import yaml

from taskbuilder import load_task, validate_task
from taskbuilder.visual.still import take_still
from taskbuilder.world.building import build_world

COUNTS = (1, 2, 6)
LONGEST_DESCRIPTION = 35


@pytest.mark.parametrize("count", COUNTS)
def test_a_new_task_is_sound_without_a_warning(count, run, tmp_path):
    ran = run("new", "stack_cubes", "--robots", str(count))
    assert (ran.status, ran.err) == (0, "")
    level = "full" if count == 2 else "build"  # more robots are more of the same
    report = validate_task(tmp_path / "stack_cubes.yaml", level=level, seeds=2)
    assert report.ok
    assert report.findings == ()
    assert f"{count} robot" in report.headline


@pytest.mark.slow
def test_the_test_of_a_new_task_passes(run, tmp_path):
    run("new", "alone", "--robots", "1")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout


def test_it_says_what_it_wrote_and_what_comes_next(run):
    ran = run("new", "stack", "--dir", "tasks/mine")
    written = [
        f"tasks/mine/{name}"
        for name in ("stack.yaml", "stack.py", "test_stack.py", "task.schema.json")
    ]
    assert ran.out.splitlines() == [
        *written,
        "",
        "next: taskbuilder validate tasks/mine/stack.yaml",
    ]
    assert all(Path(file).is_file() for file in written)


def test_the_description_is_short_and_its_class_named_after_the_task(run, tmp_path):
    run("new", "stack_cubes")
    text = (tmp_path / "stack_cubes.py").read_text()
    assert text.count("\n") <= LONGEST_DESCRIPTION
    (cls,) = [node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    assert cls.name == "StackCubes"


def test_nothing_is_written_where_one_of_the_files_exists(run, tmp_path):
    (tmp_path / "test_stack.py").write_text("mine")
    assert run("new", "stack").status == 2
    assert [file.name for file in tmp_path.iterdir()] == ["test_stack.py"]
    assert (tmp_path / "test_stack.py").read_text() == "mine"


def test_editors_find_the_schema_which_the_task_obeys(run, tmp_path):
    run("new", "stack")
    text = (tmp_path / "stack.yaml").read_text()
    first, file = text.splitlines()[0].split("=")
    assert first == "# yaml-language-server: $schema"
    schema = json.loads((tmp_path / file).read_text())
    assert schema == run("schema", "task").data
    jsonschema.validate(yaml.safe_load(text), schema)
    wrong = yaml.safe_load(text.replace("control_hz", "control_herz"))
    with pytest.raises(jsonschema.ValidationError, match="control_herz"):
        jsonschema.validate(wrong, schema)


def test_a_second_task_in_a_folder_shares_the_schema(run, tmp_path):
    run("new", "one")
    (tmp_path / "task.schema.json").write_text("mine")
    ran = run("new", "two")
    assert ran.out.splitlines()[:3] == ["two.yaml", "two.py", "test_two.py"]
    assert (tmp_path / "task.schema.json").read_text() == "mine"
    assert "$schema=task.schema.json" in (tmp_path / "two.yaml").read_text()


@pytest.mark.parametrize("count", COUNTS)
def test_the_close_camera_sees_the_gripper_and_the_cube_large(count, run, tmp_path):
    run("new", "stack", "--robots", str(count))
    world = build_world(load_task(tmp_path / "stack.yaml").file)
    world.reset(0)
    still = take_still(world, "close", (160, 120))
    robot = next(iter(world.robots))
    for name, share in (("cube", 0.002), (robot, 0.05)):
        assert still.image.shows(name).mean() > share, name
    world.close()


@pytest.mark.parametrize("sort", ["task", "robot"])
def test_every_key_of_the_schema_says_what_it_means(sort, run):
    def silent(part, path):
        if isinstance(part, dict):
            for key, said in part.get("properties", {}).items():
                if not said.get("description", "").endswith("."):
                    yield f"{path}.{key}"
            for key, inner in part.items():
                yield from silent(inner, f"{path}/{key}")
        elif isinstance(part, list):
            for index, inner in enumerate(part):
                yield from silent(inner, f"{path}[{index}]")

    assert not list(silent(run("schema", sort).data, sort))
