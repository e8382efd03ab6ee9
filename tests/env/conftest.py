"""Environments of tasks that the tests write."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from env_tasks import Make, write_task

from taskbuilder.env.parallel import TaskEnv, parallel_env


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Makes environments of task texts, in a folder each, or of tasks of the library."""
    made: list[TaskEnv] = []
    folders = (tmp_path / f"made{number}" for number in count())

    def make_env(
        text: str,
        description: str | None = None,
        *,
        files: Mapping[str, str] | None = None,
        **options: Any,
    ) -> TaskEnv:
        task: str | Path = text
        if "\n" in text:
            folder = next(folders)
            folder.mkdir()
            for name, content in (files or {}).items():
                (folder / name).write_text(content, encoding="utf-8")
            task = write_task(folder, text, description)
        made.append(parallel_env(task, **options))
        return made[-1]

    yield make_env
    for env in made:
        env.close()
