"""A suite of two tasks that are quickly played, and a track that is quickly run."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_benchmarks import write_suite

from taskbuilder.schema.catalogue import Catalogue


@pytest.fixture(scope="session")
def catalogue(tmp_path_factory: pytest.TempPathFactory) -> Catalogue:
    """A catalogue with the suite `few`: `sideways`, and `lonely`, which has no expert."""
    return Catalogue.discover([str(write_suite(tmp_path_factory.mktemp("few")))])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where a benchmark goes."""
    return tmp_path / "out"
