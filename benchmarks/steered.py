"""Ten handovers steered by keys in two windows, multiplied to 200, and learned from.

    python benchmarks/steered.py [--episodes 10] [--many 200]

Two scripted people steer the arms of Handover in two windows of Chromium without a display, with
the keys of the page alone. They look where the tools are and press the keys that bring them on, but
not well: they aim up to a centimetre beside the place, each key comes up to 0.15 s late, and one in
twenty is not pressed. `taskbuilder multiply` makes 200 demonstrations from these ten. Behaviour
cloning with the preset `precise`, but for `turn`, learns from them, and from 200 of the expert;
each policy plays the same 100 episodes, on seeds that nothing was chosen by, for as many control
steps as the episodes that it learned from had at most.

Everything is in runs/steered, and what is there is not made again. Results go to
benchmarks/results/steered.json. The browser and Playwright have to be installed.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from machine import describe_machine
from playwright.sync_api import Page, sync_playwright
from reloading import PATIENCE_MS, SLOWLY
from viewing import WINDOW, served

import taskbuilder
from taskbuilder.geometry import Vec3, add, subtract
from taskbuilder.view.page import LivePage

TASK = "handover"
FOLDER = Path("runs/steered")
RESULTS = Path(__file__).parent / "results" / "steered.json"
HORIZON = 600
KEYS = (("KeyL", "KeyJ"), ("KeyI", "KeyK"), ("KeyU", "KeyO"))
"""Those that move along and against x, y and z, as one looks at Handover from the front."""

NEAR_M, SLOW_M = 0.012, 0.03
BESIDE_M, LATE_S, LOST = 0.01, 0.15, 0.05
SETTINGS = {"turn": 0}  # scenes cannot be turned in the frames in which people's episodes are kept
TRAIN_SEED, EXPERT_SEED, FIRST_SEED, PLAYED = 11, 600_000, 3_000_000, 100


def episode_of(page: LivePage) -> Any:
    """The episode that people steer; one has begun."""
    session = page.steering.session
    if session is None or session.env is None:
        raise RuntimeError("no episode has begun")
    return session.env.episode


class Person:
    """Presses keys in a window, not well, until the tool of a robot is where it should be."""

    def __init__(self, tab: Page, page: LivePage, robot: str, name: str) -> None:
        self._tab, self._page, self._robot = tab, page, robot
        self._chance = random.Random(name)
        tab.get_by_role("tab", name="Steer").first.click(force=True)
        field = tab.locator("xpath=//*[text()='Your name']/following::input[1]").first
        field.fill(name)
        field.press("Tab")
        tab.get_by_role("button", name=robot).first.click(force=True)
        tab.get_by_text(f"as {name}").wait_for()

    def go(self, goal: Callable[[], Vec3], *, exact: bool = False) -> None:
        """Press keys until the tool is there, or the episode has ended."""
        beside = 0.0 if exact else BESIDE_M
        x, y, z = (self._chance.uniform(-beside, beside) for _ in range(3))
        while self._page.steering.runs:
            now = self._world.position(f"{self._robot}.tcp")
            gaps = subtract(add(goal(), (x, y, z)), now)
            far = [(keys, gap) for keys, gap in zip(KEYS, gaps, strict=True) if abs(gap) > NEAR_M]
            if not far:
                return
            for (plus, minus), gap in far:
                self._press("Shift+" * (abs(gap) < SLOW_M) + (plus if gap > 0.0 else minus))
            self._wait(1)

    def grip(self) -> None:
        """Open or close the gripper, and wait."""
        self._tab.keyboard.press("KeyG")
        self._wait(6)

    def _press(self, key: str) -> None:
        time.sleep(self._chance.uniform(0.0, LATE_S))
        if self._chance.random() >= LOST:
            self._tab.keyboard.press(key)

    def _wait(self, steps: int) -> None:
        episode = episode_of(self._page)
        until = episode.steps + steps
        while self._page.steering.runs and episode.steps < until:
            time.sleep(0.01)

    @property
    def _world(self) -> Any:
        return episode_of(self._page).world


def hand_over(page: LivePage, left: Person, right: Person) -> None:
    """The left arm picks the stick up, the right one takes it over and brings it to the goal."""
    world = episode_of(page).world

    def at(frame: str, above: float = 0.0) -> Callable[[], Vec3]:
        return lambda: add(world.position(frame), (0.0, 0.0, above))

    left.go(at("stick.left_end", 0.08))
    left.go(at("stick.left_end"), exact=True)
    left.grip()
    left.go(lambda: (-0.15, 0.0, 0.62))
    right.go(at("stick.right_end", 0.08))
    right.go(at("stick.right_end"), exact=True)
    right.grip()
    left.grip()
    goal = world.position("goal")
    right.go(lambda: (goal[0] + 0.09, goal[1], goal[2]), exact=True)


def steer(folder: Path, count: int) -> dict[str, Any]:
    """Steer until there are so many demonstrations."""
    tries, begun = 0, time.monotonic()
    with sync_playwright() as playwright, served(TASK, HORIZON, folder) as (page, address):
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        tabs = [browser.new_page(viewport=WINDOW) for _ in range(2)]
        for tab in tabs:
            tab.set_default_timeout(PATIENCE_MS)
            tab.add_init_script(SLOWLY)
            tab.goto(address)
        left = Person(tabs[0], page, "left", "Anna")
        right = Person(tabs[1], page, "right", "Ben")
        kept = 0
        while kept < count:
            tries += 1
            tabs[0].keyboard.press("Enter")
            while not page.steering.runs:
                time.sleep(0.05)
            session = page.steering.session
            hand_over(page, left, right)
            while page.steering.runs:  # until it has succeeded for long enough, or time is up
                time.sleep(0.05)
            won = bool(session and session.data and session.data.about["success"])
            print(f"try {tries}: {won}, {session and session.lag_ms} ms", flush=True)
            if won:
                tabs[1].keyboard.press("Home")
                while session and session.kept == kept:
                    time.sleep(0.05)
            kept += won
        browser.close()
    return {"tries": tries, "kept": kept, "seconds": round(time.monotonic() - begun)}


def learn(name: str, data: Path) -> dict[str, Any]:
    """Learn from demonstrations; how the policy does."""
    out = FOLDER / f"bc-{name}"
    if not (out / "policy.npz").exists():
        taskbuilder.train(
            data=data, algorithm="bc", preset="precise", settings=SETTINGS, seed=TRAIN_SEED, out=out
        )
    result = taskbuilder.evaluate(out, PLAYED, first_seed=FIRST_SEED, jobs=1)
    return {"episodes": PLAYED, "success_at_end": result.success_at_end_rate}


def main() -> int:
    """Steer, multiply, learn and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--episodes", type=int, default=10, help="demonstrations to steer")
    parser.add_argument("--many", type=int, default=200, help="demonstrations to learn from")
    asked = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    by_hand, many, scripted = FOLDER / "by-hand", FOLDER / "many", FOLDER / "expert"
    result: dict[str, Any] = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}

    def keep(**figures: Any) -> None:
        result.update(figures)
        RESULTS.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        print(figures, flush=True)

    keep(command="python benchmarks/steered.py", machine=describe_machine(), task=TASK)
    if not by_hand.exists():
        keep(steered=steer(by_hand, asked.episodes))
    few = taskbuilder.load_dataset(by_hand)
    lengths = [episode.steps for episode in few]
    keep(steps_by_hand={"median": statistics.median(lengths), "most": max(lengths)})
    made = taskbuilder.multiply(few, many, episodes=asked.many, jobs=1)
    attempts = len(made) + len(made.contents["not_kept"])
    keep(multiplied={"kept": len(made), "attempts": attempts, "share": len(made) / attempts})
    if not scripted.exists():
        taskbuilder.collect(TASK, scripted, episodes=asked.many, first_seed=EXPERT_SEED, jobs=1)
    for name, data in (("multiplied", many), ("expert", scripted)):
        keep(**{f"learned_from_{name}": learn(name, data)})
    return 0


if __name__ == "__main__":
    sys.exit(main())
