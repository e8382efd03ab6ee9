"""Everything a person can do wrong, and exactly what is said of it.

After a message has changed: ``pytest tests/bad_input --update-golden``, then review the files.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import IO

import pytest
from golden import HERE, read_case

from taskbuilder.cli import main
from taskbuilder.description.load import try_import
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry

pytestmark = pytest.mark.in_process

GENEROUS_S = 30.0
LEAST = {"tasks": 85, "robots": 35, "commands": 35}

TASKS = Catalogue.discover().tasks["handover"].file.parent
ROBOTS = Catalogue.discover().robots["ur5e"].file.parents[1]

CASES = [path for folder in LEAST for path in sorted((HERE / folder).glob("*.txt"))]

_COLUMN = re.compile(r"^(  [ a-z]+ (?:ok  |FAIL)) +\d+\.\d s  ", re.MULTILINE)  # 9.9 s or 10.0 s
_TIMES = re.compile(
    r"(  ) *\d+\.\d( s)$|\b\d+\.\d+( m?s)\b|(?<= in )\d+( s)$", re.MULTILINE
)  # whole seconds, from ten on
_tried: set[bytes] = set()


def _try_import_once(entry: CatalogueEntry) -> None:
    """Most cases have the same description; its trial in a child process need not recur."""
    file = entry.description_file
    content = file.read_bytes() if file.is_file() else b""
    if content not in _tried:
        try_import(entry)
        _tried.add(content)


@pytest.fixture(scope="session")
def cache_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def folder(tmp_path: Path, cache_folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    desk = tmp_path / "desk"
    desk.mkdir()
    monkeypatch.chdir(desk)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache_folder))
    monkeypatch.delenv("TASKBUILDER_PATH", raising=False)
    monkeypatch.setattr("taskbuilder.task.try_import", _try_import_once)
    return desk


@contextmanager
def everything_printed() -> Iterator[IO[bytes]]:
    """What is written to standard output and error, in order, by Python or by C."""
    with tempfile.TemporaryFile() as file, ExitStack() as stack:
        for descriptor in (1, 2):
            copy = os.dup(descriptor)
            stack.callback(os.close, copy)
            stack.callback(os.dup2, copy, descriptor)
            os.dup2(file.fileno(), descriptor)
        out, err = (
            stack.enter_context(open(number, "w", buffering=1, encoding="utf-8", closefd=False))
            for number in (1, 2)
        )
        with redirect_stdout(out), redirect_stderr(err):
            yield file


def _cpu_s() -> float:
    """CPU time of this process and its ended children, which does not grow with the load."""
    return sum(os.times()[:4])


def _same_everywhere(text: str, folder: Path) -> str:
    """What is printed, without what depends on the machine."""
    for path, word in ((folder, "FOLDER"), (TASKS, "TASKS"), (ROBOTS, "ROBOTS")):
        text = text.replace(f"{path}/", f"{word}/")
    text = _COLUMN.sub(r"\1    0.0 s  ", text)
    return _TIMES.sub(lambda found: f"{found[1] or ''}0.0{found[2] or found[3] or found[4]}", text)


@pytest.mark.parametrize("file", CASES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_a_mistake_is_explained(
    file: Path, folder: Path, monkeypatch: pytest.MonkeyPatch, update_golden: bool
) -> None:
    case = read_case(file)
    case.write(folder)
    for name, value in case.environment.items():
        monkeypatch.setenv(name, value)
    modules = set(sys.modules)
    started = _cpu_s()
    with everything_printed() as output:
        status = main(case.words)
        sys.stdout.flush()
        output.seek(0)
        printed = output.read().decode()
    seconds = _cpu_s() - started
    for name in set(sys.modules) - modules:
        if name.startswith("taskbuilder_task_"):
            del sys.modules[name]
    shown = _same_everywhere(printed, folder)
    if update_golden:
        case.update(status, shown)
    else:
        assert shown == case.expected
        assert status == case.exit
    assert status in (0, 1, 2)
    assert "Traceback" not in printed
    assert "defect of taskbuilder" not in printed
    assert seconds < GENEROUS_S


@pytest.mark.parametrize("kind", LEAST)
def test_there_are_cases_of_every_kind(kind: str) -> None:
    assert sum(file.parent.name == kind for file in CASES) >= LEAST[kind]
