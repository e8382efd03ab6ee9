"""Make the pictures of the page on the live page, in a browser without a display.

    python docs/view_images.py [NAME ...] [--size 1400x900] [--to FOLDER]

Writes docs/images/view.png and the other pictures of docs/view.md, or those that are named. They
are taken of Handover in Chromium; Playwright and Chromium must be installed.
"""

from __future__ import annotations

import argparse
import re
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import chdir, closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image
from playwright.sync_api import sync_playwright

from taskbuilder.geometry import Pose
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.view.page import LivePage
from taskbuilder.view.scene import COLLISIONS, EXPERT
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage

IMAGES = Path(__file__).parent / "images"
WIDTH, COLORS = 1000, 128
"""Width of a picture on the page in pixels, and its number of colours."""

DRAWN_MS = 4000
"""The processor draws the page; after so long it has."""

PATIENCE_MS = 120_000


class Window:
    """A browser window with a page of Handover; `stop` lets the page stand still."""

    def __init__(self, page: LivePage, tab: Any, stop: Callable[[], None]) -> None:
        self.page, self.tab, self.stop = page, tab, stop

    def press(self, role: str, name: str) -> None:
        """Press a button or a tab."""
        self.tab.get_by_role(role, name=name).first.click(force=True)

    def do(self, request: Callable[[], None]) -> None:
        """Have something done by the page, and wait for it."""
        done = threading.Event()

        def ask() -> None:
            request()
            done.set()

        self.page.ask(ask)
        done.wait()

    def switch_on(self, word: str) -> None:
        """Switch something on in the tab *Scene*."""
        self.press("tab", "Scene")
        self.tab.get_by_text(word.capitalize(), exact=True).first.click(force=True)


def played(window: Window) -> None:
    """An episode at its end."""
    window.press("button", "Play an episode")
    window.tab.get_by_text("success after").first.wait_for()
    window.do(lambda: window.page.episode.go_to(10_000, pause=True))


def placed(window: Window) -> None:
    """The stick, moved to the right and away."""
    window.press("tab", "Place")
    place = window.page.place
    window.do(lambda: setattr(place.choice, "value", "stick (object)"))
    window.tab.wait_for_timeout(DRAWN_MS)
    pose = place.placing.pose if place.placing else Pose()
    x, y, z = pose.position
    window.do(lambda: place.move(Pose((x + 0.1, y - 0.08, z), pose.quaternion)))
    window.do(place._follow)


def poses(window: Window) -> None:
    """The expert's poses."""
    window.switch_on(EXPERT)
    window.tab.get_by_text("in reach").first.wait_for()


def collisions(window: Window) -> None:
    """The collision shapes in mid-episode."""
    window.press("button", "Play an episode")
    window.tab.get_by_text("success after").first.wait_for()
    window.do(lambda: window.page.episode.go_to(36, pause=True))
    window.switch_on(COLLISIONS)


def steered(window: Window) -> None:
    """The left arm, steered by hand."""
    tab = window.tab
    window.press("tab", "Steer")
    tab.locator("xpath=//*[text()='Your name']/following::input[1]").first.fill("Anna")
    tab.keyboard.press("Tab")
    window.press("button", "left")
    tab.get_by_text("as Anna").wait_for()
    tab.keyboard.press("Enter")
    tab.get_by_text(re.compile(r"step \d+ of")).first.wait_for()
    for _ in range(4):
        tab.keyboard.press("i")
        tab.wait_for_timeout(300)
    window.stop()  # the processor may take longer for the picture than the episode lasts


PICTURES: Mapping[str, Callable[[Window], None]] = {
    "view": played,
    "view-place": placed,
    "view-poses": poses,
    "view-collisions": collisions,
    "view-steer": steered,
}
"""The pictures, and what is done on the page before each."""


@contextmanager
def handover(record: Path) -> Iterator[tuple[LivePage, PageServer, Callable[[], None]]]:
    """A page of Handover, whose loop runs; its server; and what ends the loop."""
    catalogue = Catalogue.discover()
    entry = catalogue.task("handover")
    for file in (entry.file, entry.description_file):
        shutil.copy(file, ".")  # so that the page names no folder of this machine
    stage = Stage(entry.file.name, catalogue, record=record)
    with closing(PageServer(0)) as server, closing(LivePage(stage, server, Choice())) as page:
        stop = threading.Event()
        thread = threading.Thread(target=lambda: page.run(stop.is_set))
        thread.start()

        def end() -> None:
            stop.set()
            thread.join()

        try:
            yield page, server, end
        finally:
            end()


def take(browser: Any, name: str, size: tuple[int, int], to: Path) -> None:
    """Take a picture."""
    with (
        TemporaryDirectory() as folder,
        chdir(folder),
        handover(Path("data/by-hand")) as (page, server, stop),
    ):
        tab = browser.new_page(viewport={"width": size[0], "height": size[1]})
        tab.set_default_timeout(PATIENCE_MS)
        tab.goto(server.address)
        tab.get_by_text("handover").first.wait_for()
        tab.wait_for_timeout(DRAWN_MS)
        for note in tab.locator(".mantine-Notification-closeButton").all():
            note.click(force=True)  # that the processor draws
        PICTURES[name](Window(page, tab, stop))
        tab.wait_for_timeout(DRAWN_MS)
        file = Path("whole.png")
        tab.screenshot(path=file)
        tab.close()
        with Image.open(file) as whole:
            picture = whole.convert("RGB")
    if size[0] > WIDTH:
        picture = picture.resize(
            (WIDTH, round(WIDTH * size[1] / size[0])), Image.Resampling.LANCZOS
        )
    picture.quantize(COLORS).save(to / f"{name}.png", optimize=True)


def main() -> None:
    """Take the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[*PICTURES, []], metavar="NAME")
    parser.add_argument("--size", default="1400x900", help="size of the window in pixels")
    parser.add_argument("--to", type=Path, default=IMAGES)
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--disable-gpu"]
        )
        for name in arguments.names or PICTURES:
            take(browser, name, (width, height), arguments.to.resolve())
        browser.close()


if __name__ == "__main__":
    main()
