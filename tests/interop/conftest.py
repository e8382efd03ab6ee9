"""Environments under the learning libraries; run by `make interop`, which installs those.

Where they are not installed nothing is collected here.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

if importlib.util.find_spec("torchrl") is None:
    collect_ignore_glob = ["test_*.py"]

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))

# What the libraries warn of, and why that is none of our concern; everything else is an error.
EXCUSED = {
    "PettingZoo in TorchRL is tested using version": "tested for with 1.24.3; newer ones work",
}
RAYS_OWN = (
    # RLlib calls deprecated functions of its own, of PyTorch and of NumPy
    "ignore::DeprecationWarning",
    "ignore::FutureWarning",
    # and leaves sockets and files to the garbage collector
    "ignore::ResourceWarning",
    "ignore::pytest.PytestUnraisableExceptionWarning",
)


BENCHMARLS_OWN = (
    # BenchMARL calls deprecated parts of TorchRL
    "ignore::DeprecationWarning",
    "ignore::UserWarning",
)


OF_OTHERS = {"test_rllib.py": RAYS_OWN, "test_benchmarl.py": BENCHMARLS_OWN}


def pytest_configure(config: pytest.Config) -> None:
    for message in EXCUSED:
        config.addinivalue_line("filterwarnings", f"ignore:{message}")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        for line in OF_OTHERS.get(item.path.name, ()):
            item.add_marker(pytest.mark.filterwarnings(line))
