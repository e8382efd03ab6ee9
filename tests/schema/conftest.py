"""Task files in a folder of their own, which is the working directory, so that paths are short."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from task_texts import PLAIN

from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import TaskFile, read_task
from taskbuilder.schema.source import Source, read_source

CATALOGUE = Catalogue()


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("TASKBUILDER_PATH", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def source(folder: Path) -> Callable[[str | bytes], Source]:
    """Reads a text as a YAML file, ``a.yaml``."""

    def read(text: str | bytes) -> Source:
        path = Path("a.yaml")
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_source(path)

    return read


@pytest.fixture
def load(folder: Path) -> Callable[..., TaskFile]:
    """Loads the plain task, ``plain.yaml``, with some of its text replaced."""

    def read(*changes: tuple[str, str]) -> TaskFile:
        text = PLAIN
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path = folder / "plain.yaml"
        path.write_text(text, encoding="utf-8")
        return read_task(CATALOGUE.task(str(path)), CATALOGUE)

    return read


@pytest.fixture
def findings(load: Callable[..., TaskFile]) -> Callable[..., list[str]]:
    """What is found wrong with the plain task when some of its text is replaced."""

    def read(*changes: tuple[str, str]) -> list[str]:
        try:
            task = load(*changes)
        except FileError as error:
            return [str(finding).replace("plain.yaml:", "") for finding in error.findings]
        assert not task.warnings
        return []

    return read
