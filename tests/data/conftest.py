"""Small data sets, collected once for all tests of a session; tests that change one copy it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from own_task import DESCRIPTION, GOOD

from taskbuilder.data.collecting import collect
from taskbuilder.data.plan import CollectPlan
from taskbuilder.data.recording import Cameras
from taskbuilder.policies.mixture import read_share

CAMERAS = Cameras(("front", "left_wrist"), (48, 32), depth=True)


@pytest.fixture(scope="session")
def pictured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes of handover, of the expert and of the expert with noise, with two cameras."""
    folder = tmp_path_factory.mktemp("data") / "pictured"
    shares = (read_share("expert*2"), read_share("noisy:0.05"))
    collect(CollectPlan(("handover",), 3, policies=shares, cameras=CAMERAS), folder)
    return folder


@pytest.fixture(scope="session")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six episodes of two tasks for one robot, of the expert and of chance, with failures."""
    folder = tmp_path_factory.mktemp("data") / "mixed"
    plan = CollectPlan(
        ("reach", "pick_place"),
        3,
        policies=(read_share("expert*2"), read_share("random")),
        variations=None,
        keep_failures=True,
    )
    collect(plan, folder)
    return folder


@pytest.fixture
def copied(pictured: Path, tmp_path: Path) -> Path:
    """A copy of `pictured`."""
    return Path(shutil.copytree(pictured, tmp_path / "copied"))


@pytest.fixture
def good(tmp_path: Path) -> Path:
    """A small sound task without an expert, good.yaml."""
    (tmp_path / "good.py").write_text(DESCRIPTION)
    file = tmp_path / "good.yaml"
    file.write_text(GOOD)
    return file
