"""Commands run in this process, in an empty folder."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from taskbuilder.cli import main


@dataclass(frozen=True)
class Ran:
    """What a command left behind."""

    status: int
    out: str
    err: str

    @property
    def data(self) -> Any:
        """Standard output, which must be JSON and nothing else."""
        return json.loads(self.out)


Run = Callable[..., Ran]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    """Run `taskbuilder` with some words, and read what it printed, C libraries included."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.delenv("TASKBUILDER_PATH", raising=False)

    def run_command(*words: str) -> Ran:
        capfd.readouterr()
        status = main(words)
        printed = capfd.readouterr()
        return Ran(status, printed.out, printed.err)

    return run_command


GOOD = """\
task: good
summary: One arm lifts a cube.
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0, 0.02]}
variations:
  - {cube.color: green}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Good(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
"""


@pytest.fixture
def good(tmp_path: Path) -> Path:
    """A small sound task, good.yaml, with one variation."""
    (tmp_path / "good.py").write_text(DESCRIPTION)
    file = tmp_path / "good.yaml"
    file.write_text(GOOD)
    return file


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """The same with a mass that is none, broken.yaml."""
    (tmp_path / "broken.py").write_text(DESCRIPTION)
    file = tmp_path / "broken.yaml"
    file.write_text(GOOD.replace("task: good", "task: broken").replace("0.1,", "heavy,"))
    return file
