"""The page in a real browser: Chromium without a display, if it and Playwright are installed."""

from __future__ import annotations

import re
import time
from contextlib import closing

import pytest

from taskbuilder import load_dataset
from taskbuilder.cli import main
from taskbuilder.geometry import Pose
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.view.page import LivePage
from taskbuilder.view.page_end import NO_WEBGL
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage
from tests.view.browser import CHROMIUM, IN_CHROMIUM, SMALL, field, press, turning, wait_until

pytestmark = IN_CHROMIUM


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


def test_yaml_is_copied_by_a_click(shown, tab, server):
    tab.context.grant_permissions(["clipboard-read", "clipboard-write"])
    tab.goto(server.address)
    press(tab, "tab", "Place")
    wait_until(lambda: server.viser.get_clients())
    shown.place.choice.value = "cube (object)"
    wait_until(lambda: shown.place.placing)
    shown.ask(lambda: shown.place.move(Pose((0.6, 0.2, 0.02))))
    yaml = tab.locator(".language-yaml")
    yaml.click(force=True)
    tab.locator(".language-yaml.copied").wait_for()
    lines = "# scene.objects.cube.position\n# was [0.5, 0.2, 0.02]\nposition: [0.6, 0.2, 0.02]\n"
    assert tab.evaluate("navigator.clipboard.readText()") == lines
    # Pages over http from elsewhere have no clipboard.
    tab.evaluate(
        """() => {
            Object.defineProperty(navigator, "clipboard", {value: undefined});
            document.addEventListener("copy", () => { window.copied = String(getSelection()); });
        }"""
    )
    yaml.click(force=True)
    tab.wait_for_function("window.copied")
    assert tab.evaluate("window.copied") == lines


def test_a_browser_without_webgl_and_its_terminal_say_so(shown, browser, server):
    told = []
    server.notify = told.append
    blind = browser.browser_type.launch(
        executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu", "--disable-3d-apis"]
    )
    with closing(blind):
        tab = blind.new_page(viewport=SMALL)
        tab.goto(server.address)
        tab.get_by_role("heading", name="This browser cannot draw the scene").wait_for()
        tab.get_by_text("Nothing is lost").wait_for()
        wait_until(lambda: told)
    assert told == [NO_WEBGL]
    shown.ask(shown.episode.play)  # the page goes on
    wait_until(lambda: shown.episode.recording)


def test_four_windows_show_the_same_at_once(shown, tab_of, server, touch):
    tabs = [tab_of() for _ in range(4)]
    for tab in tabs:
        tab.goto(server.address)
    for tab in tabs:
        tab.get_by_text("The arm brings its tool to the ball.").wait_for()
    press(tabs[0], "button", "Play an episode")
    for tab in tabs:
        tab.get_by_text(re.compile("expert: success after")).wait_for()
    touch.write_text(touch.read_text().replace("brings its tool to", "touches"))
    for tab in tabs:
        tab.get_by_text("The arm touches the ball.").wait_for()
    assert len(server.viser.get_clients()) == 4
