"""Which package provides the physics engine, and on which systems the library works."""

from __future__ import annotations

import configparser
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from taskbuilder.engine import PACKAGES, engine_file, engine_versions
from taskbuilder.geometry import total

ROOT = Path(__file__).resolve().parents[1]


def engines(system: str, machine: str, python: str) -> list[str]:
    """The packages with the engine that pip would install there."""
    setup = configparser.ConfigParser()
    setup.read(ROOT / "setup.cfg")
    lines = [line for line in setup["options"]["install_requires"].splitlines() if line]
    required = [Requirement(line) for line in lines]
    place = {
        "platform_system": system,
        "platform_machine": machine,
        "python_version": python,
    }
    return [
        each.name
        for each in required
        if each.name in PACKAGES and (each.marker is None or each.marker.evaluate(place))
    ]


@pytest.mark.parametrize(
    ("system", "machine", "python", "package"),
    [
        ("Linux", "x86_64", "3.11", "pybullet"),
        ("Linux", "x86_64", "3.12", "pybullet-arm64"),
        ("Linux", "x86_64", "3.13", "pybullet-arm64"),
        ("Linux", "x86_64", "3.14", "pybullet"),
        ("Linux", "aarch64", "3.11", "pybullet"),
        ("Linux", "aarch64", "3.13", "pybullet"),
        ("Darwin", "arm64", "3.11", "pybullet-arm64"),
        ("Darwin", "arm64", "3.13", "pybullet-arm64"),
        ("Windows", "AMD64", "3.12", "pybullet-arm64"),
    ],
)
def test_the_engine_has_a_wheel_wherever_somebody_publishes_one(system, machine, python, package):
    assert engines(system, machine, python) == [package]


def test_exactly_one_engine_is_required_everywhere():
    systems = ("Linux", "Darwin", "Windows", "FreeBSD")
    machines = ("x86_64", "AMD64", "aarch64", "arm64")
    pythons = ("3.11", "3.12", "3.13", "3.14", "3.15")
    for place in product(systems, machines, pythons):
        assert len(engines(*place)) == 1, place


def test_the_constraints_pin_both_packages():
    pins = (ROOT / "constraints.txt").read_text().splitlines()
    assert [pin.split("==")[0] for pin in pins if pin.split("==")[0] in PACKAGES] == list(PACKAGES)


def test_one_package_provides_the_engine_here():
    assert len(engine_versions()) == 1
    assert engine_file().is_file()


def taskbuilder(code: str, *folders: Path) -> subprocess.CompletedProcess[str]:
    """Run code that may look for packages in further folders first."""
    path = f"import sys; sys.path[:0] = {[str(folder) for folder in folders]!r}; "
    command = [sys.executable, "-c", path + code]
    return subprocess.run(command, capture_output=True, text=True, check=False)


RENDER = "from taskbuilder.cli import main; sys.exit(main(['render', 'reach', '--out', {!r}]))"


def test_two_packages_with_the_engine_are_refused_with_what_to_do(tmp_path):
    for name in PACKAGES:
        told = tmp_path / f"{name.replace('-', '_')}-9.9.dist-info"
        told.mkdir()
        (told / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 9.9\n")
    ran = taskbuilder(RENDER.format(str(tmp_path)), tmp_path)
    assert (ran.returncode, ran.stderr) == (
        1,
        "taskbuilder: pybullet 9.9 and pybullet-arm64 9.9 are both installed, and each overwrites "
        "the other's files; run `pip uninstall -y pybullet pybullet-arm64`, then install "
        "taskbuilder again\n",
    )


def test_a_missing_engine_is_named_with_what_to_do(tmp_path):
    hide = (
        "from importlib.machinery import PathFinder; find = PathFinder.find_spec; "
        "PathFinder.find_spec = classmethod(lambda cls, name, *where: None "
        "if name == 'pybullet' else find(name, *where)); "
    )
    ran = taskbuilder(hide + RENDER.format(str(tmp_path)))
    assert (ran.returncode, ran.stderr) == (
        1,
        "taskbuilder: the physics engine is not installed; install taskbuilder again with pip, "
        "which chooses between pybullet and pybullet-arm64 for this version of Python\n",
    )


def test_one_process_needs_no_posix(tmp_path):
    script = Path(__file__).with_name("elsewhere.py")
    command = [sys.executable, str(script), str(tmp_path)]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert (tmp_path / "reach-sheet.png").is_file()
    assert (tmp_path / "run" / "policy.npz").is_file()


COMPENSATED = """
import builtins, math
plain = builtins.sum

def compensated(values, /, start=0):
    values = list(values)
    if any(isinstance(value, float) for value in values):
        return start + math.fsum(values)
    return plain(values, start)

builtins.sum = compensated
"""

EPISODE = """
import hashlib, json, taskbuilder
played = taskbuilder.Expert(taskbuilder.parallel_env({task!r})).play(seed=0)
arrays = [played.rewards, *played.terms.values(), *played.actions.values(), played.progress]
print(played.success, hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest())
"""


@pytest.mark.parametrize("task", ["handover", pytest.param("ring_pass", marks=pytest.mark.slow)])
def test_an_episode_does_not_depend_on_how_python_adds(task):
    episode = EPISODE.format(task=task)
    ran = [taskbuilder(code) for code in (episode, COMPENSATED + episode)]
    assert [each.stderr for each in ran] == ["", ""]
    assert ran[0].stdout == ran[1].stdout
    assert ran[0].stdout.startswith("True ")


def test_a_total_is_added_from_left_to_right():
    assert total([0.1] * 10) == 0.9999999999999999  # sum() gives 1.0 from Python 3.12 on
    assert total([]) == 0.0
