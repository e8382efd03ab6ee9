"""Two people in two windows of a real browser hand the stick of Handover over, by keys."""

from __future__ import annotations

import re
import time

from taskbuilder import load_dataset
from taskbuilder.geometry import subtract
from tests.steering.conftest import NEAR_M, SLOW_M, above
from tests.view.browser import IN_CHROMIUM, field, press, turning, wait_until

pytestmark = IN_CHROMIUM

KEYS = (("KeyL", "KeyJ"), ("KeyI", "KeyK"), ("KeyU", "KeyO"))
"""Those that move along and against x, y and z, as one looks at Handover from the front."""

LONGEST_S = 300.0


class Person:
    """Presses keys in a window until the tool of a robot is where it should be."""

    def __init__(self, tab, page, address, robot, name):
        self._tab, self._page, self._robot = tab, page, robot
        tab.goto(address)
        press(tab, "tab", "Steer")
        field(tab, "Your name").fill(name)
        field(tab, "Your name").press("Tab")
        press(tab, "button", robot)
        tab.get_by_text(f"as {name}").wait_for()

    def go(self, goal):
        end = time.monotonic() + LONGEST_S
        while pressed := self._keys(goal()):
            for key in pressed:
                self._tab.keyboard.press(key)
            self._wait(1)
            assert time.monotonic() < end

    def grip(self):
        self._tab.keyboard.press("KeyG")
        self._wait(6)

    def _wait(self, steps):
        """Wait for so many control steps."""
        session = self._page.steering.session
        until = session.env.episode.steps + steps
        wait_until(lambda: session.env.episode.steps >= until or not self._page.steering.runs)

    def _keys(self, goal):
        world = self._page.steering.session.env.episode.world
        gaps = subtract(goal, world.position(f"{self._robot}.tcp"))
        far = [(keys, gap) for keys, gap in zip(KEYS, gaps, strict=True) if abs(gap) > NEAR_M]
        if not self._page.steering.runs:
            return []
        return [
            f"{'Shift+' * (abs(gap) < SLOW_M)}{plus if gap > 0.0 else minus}"
            for (plus, minus), gap in far
        ]


def test_two_windows_hand_the_stick_over(page_of, tab_of, server, tmp_path):
    with turning(page_of("handover", record=tmp_path / "data", horizon=3000)) as page:
        tabs = tab_of(), tab_of()
        anna = Person(tabs[0], page, server.address, "left", "Anna")
        ben = Person(tabs[1], page, server.address, "right", "Ben")
        tabs[0].keyboard.press("Enter")
        wait_until(lambda: page.steering.runs)
        session = page.steering.session
        anna.go(above(session, "stick.left_end", 0.08))
        anna.go(above(session, "stick.left_end"))
        anna.grip()
        anna.go(lambda: (-0.15, 0.0, 0.62))
        ben.go(above(session, "stick.right_end", 0.08))
        ben.go(above(session, "stick.right_end"))
        ben.grip()
        anna.grip()
        goal = session.env.episode.world.position("goal")
        ben.go(lambda: (goal[0] + 0.09, goal[1], goal[2]))
        wait_until(lambda: not page.steering.runs)
        for tab in tabs:
            tab.get_by_text(re.compile("success")).first.wait_for()
        tabs[1].keyboard.press("Home")
        tabs[0].get_by_text(re.compile("Kept as handover")).wait_for()
    (episode,) = load_dataset(tmp_path / "data")
    assert episode.success
    assert episode.operators == ("Anna", "Ben")
    assert {robot: set(rows) for robot, rows in episode.steered_by.items()} == {
        "left": {1},
        "right": {2},
    }
