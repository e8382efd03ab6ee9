"""Exported data sets in LeRobot, robomimic and Minari, which `make data-interop` installs.

Where a library is not installed, its tests are not collected here.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import pytest

collect_ignore_glob = [
    f"in_{library}/*.py"
    for library in ("lerobot", "robomimic", "minari")
    if importlib.util.find_spec(library) is None
]

EPISODES, SIZE = 4, 96
CAMERAS = ("front", "left_wrist")


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """A data set of handover with two cameras, which `taskbuilder collect` recorded."""
    folder = tmp_path_factory.mktemp("recorded") / "handover"
    words = ["collect", "handover", "--episodes", str(EPISODES), "--cameras", ",".join(CAMERAS)]
    taskbuilder(*words, "--size", str(SIZE), "--out", str(folder))
    return folder


@pytest.fixture(scope="session")
def export(recorded, tmp_path_factory):
    """Exports it in a format."""

    def exported(form):
        folder = tmp_path_factory.mktemp(form) / "handover"
        taskbuilder("dataset", "export", str(recorded), "--format", form, "--out", str(folder))
        return folder

    return exported


def taskbuilder(*words):
    subprocess.run([sys.executable, "-m", "taskbuilder", *words], check=True)
