"""`taskbuilder new`: what it writes is sound as it is."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from taskbuilder import validate_task

COUNTS = range(1, 7)
LONGEST_DESCRIPTION = 25


@pytest.mark.parametrize("count", COUNTS)
def test_a_new_task_is_sound_without_a_warning(count, run, tmp_path):
    ran = run("new", "stack_cubes", "--robots", str(count))
    assert (ran.status, ran.err) == (0, "")
    level = "full" if count <= 2 else "build"  # more robots are more of the same
    report = validate_task(tmp_path / "stack_cubes.yaml", level=level, seeds=5)
    assert report.ok
    assert report.findings == ()
    assert f"{count} robot" in report.headline


def test_the_test_of_a_new_task_passes(run, tmp_path):
    run("new", "alone", "--robots", "1")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout


def test_it_says_what_it_wrote_and_what_comes_next(run):
    ran = run("new", "stack", "--dir", "tasks/mine")
    written = [f"tasks/mine/{name}" for name in ("stack.yaml", "stack.py", "test_stack.py")]
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
