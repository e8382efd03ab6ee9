"""What tests do with pages, and in the windows of a real browser."""

from __future__ import annotations

import shutil
import threading
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

IN_CHROMIUM = [
    pytest.mark.slow,  # the processor draws the page
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]
"""The marks of tests in a browser."""

PATIENCE_MS = 120_000
SMALL: Any = {"width": 640, "height": 360}
"""A small picture, because the processor draws it."""

DRAWN_MS = 3000
"""After so long, the processor has drawn a change."""


@contextmanager
def turning(page):
    """Turn the loop of a page in a thread of its own."""
    stop = threading.Event()
    thread = threading.Thread(target=lambda: page.run(stop.is_set))
    thread.start()
    try:
        yield page
    finally:
        stop.set()
        thread.join()


def wait_until(holds, seconds=60.0):
    for _ in range(int(seconds / 0.05)):
        if holds():
            return
        threading.Event().wait(0.05)
    assert holds()


def press(tab, role, name):
    """Press a button or a tab."""
    tab.get_by_role(role, name=name).first.click(force=True)


def field(tab, label):
    """The field that has a label."""
    return tab.locator(f"xpath=//*[text()='{label}']/following::input[1]").first


def choose(tab, label, option):
    """Choose one of a list of choices."""
    field(tab, label).click(force=True)
    tab.get_by_role("option", name=option, exact=True).click(force=True)


def step_back(client):
    """Look at the scene from farther away, so that all of it is in the small picture."""
    eye, target = np.array(client.camera.position), np.array(client.camera.look_at)
    client.camera.position = target + 1.8 * (eye - target)
    client.camera.look_at = target


def drag(tab, client, start, end):
    """Drag with the mouse from a point of the scene to another one."""
    start, end = (pixel(client.camera, point) for point in (start, end))
    tab.mouse.move(*start)
    tab.wait_for_timeout(1000)
    tab.mouse.down()
    for share in (0.3, 0.6, 1.0):
        tab.mouse.move(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
        tab.wait_for_timeout(500)
    tab.mouse.up()


def pixel(camera, point):
    """Where a point is in the picture of a window."""
    right = np.cross(ahead := camera.look_at - camera.position, camera.up_direction)
    axes = [v / np.linalg.norm(v) for v in (right, np.cross(right, ahead), ahead)]
    x, y, depth = (float(axis @ (np.array(point) - camera.position)) for axis in axes)
    # The panel covers a part of the window on the right; the scene fills the rest.
    width, height = camera.aspect * SMALL["height"], SMALL["height"]
    scale = height / 2.0 / np.tan(camera.fov / 2.0) / depth
    return width / 2.0 + scale * x, height / 2.0 - scale * y
