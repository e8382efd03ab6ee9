"""A world of each task of the library."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from taskbuilder.task import Task, load_task
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

NAMES = ("handover", "pick_push_place", "collaborative_lift")


@pytest.fixture(scope="session")
def tasks() -> dict[str, Task]:
    return {name: load_task(name) for name in NAMES}


@pytest.fixture(scope="module")
def worlds(tasks: dict[str, Task]) -> Iterator[dict[str, World]]:
    built = {name: build_world(task.file) for name, task in tasks.items()}
    yield built
    for world in built.values():
        world.close()
