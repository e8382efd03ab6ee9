"""Commands as processes: how they start, and how they end when they are cut short."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import pytest

from taskbuilder import __version__

ROOT = Path(__file__).resolve().parents[2]
MODULE = (sys.executable, "-m", "taskbuilder")

_SAYS_WHAT_IT_IMPORTED = (
    "import sys; from taskbuilder.cli import main; status = main(sys.argv[1:]); "
    "names = {name.partition('.')[0] for name in sys.modules}; "
    "heavy = {'pybullet', 'numpy', 'torch', 'cv2', 'pydantic', 'yaml', 'gymnasium', 'matplotlib'}; "
    "heavy |= {'PIL', 'jinja2', 'difflib', 'traceback'}; "
    "print(*sorted(names & heavy), file=sys.stderr); sys.exit(status)"
)

LIGHT = {"difflib", "traceback"}


def imported_by(*words: str, cwd: Path) -> set[str]:
    command = [sys.executable, "-c", _SAYS_WHAT_IT_IMPORTED, *words]
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=True)
    return set(done.stderr.split())


def wait_for(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


def loaded_pybullet(child: subprocess.Popen) -> bool:
    """Whether a child of a command plays: the command itself never loads physics."""
    listed = Path(f"/proc/{child.pid}/task/{child.pid}/children").read_text().split()
    return any("pybullet" in Path(f"/proc/{pid}/maps").read_text() for pid in listed)


@pytest.mark.parametrize("start", [MODULE, (sys.executable, str(ROOT / "cli.py"))])
def test_it_starts_as_a_module_and_from_a_checkout(start, tmp_path):
    done = subprocess.run([*start, "--version"], capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"taskbuilder {__version__}\n")


def test_help_imports_nothing_heavy(tmp_path):
    assert imported_by("--help", cwd=tmp_path) == set()


def test_a_static_check_needs_no_physics(good):
    imported = imported_by("validate", "good.yaml", "--level", "static", cwd=good.parent)
    assert imported - LIGHT == {"pydantic", "yaml"}


@pytest.mark.parametrize("words", [("list",), ("list", "--json"), ("--version",)], ids=" ".join)
def test_listing_and_the_version_import_nothing_that_takes_time(words, tmp_path):
    assert imported_by(*words, cwd=tmp_path) == set()


def test_listing_reads_the_tasks_that_no_index_has(good):
    assert imported_by("list", "--task-path", ".", cwd=good.parent) >= {"pydantic", "yaml"}


needs_proc = pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="no /proc here")


@needs_proc
def test_ctrl_c_ends_a_validation_with_130(tmp_path):
    command = [*MODULE, "validate", "handover", "--seeds", "100000"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as child:
        wait_for(lambda: loaded_pybullet(child))
        time.sleep(0.3)
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=30)
    assert (child.returncode, err) == (130, "interrupted\n")


@needs_proc
def test_ctrl_c_leaves_no_half_written_picture(tmp_path):
    command = [*MODULE, "render", "--suite", "seed", "--size", "800x600", "--renderer", "tiny"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as child:
        wait_for(lambda: list(tmp_path.glob("renders/*")))
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=30)
    assert (child.returncode, err) == (130, "interrupted\n")
    for file in (tmp_path / "renders").iterdir():
        assert file.suffix == ".png"
        assert not file.name.startswith(".")
        assert cv2.imread(str(file)) is not None


_INTERRUPTED_IN_A_STRING = """\
import sys
from taskbuilder import cli
cli.parse = lambda words: exec("raise KeyboardInterrupt")
sys.exit(cli.main([]))
"""


def test_ctrl_c_while_python_executes_a_string_ends_with_130_too(tmp_path):
    """Modules with dataclasses or namedtuples execute strings while they are imported."""
    (tmp_path / "interrupted.py").write_text(_INTERRUPTED_IN_A_STRING)
    command = [sys.executable, "-m", "interrupted"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")


_INTERRUPTED_IN_A_FINALIZER = """\
import signal, sys, time
from taskbuilder import cli

class Closing:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

def work(words):
    Closing()
    time.sleep(30)

cli.parse = work
sys.exit(cli.main([]))
"""


def test_ctrl_c_while_python_frees_something_ends_with_130_too(tmp_path):
    """Python drops what is raised there, and so would never end."""
    (tmp_path / "interrupted.py").write_text(_INTERRUPTED_IN_A_FINALIZER)
    command = [sys.executable, "-m", "interrupted"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=20)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")


@pytest.mark.parametrize("words", [("--help",), ("list",), ("schema", "task")])
def test_a_reader_that_has_seen_enough_is_no_error(words, tmp_path):
    end, start = os.pipe()
    os.close(end)
    done = subprocess.run(
        [*MODULE, *words], stdout=start, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    os.close(start)
    assert (done.returncode, done.stderr) == (0, "")
