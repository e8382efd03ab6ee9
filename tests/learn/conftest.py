"""Tests of training are skipped without PyTorch, which the extra "test" leaves out."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

TRAINING = (
    *("test_bc.py", "test_maddpg.py", "test_maddpg_openai.py", "test_networks.py"),
    *("test_training.py",),
)


class Training(pytest.Module):
    """A module of tests that is skipped where PyTorch is not installed."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        pytest.importorskip("torch")
        return super().collect()


def pytest_pycollect_makemodule(
    module_path: Path, parent: pytest.Collector
) -> pytest.Module | None:
    return Training.from_parent(parent, path=module_path) if module_path.name in TRAINING else None
