"""Small tasks to validate: one that is sound, and the same with something changed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from proof_tasks import DESCRIPTION as PAIR_DESCRIPTION
from proof_tasks import PAIR

from taskbuilder import validate_task
from taskbuilder.validate.report import TaskReport

TASK = """\
task: small
summary: One arm lifts a cube.
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    cube:
      shape: {box: [0.04, 0.04, 0.04]}
      mass: 0.1
      place: {center: [0.5, 0, 0.0205], size: [0.1, 0.1, 0]}
  sites:
    goal: {position: [0.5, 0, 0.3]}
  cameras:
    front: {position: [0, -2, 1], look_at: [0, 0, 0.3]}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Below, Bonus, Description, condition


class Small(Description):
    success = Above("cube", height=0.2)
    failure = Below("cube", height=-0.1)
    reward = (Bonus("done", success, 1.0),)
"""

Validate = Callable[..., TaskReport]


def _write(folder: Path, name: str, texts: dict[str, str], changes: tuple[tuple[str, str], ...]):
    """Write a task's files with texts replaced, each in the file that has it."""
    for old, new in changes:
        (ending,) = [ending for ending, text in texts.items() if old in text]
        texts[ending] = texts[ending].replace(old, new)
    for ending, text in texts.items():
        (folder / f"{name}{ending}").write_text(text)
    return folder / f"{name}.yaml"


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write the small task with texts replaced, in either of its files, or added at the end."""

    def write_task(*changes: tuple[str, str], add: str = "") -> Path:
        return _write(tmp_path, "small", {".yaml": TASK + add, ".py": DESCRIPTION}, changes)

    return write_task


@pytest.fixture
def write_pair(tmp_path: Path) -> Callable[..., Path]:
    """Write the task for two arms with texts replaced, or with lines added to its description."""

    def write_task(*changes: tuple[str, str], add: str = "") -> Path:
        return _write(tmp_path, "pair", {".yaml": PAIR, ".py": PAIR_DESCRIPTION + add}, changes)

    return write_task


@pytest.fixture
def validate(write: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> Validate:
    """Validate the small task with some texts replaced, without a trial in a child process."""
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)

    def validate_changed(*changes: tuple[str, str], add: str = "", **options: Any) -> TaskReport:
        asked = {"seeds": 3, "level": "build"} | options
        return validate_task(write(*changes, add=add), **asked)

    return validate_changed


@pytest.fixture
def prove(write_pair: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> Validate:
    """Validate the task for two arms with some texts replaced, by some families."""
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)

    def validate_changed(
        *changes: tuple[str, str], only: tuple[str, ...], add: str = "", seeds: int = 1
    ) -> TaskReport:
        return validate_task(write_pair(*changes, add=add), seeds=seeds, only=only)

    return validate_changed
