"""A client, for the tests that compare with the simulation."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from taskbuilder.sim.client import Client


@pytest.fixture
def client() -> Iterator[Client]:
    with Client(physics_hz=120) as opened:
        yield opened
