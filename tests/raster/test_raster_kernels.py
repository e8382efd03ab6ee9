"""Where the compiled code of the rasteriser is kept when package and home cannot be written."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import taskbuilder

PACKAGE = Path(taskbuilder.__file__).parent
NOWHERE = "/dev/null/home"
"""No user can make a folder there, the superuser included."""

KERNEL = """\
import logging
from taskbuilder.raster.geometry import *
from taskbuilder.raster.kernels import kernel

@kernel()
def twice(value):
    return 2 * value

print(twice(21))
"""


@pytest.fixture
def unwritable(tmp_path):
    """A copy of the package in which nobody can make a folder of compiled code."""
    copy = tmp_path / "site" / "taskbuilder"
    copy.mkdir(parents=True)
    for part in PACKAGE.iterdir():
        if part.name != "raster":
            (copy / part.name).symlink_to(part.resolve())
    shutil.copytree(
        PACKAGE / "raster", copy / "raster", ignore=shutil.ignore_patterns("__pycache__")
    )
    (copy / "raster" / "__pycache__").touch()
    (copy.parent / "__pycache__").touch()
    return copy.parent


def run(unwritable, temporary, *arguments, folder=None):
    """Runs Python where package and home cannot be written."""
    kept = {"PATH", "LANG", "SYSTEMROOT", "COVERAGE_PROCESS_START"}
    env = {key: value for key, value in os.environ.items() if key in kept}
    env |= {
        "HOME": NOWHERE,
        "XDG_CACHE_HOME": f"{NOWHERE}/cache",
        "XDG_CONFIG_HOME": f"{NOWHERE}/config",
        "PYTHONPATH": str(unwritable),
        "PYTHONDONTWRITEBYTECODE": "1",
        "TMPDIR": str(temporary),
    }
    return subprocess.run(
        [sys.executable, *arguments],
        env=env,
        cwd=folder or unwritable.parent,
        capture_output=True,
        text=True,
        check=False,
    )


def test_compiled_code_is_kept_in_a_temporary_folder_of_the_user_alone(unwritable, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    (unwritable / "kernels.py").write_text(KERNEL)
    for _ in range(2):
        done = run(unwritable, temporary, unwritable / "kernels.py")
        assert (done.stdout, done.stderr) == ("42\n", "")
    (folder,) = temporary.iterdir()
    assert folder.stat().st_mode & 0o077 == 0
    assert len(list(folder.rglob("*.nbc"))) == 1


@pytest.mark.parametrize("trouble", ["of another", "a file"])
def test_without_one_it_is_left_out_with_a_line(trouble, unwritable, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    place = temporary / f"taskbuilder-kernels-{os.getuid()}"
    if trouble == "a file":
        place.touch()
    else:  # others can write there, so nothing in it is run
        place.mkdir()
        place.chmod(0o777)
    (unwritable / "kernels.py").write_text(KERNEL)
    done = run(unwritable, temporary, unwritable / "kernels.py")
    assert done.stdout == "42\n"
    (line,) = done.stderr.splitlines()
    assert "set NUMBA_CACHE_DIR to a folder that can be written" in line
    assert trouble == "a file" or not list(place.iterdir())


@pytest.mark.slow
def test_pictures_are_drawn(unwritable, tmp_path):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    done = run(
        unwritable, temporary, "-m", "taskbuilder", "render", "reach", "--out", tmp_path / "out"
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert len(list((tmp_path / "out").glob("*.png"))) == 3
