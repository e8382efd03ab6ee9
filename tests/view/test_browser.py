"""The page in a real browser: Chromium without a display, if it and Playwright are installed."""

from __future__ import annotations

import re
import shutil
import time
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from taskbuilder import load_dataset
from taskbuilder.cli import main
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.view.page import LivePage
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage
from tests.view.test_gamepads import turning, wait_until

sync_api = pytest.importorskip("playwright.sync_api")

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.slow,  # the processor draws the page
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]

PATIENCE_MS = 120_000
SMALL = {"width": 640, "height": 360}
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
def tab_of(browser):
    """Opens windows."""
    tabs, wrong = [], []

    def make():
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
def tab(tab_of):
    return tab_of()


@pytest.fixture
def shown(page_of, touch):
    with turning(page_of(touch)) as page:
        yield page


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
    assert shown.episode.step == 0


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


def field(tab, label):
    return tab.locator(f"xpath=//*[text()='{label}']/following::input[1]").first


def test_two_windows_steer_two_robots_of_one_episode(page_of, two_arms, tab_of, server, tmp_path):
    with turning(page_of(two_arms, record=tmp_path / "data")) as page:
        anna, ben = tab_of(), tab_of()
        for tab, name in ((anna, "Anna"), (ben, "Ben")):
            tab.goto(server.address)
            press(tab, "tab", "Steer")
            field(tab, "Your name").fill(name)
            field(tab, "Your name").press("Tab")
        press(anna, "button", "arm")
        anna.get_by_text("as Anna").wait_for()
        press(ben, "button", "arm")
        ben.get_by_text("arm is steered by Anna; choose another robot").wait_for()
        press(ben, "button", "other")
        ben.get_by_text("as Ben").wait_for()

        anna.keyboard.press("Enter")
        anna.get_by_text(re.compile(r"step \d+ of 180")).wait_for()
        world = page.steering.session.env.episode.world
        before = {robot: world.position(f"{robot}.tcp") for robot in ("arm", "other")}
        anna.keyboard.press("u")
        ben.keyboard.press("o")
        anna.get_by_text(re.compile(r"lag \d+ ms")).wait_for()
        time.sleep(1.0)
        assert world.position("arm.tcp")[2] > before["arm"][2] + 0.01
        assert world.position("other.tcp")[2] < before["other"][2] - 0.01

        ben.close()
        anna.get_by_text("stands still, its person has left").wait_for()
        anna.keyboard.press("Home")
        anna.get_by_text(re.compile("Kept as touch")).wait_for()
    (episode,) = load_dataset(tmp_path / "data")
    assert episode.operators == ("Anna", "Ben")
    assert {1} == set(episode.steered_by["arm"])
    assert {2, -1} <= set(episode.steered_by["other"])


FAKE = """
window.pad = {id: "Fake <b>pad</b>", connected: true, axes: [0, 0, 0, 0],
              buttons: Array.from({length: 16}, () => ({pressed: false, value: 0}))};
navigator.getGamepads = () => [window.pad];
"""
"""A gamepad that the test moves."""


def test_a_gamepad_steers_until_it_is_unplugged(page_of, touch, tab, server):
    tab.add_init_script(FAKE)
    with turning(page_of(touch)) as page:
        tab.goto(server.address_of("/gamepad"))
        tab.get_by_text("Gamepad: Fake <b>pad</b>").wait_for()
        tab.locator("#name").fill("Anna")
        tab.get_by_role("button", name="arm").first.click()
        tab.get_by_text("You steer arm as Anna.").wait_for()
        tab.evaluate("window.pad.buttons[9].pressed = true")
        wait_until(lambda: page.steering.runs)
        session = page.steering.session
        world = session.env.episode.world
        height = world.position("arm.tcp")[2]
        tab.evaluate("window.pad.axes[3] = -1")
        wait_until(lambda: world.position("arm.tcp")[2] > height + 0.03)
        tab.evaluate("window.pad = null")
        tab.get_by_text("The gamepad is unplugged, and the robot stands still.").wait_for()
        steps = session.env.episode.steps
        wait_until(lambda: session.env.episode.steps > steps + 5)
        stood = world.position("arm.tcp")
        wait_until(lambda: session.env.episode.steps > steps + 10)
        assert world.position("arm.tcp") == pytest.approx(stood, abs=1e-3)


def test_a_browser_elsewhere_needs_the_address_with_its_token(touch, tab):
    stage = Stage(str(touch), Catalogue.discover())
    with (
        closing(PageServer(0, "0.0.0.0")) as server,
        closing(LivePage(stage, server, Choice())) as page,
        turning(page),
    ):
        address = f"http://127.0.0.1:{server.port}/"
        tab.goto(address)
        tab.get_by_text("This page needs the whole address").wait_for()
        assert tab.context.cookies() == []
        tab.goto(f"{address}?token={server.gate.token}")
        tab.get_by_text("The arm brings its tool to the ball.").wait_for()
        assert tab.evaluate("document.cookie") == ""  # scripts do not see it
        tab.goto(f"{address}gamepad")  # the cookie is enough, and for its socket, too
        tab.get_by_role("button", name="arm").first.wait_for()


def test_an_exported_episode_plays_from_the_disk(tab, touch, tmp_path, capsys):
    file = tmp_path / "touch.html"
    assert main(["view", str(touch), "--export", str(file)]) == 0
    assert "success after" in capsys.readouterr().out
    assert file.stat().st_size < 6_000_000
    tab.goto(file.as_uri())
    tab.locator("canvas").first.wait_for()
    tab.wait_for_function("document.querySelectorAll('canvas').length > 0")


def test_a_thing_is_dragged_and_written(shown, tab, server, touch):
    tab.goto(server.address)
    tab.get_by_text("The arm brings its tool to the ball.").wait_for()
    press(tab, "tab", "Place")
    tab.wait_for_timeout(3000)  # the scene is drawn
    (client,) = server.viser.get_clients().values()
    x, y, z = shown.scene.world.pose("cube").position
    tab.mouse.click(*pixel(client.camera, SMALL, (x, y, z)))
    tab.get_by_text(re.compile("at \\(0.500, 0.200")).wait_for()
    tab.wait_for_timeout(3000)  # the arrows are drawn
    start, end = (pixel(client.camera, SMALL, (x, y, z + up)) for up in (0.2, 0.3))
    tab.mouse.move(*start)
    tab.wait_for_timeout(1000)
    tab.mouse.down()
    for share in (0.3, 0.6, 1.0):
        at = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        tab.mouse.move(*at)
        tab.wait_for_timeout(500)
    tab.mouse.up()
    tab.get_by_text(re.compile("was \\[0.5, 0.2, 0.02\\]")).wait_for()
    before = touch.read_text()
    press(tab, "button", "Write")
    tab.get_by_text(re.compile("Written to")).wait_for()
    changed = [new for new in touch.read_text().splitlines() if new not in before.splitlines()]
    assert len(changed) == 1
    assert re.search(r"position: \[0\.5\d*, 0\.2\d*, 0\.[1-9]", changed[0])


def pixel(camera, size, point):
    """Where a point is in the picture of a window."""
    right = np.cross(ahead := camera.look_at - camera.position, camera.up_direction)
    axes = [v / np.linalg.norm(v) for v in (right, np.cross(right, ahead), ahead)]
    x, y, depth = (float(axis @ (np.array(point) - camera.position)) for axis in axes)
    # The panel covers a part of the window on the right; the scene fills the rest.
    width, height = camera.aspect * size["height"], size["height"]
    scale = height / 2.0 / np.tan(camera.fov / 2.0) / depth
    return width / 2.0 + scale * x, height / 2.0 - scale * y
