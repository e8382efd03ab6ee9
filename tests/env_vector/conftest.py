"""Vectors of environments, closed when a test is over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from vector_tasks import alive, write_task

from taskbuilder.env.vector import TaskVectorEnv, make_vec

MakeVec = Callable[..., TaskVectorEnv]


@pytest.fixture
def task_file(tmp_path: Path) -> Path:
    """The small task."""
    return write_task(tmp_path)


@pytest.fixture
def vec(task_file: Path) -> Iterator[MakeVec]:
    """Makes vectors of the small task's environments; no worker may outlive them."""
    made: list[TaskVectorEnv] = []

    def make(num_envs: int, workers: int = 0, **options: Any) -> TaskVectorEnv:
        made.append(make_vec(task_file, num_envs, workers, **options))
        return made[-1]

    yield make
    for env in made:
        pids = env.worker_pids
        env.close()
        assert not any(map(alive, pids))
