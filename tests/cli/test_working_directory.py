"""Files beside a task that are called as modules are not imported in their place."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import taskbuilder

START = """\
import sys
from taskbuilder.cli import main
if __name__ == "__main__":
    sys.exit(main())
"""
MARK = "open({marks!r}, 'a').write({name!r} + '\\n')\n"
ASSET = """\
<robot name="block"><link name="block"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link></robot>
"""
SMALL = ("--size", "32x24")


@pytest.fixture
def shadowed(good: Path, tmp_path: Path) -> Path:
    """Fills the task's folder with modules; gives the file in which those that ran are."""
    marks = tmp_path / "elsewhere" / "marks"
    marks.parent.mkdir()
    (marks.parent / "start.py").write_text(START)
    names = {*sys.stdlib_module_names, "numpy", "pydantic", "yaml", "pybullet", "taskbuilder"}
    for name in names - {"good"}:
        (tmp_path / f"{name}.py").write_text(MARK.format(marks=str(marks), name=name))
    (tmp_path / "block.urdf").write_text(ASSET)
    text = good.read_text().replace(
        "shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1", "shape: {urdf: block.urdf}"
    )
    assert "block.urdf" in text
    good.write_text(text)
    return marks


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("validate", "good.yaml", "--seeds", "2", "--jobs", "2"),
        ("render", "good.yaml", "--renderer", "auto", *SMALL),
        ("demo", "good.yaml", "--policy", "random", "--episodes", "2", "--jobs", "2", *SMALL),
    ],
    ids=lambda words: words[0],
)
def test_no_process_of_a_command_looks_for_modules_in_the_working_directory(
    words, shadowed, tmp_path, monkeypatch
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))  # the asset is probed anew
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    command = [sys.executable, str(shadowed.parent / "start.py"), *words]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert not shadowed.exists(), f"{sorted(set(shadowed.read_text().split()))}\n{done.stderr}"
    assert done.returncode in (0, 1), done.stderr  # what chance plays fails
    assert done.stderr == ""


@pytest.mark.parametrize("workers", [0, 2])
def test_no_worker_of_a_vector_does(workers, shadowed, tmp_path):
    code = f"""\
import sys
sys.path.remove("")  # as a script has it
import taskbuilder
if __name__ == "__main__":
    envs = taskbuilder.make_vec("good.yaml", 2, workers={workers})
    envs.reset(seed=0)
    envs.close()
"""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert not shadowed.exists()
    assert (done.returncode, done.stderr) == (0, "")


ELSEWHERE = """\
import sys, taskbuilder
from taskbuilder.jobs import workers
if __name__ == "__main__":
    with workers(2) as spread:
        files = list(spread(eval, ["__import__('taskbuilder').__file__"] * 2))
        print(*{taskbuilder.__file__, *files}, sep="\\n")
"""


def test_processes_use_the_package_of_the_one_that_starts_them(tmp_path):
    """As in a checkout beside an installation, where the working directory comes last."""
    package = Path(taskbuilder.__file__).parent
    copied = tmp_path / "taskbuilder"
    shutil.copytree(package, copied, ignore=shutil.ignore_patterns("models", "__pycache__"))
    command = [sys.executable, "-c", ELSEWHERE]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False
    )
    assert done.stdout.split() == [str(copied / "__init__.py")], done.stderr
