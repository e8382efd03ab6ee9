"""How quick the live page is: its first picture, the pictures it sends, and steering by keys.

    python benchmarks/viewing.py [--starts 5] [--seconds 20] [--keys 120]

Three measurements on Handover, in Chromium without a display:

- start: from the command `taskbuilder view handover` until its address is printed, and until a
  browser that was open before has drawn the robots;
- pictures: the page shows 30 moments of an episode per second. What processor time the server needs
  for that, with one window and with four; and how many of them one window shows, which draws them
  with the processor;
- keys: from the moment at which the browser sees a key to the beginning of the control step that
  follows it, by the clock of this machine. Keys are pressed at random times while the page steers
  at 10 Hz, so that the wait for the next control step alone takes 50 ms in the mean.

The processor draws what a graphics card draws elsewhere. So windows are small, and while keys are
pressed the page is drawn only a few times per second. Results go to
benchmarks/results/viewing.json.
The browser and Playwright have to be installed.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from machine import describe_machine
from playwright.sync_api import Browser, Page, sync_playwright
from reloading import PATIENCE_MS, SIZE, SLOWLY

from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.steering.operator import Operator
from taskbuilder.steering.session import Session
from taskbuilder.view.page import LivePage
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice, Stage

TASK = "handover"
RESULTS = Path(__file__).parent / "results" / "viewing.json"
WINDOW: Any = {"width": 640, "height": 360}
NOTE_DRAWING = """
window.drawn = 0;
let calls = 0;
const context = WebGL2RenderingContext.prototype;
for (const name of ["drawElements", "drawArrays", "drawElementsInstanced"]) {
    const draw = context[name];
    context[name] = function (...given) { calls += 1; return draw.apply(this, given); };
}
const look = () => {
    if (!window.drawn && calls > MOST_CALLS) window.drawn = Date.now() / 1000;
    calls = 0;
    window.requestAnimationFrame(look);
};
window.requestAnimationFrame(look);
"""
"""Notes when a frame has more drawing calls than an empty scene."""

EMPTY = 30
"""Drawing calls of a frame that has no robots yet, at most; one with robots has 250."""

PICTURES_HZ = 30.0
COUNT_PICTURES = """
window.pictures = 0;
new MutationObserver((changes) => {
    window.pictures += changes.some((change) => change.target.role === "slider");
}).observe(document.body, {subtree: true, attributes: true, attributeFilter: ["aria-valuenow"]});
"""
NOTE_KEYS = """
window.keys = [];
const note = (event) => { if (event.code === "KeyI") window.keys.push(Date.now() / 1000); };
window.addEventListener("keydown", note, true);
"""


def summary(values: list[float]) -> dict[str, float]:
    """The median of values, their 95th percentile and the largest."""
    return {
        "median": round(statistics.median(values), 3),
        "95th": round(float(np.percentile(values, 95)), 3),
        "most": round(max(values), 3),
    }


def first_picture(browser: Browser) -> tuple[float, float]:
    """Seconds from the command to its address, and to the first picture."""
    tab = browser.new_page(viewport=WINDOW)
    tab.set_default_timeout(PATIENCE_MS)
    tab.add_init_script(NOTE_DRAWING.replace("MOST_CALLS", str(EMPTY)))
    command = [sys.executable, "-m", "taskbuilder", "view", TASK, "--port", "0"]
    begun = time.time()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split()[0]
        served = time.time() - begun
        tab.goto(address)
        tab.wait_for_function("window.drawn > 0", polling=100)
        drawn = tab.evaluate("window.drawn") - begun
        process.terminate()
    tab.close()
    return served, drawn


@contextmanager
def served(
    task: str = TASK, horizon: int = 5000, record: Path | None = None
) -> Iterator[tuple[LivePage, str]]:
    """A page in this process, whose loop runs in a thread of its own."""
    stage = Stage(task, Catalogue.discover(), horizon=horizon, record=record)
    with (
        closing(PageServer(0)) as server,
        closing(LivePage(stage, server, Choice(stage.players[0]))) as page,
    ):
        stop = threading.Event()
        thread = threading.Thread(target=page.run, args=(stop.is_set,))
        thread.start()
        try:
            yield page, server.address
        finally:
            stop.set()
            thread.join()


def window(browser: Browser, address: str, size: Any, script: str = "") -> Page:
    """A window that shows the page."""
    tab = browser.new_page(viewport=size)
    tab.set_default_timeout(PATIENCE_MS)
    tab.add_init_script(script)
    tab.goto(address)
    tab.get_by_text("The left arm picks up").wait_for()
    tab.wait_for_timeout(3000)  # the scene is loaded
    return tab


def pictures(browser: Browser, count: int, seconds: float, script: str = "") -> dict[str, float]:
    """What it takes to show pictures in several windows, and how many the first one shows."""
    with served() as (page, address):
        tabs = [window(browser, address, SIZE, script) for _ in range(count)]
        page.ask(page.episode.play)
        while page.episode.recording is None:
            time.sleep(0.1)
        tabs[0].evaluate(COUNT_PICTURES)
        begun, spent = time.monotonic(), time.process_time()
        for number in range(int(seconds * PICTURES_HZ)):
            step = number % page.episode.steps
            page.ask(partial(page.episode.go_to, step, pause=True))
            time.sleep(max(0.0, begun + (number + 1) / PICTURES_HZ - time.monotonic()))
        taken, spent = time.monotonic() - begun, time.process_time() - spent
        shown = tabs[0].evaluate("window.pictures") / taken
        for tab in tabs:
            tab.close()
    figures = {
        "windows": count,
        "sent_per_second": round(int(seconds * PICTURES_HZ) / taken, 1),
        "server_cpu_share": round(spent / taken, 3),
    }
    return figures if script else {**figures, "shown_per_second": round(shown, 1)}


def keys(browser: Browser, count: int) -> dict[str, Any]:
    """How long after the browser sees a key a control step follows it, in milliseconds."""
    arrivals: list[float] = []
    steps: list[float] = []
    press, step = Operator.press, Session.step

    def arrive(operator: Operator, *args: Any, **options: Any) -> None:
        arrivals.append(time.time())
        press(operator, *args, **options)

    def begin(session: Session) -> None:
        steps.append(time.time())
        step(session)

    with (
        mock.patch.object(Operator, "press", arrive),
        mock.patch.object(Session, "step", begin),
        served() as (page, address),
    ):
        tab = window(browser, address, WINDOW, SLOWLY)
        tab.evaluate(NOTE_KEYS)
        tab.get_by_role("tab", name="Steer").first.click(force=True)
        tab.get_by_role("button", name="left").first.click(force=True)
        tab.wait_for_timeout(2000)
        tab.keyboard.press("Enter")
        while not page.steering.runs:
            time.sleep(0.1)
        chance = random.Random(0)
        for _ in range(count):
            tab.keyboard.press("KeyI")
            time.sleep(chance.uniform(0.25, 0.45))
        seen = tab.evaluate("window.keys")
        session = page.steering.session
        hz, lag = (session.control_hz, session.lag_ms) if session else (0.0, None)
        tab.close()
    if not len(seen) == len(arrivals) == count:
        raise SystemExit(f"{count} keys pressed, {len(seen)} seen, {len(arrivals)} arrived")
    begins = [min(moment for moment in steps if moment >= arrived) for arrived in arrivals]
    ways = {
        "browser to server": [b - a for a, b in zip(seen, arrivals, strict=True)],
        "server to control step": [b - a for a, b in zip(arrivals, begins, strict=True)],
        "browser to control step": [b - a for a, b in zip(seen, begins, strict=True)],
    }
    return {
        "keys": count,
        "control_hz": hz,
        "lag_ms_that_the_page_shows": lag,
        "milliseconds": {name: summary([1e3 * s for s in times]) for name, times in ways.items()},
    }


def main() -> int:
    """Measure, and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--starts", type=int, default=5, help="starts of the command")
    parser.add_argument("--seconds", type=float, default=20.0, help="of showing an episode")
    parser.add_argument("--keys", type=int, default=120, help="keys to press")
    asked = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        first_picture(browser)  # fills the caches of files
        starts = [first_picture(browser) for _ in range(asked.starts)]
        print(starts, flush=True)
        data = {
            "command": "python benchmarks/viewing.py",
            "machine": {**describe_machine(), "browser": browser.version},
            "task": TASK,
            "start_s": {
                "address": summary([served for served, _ in starts]),
                "first picture": summary([drawn for _, drawn in starts]),
            },
            "pictures": [
                pictures(browser, 1, asked.seconds),
                pictures(browser, 4, asked.seconds, SLOWLY),
            ],
            "steering": keys(browser, asked.keys),
        }
        browser.close()
    RESULTS.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(data, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
