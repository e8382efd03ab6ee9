"""Robots of the library, each in a PyBullet client of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pybullet
import pytest
from loaded_robot import LoadedRobot, load_robot


@pytest.fixture
def load() -> Iterator[Callable[[str], LoadedRobot]]:
    loaded: list[LoadedRobot] = []

    def load_and_remember(name: str) -> LoadedRobot:
        loaded.append(load_robot(name))
        return loaded[-1]

    yield load_and_remember
    for robot in loaded:
        pybullet.disconnect(physicsClientId=robot.client)
