"""What the tests of the page share; all of them need viser, of the extra `view`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path

import pytest

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.view.page import LivePage
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage

if find_spec("viser") is None:
    collect_ignore_glob = ["test_*.py"]

TASK = """\
task: touch
summary: The arm brings its tool to the ball.
scene:
  robots:
    arm: {model: panda, base: {position: [0, 0, 0]}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0.2, 0.02]}
  sites:
    ball: {position: [0.45, 0, 0.4]}
  cameras:
    front: {position: [1.2, 0, 0.8], look_at: [0.4, 0, 0.2], size: [64, 48]}
timing: {episode_steps: 30}
expert:
  - arm: {reach: ball}
"""
DESCRIPTION = """\
from taskbuilder.description import Bonus, Description, Near


class Touch(Description):
    success = Near("arm.tcp", "ball", within=0.03)
    reward = (Bonus("there", success, 1.0),)
"""


@pytest.fixture
def touch(tmp_path: Path) -> Path:
    """A task of one arm, whose files a test may change."""
    file = tmp_path / "touch.yaml"
    file.write_text(TASK)
    file.with_suffix(".py").write_text(DESCRIPTION)
    return file


@pytest.fixture
def two_arms(touch: Path) -> Path:
    """The same task with another arm, which has nothing to do."""
    base = "{model: panda, base: {position: [0, 0, 0]}}"
    other = base.replace("[0, 0, 0]", "[0, 0.8, 0]")
    touch.write_text(touch.read_text().replace(f"arm: {base}", f"arm: {base}\n    other: {other}"))
    return touch


@pytest.fixture
def server() -> Iterator[PageServer]:
    with closing(PageServer(0)) as made:
        yield made


@pytest.fixture
def page_of(server: PageServer) -> Iterator[Callable[..., LivePage]]:
    """Makes the page of a task; its loop is turned by `turn`."""
    pages = []

    def make(file: Path, record: Path | None = None) -> LivePage:
        stage = Stage(str(file), Catalogue.discover(), record=record)
        pages.append(LivePage(stage, server, Choice(stage.players[0])))
        return pages[-1]

    yield make
    for page in pages:
        page.close()
