"""One environment for all films."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from film_scenes import sideways, write_scene

from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.rollout import Rollout


@pytest.fixture(scope="session")
def env(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TaskEnv]:
    made = parallel_env(write_scene(tmp_path_factory.mktemp("scene")))
    yield made
    made.close()


@pytest.fixture(scope="session")
def episode(env: TaskEnv) -> Rollout:
    """Ten control steps, which reach both stages."""
    return sideways(env)
