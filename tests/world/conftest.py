"""Worlds on real physics, built from task files that the tests write."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from written_tasks import NAMES, read

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.load import read_task
from taskbuilder.world.building import build_world
from taskbuilder.world.world import World

Build = Callable[..., World]


@pytest.fixture
def build(tmp_path: Path) -> Iterator[Build]:
    """Builds worlds of task texts; files they name lie in ``tmp_path``."""
    worlds: list[World] = []

    def build_text(text: str, *, variation: int = 0) -> World:
        worlds.append(build_world(read(tmp_path, text), variation=variation))
        return worlds[-1]

    yield build_text
    for world in worlds:
        world.close()


@pytest.fixture(scope="module")
def library() -> Iterator[dict[str, World]]:
    """A world of each task of the library."""
    catalogue = Catalogue.discover()
    worlds = {name: build_world(read_task(catalogue.task(name), catalogue)) for name in NAMES}
    yield worlds
    for world in worlds.values():
        world.close()
