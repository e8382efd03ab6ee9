"""What the tests of the page share; all of them need viser, of the extra `view`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.view.page import LivePage
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage
from tests.view.browser import CHROMIUM, PATIENCE_MS, SMALL, turning

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
REGION = "place: {surface: table, center: [0.4, 0.2], size: [0.1, 0.2]}"
"""Where the cube is placed at random, on a table."""


@pytest.fixture
def touch(tmp_path: Path) -> Path:
    """A task of one arm, whose files a test may change."""
    file = tmp_path / "touch.yaml"
    file.write_text(TASK)
    file.with_suffix(".py").write_text(DESCRIPTION)
    return file


@pytest.fixture
def with_region(touch: Path) -> Path:
    """The task with a table, on which the cube is placed at random."""
    text = touch.read_text().replace("position: [0.5, 0.2, 0.02]", REGION)
    table = "table: {shape: {box: [0.8, 0.8, 0.1]}, fixed: true, position: [0.7, 0, 0.05]}"
    text = text.replace("    cube:", f"    {table}\n    cube:")
    touch.write_text(text)
    return touch


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

    def make(file: Path | str, record: Path | None = None, horizon: int | None = None) -> LivePage:
        stage = Stage(str(file), Catalogue.discover(), record=record, horizon=horizon)
        pages.append(LivePage(stage, server, Choice(stage.players[0])))
        return pages[-1]

    yield make
    for page in pages:
        page.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium without a display; where it or Playwright is missing, tests are skipped."""
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        made = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield made
        made.close()


@pytest.fixture
def tab_of(browser: Any) -> Iterator[Callable[[], Any]]:
    """Opens windows; no script of theirs may fail."""
    tabs: list[Any] = []
    wrong: list[Any] = []

    def make() -> Any:
        tab = browser.new_page(viewport=SMALL)
        tab.set_default_timeout(PATIENCE_MS)
        tab.on("pageerror", lambda error: wrong.append(error))  # Playwright marks it
        tabs.append(tab)
        return tab

    yield make
    for tab in tabs:
        tab.close()
    assert not wrong


@pytest.fixture
def tab(tab_of: Callable[[], Any]) -> Any:
    """A window."""
    return tab_of()


@pytest.fixture
def shown(page_of: Callable[..., LivePage], touch: Path) -> Iterator[LivePage]:
    """The page of the task, whose loop turns."""
    with turning(page_of(touch)) as page:
        yield page
