"""The page in a real browser: Chromium without a display, if it and Playwright are installed."""

from __future__ import annotations

import re
import shutil
import threading
from collections.abc import Iterator

import pytest

from taskbuilder.cli import main

sync_api = pytest.importorskip("playwright.sync_api")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.slow,  # the processor draws the page
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]

PATIENCE_MS = 120_000
SMALL = {"width": 800, "height": 480}
"""A small picture, because the processor draws it."""


@pytest.fixture(scope="module")
def browser() -> Iterator[object]:
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield browser
        browser.close()


@pytest.fixture
def tab(browser):
    tab = browser.new_page(viewport=SMALL)
    tab.set_default_timeout(PATIENCE_MS)
    wrong = []
    tab.on("pageerror", lambda error: wrong.append(error))  # Playwright marks it
    yield tab
    tab.close()
    assert not wrong


@pytest.fixture
def shown(page_of, touch, server):
    """The page of the task, whose loop turns in a thread of its own."""
    page = page_of(touch)
    stop = threading.Event()
    thread = threading.Thread(target=lambda: page.run(stop.is_set))
    thread.start()
    yield page
    stop.set()
    thread.join()


def press(tab, role, name):
    tab.get_by_role(role, name=name).first.click(force=True)


def test_an_episode_is_played_and_scrubbed(shown, tab, server):
    tab.goto(server.address)
    tab.get_by_text("The arm brings its tool to the ball.").wait_for()
    press(tab, "button", "Play an episode")
    tab.get_by_text(re.compile("expert: success after")).wait_for()
    press(tab, "button", "▶")
    tab.wait_for_function("document.body.innerText.includes('Near(arm.tcp, ball)')")
    slider = tab.get_by_role("slider").first
    slider.focus()
    slider.press("Home")
    tab.get_by_text(re.compile("step 0 of 30")).wait_for()
    assert shown._step == 0


def test_a_change_of_a_file_is_shown_without_loading_the_page_again(shown, tab, server, touch):
    tab.goto(server.address)
    tab.get_by_text("The arm brings its tool to the ball.").wait_for()
    text = touch.read_text()
    touch.write_text(text.replace("brings its tool to", "touches"))
    tab.get_by_text("The arm touches the ball.").wait_for()
    touch.write_text(text.replace("model: panda", "model: pandaa"))
    press(tab, "tab", "Findings")
    tab.get_by_text(re.compile("TB")).first.wait_for()
    tab.get_by_text(re.compile("pandaa")).first.wait_for()


def test_names_with_markup_are_shown_as_they_are_written(shown, tab, server, touch):
    tab.goto(server.address)
    attack = "<img src=x onerror=document.title=7> [x](javascript:alert(1))"
    text = touch.read_text()
    touch.write_text(text.replace("The arm brings its tool to the ball.", f'"{attack}"'))
    tab.wait_for_function("document.body.innerText.includes('onerror=')")
    assert tab.title() != "7"
    assert tab.locator("a[href^='javascript']").count() == 0


def test_an_exported_episode_plays_from_the_disk(tab, touch, tmp_path, capsys):
    file = tmp_path / "touch.html"
    assert main(["view", str(touch), "--export", str(file)]) == 0
    assert "success after" in capsys.readouterr().out
    assert file.stat().st_size < 6_000_000
    tab.goto(file.as_uri())
    tab.locator("canvas").first.wait_for()
    tab.wait_for_function("document.querySelectorAll('canvas').length > 0")
