"""Things are dragged by the mouse in a real browser, and written into the task file."""

from __future__ import annotations

import re
from difflib import ndiff

import pytest

from tests.view.browser import (
    DRAWN_MS,
    IN_CHROMIUM,
    choose,
    drag,
    pixel,
    press,
    step_back,
    turning,
    wait_until,
)

pytestmark = IN_CHROMIUM


def opened(tab, server):
    """The tab *Place* in a window; its client."""
    tab.goto(server.address)
    tab.get_by_text("The arm brings its tool to the ball.").wait_for()
    press(tab, "tab", "Place")
    tab.wait_for_timeout(DRAWN_MS)
    (client,) = server.viser.get_clients().values()
    return client


def taken(page, tab, label):
    """Choose a thing in the window, and wait until its arrows are drawn."""
    choose(tab, "Move", label)
    wait_until(lambda: page.place.placing and str(page.place.placing.thing) == label)
    tab.wait_for_timeout(DRAWN_MS)
    return page.place.placing


def changed_lines(before, after):
    """The lines of a text that are not in an earlier one."""
    return [line[2:] for line in ndiff(before.splitlines(), after.splitlines()) if line[0] == "+"]


def test_a_thing_is_clicked_dragged_and_written(shown, tab, server, touch):
    client = opened(tab, server)
    x, y, z = shown.scene.world.pose("cube").position
    tab.mouse.click(*pixel(client.camera, (x, y, z)))
    tab.get_by_text(re.compile("at \\(0.500, 0.200")).wait_for()
    tab.wait_for_timeout(DRAWN_MS)
    drag(tab, client, (x, y, z + 0.2), (x, y, z + 0.3))
    tab.get_by_text(re.compile("was \\[0.5, 0.2, 0.02\\]")).wait_for()
    tab.get_by_text(re.compile("When you press Write, .*touch.yaml changes so:")).wait_for()
    before = touch.read_text()
    press(tab, "button", "Write")
    tab.get_by_text(re.compile("Written to")).wait_for()
    (changed,) = changed_lines(before, touch.read_text())
    assert re.search(r"position: \[0\.5\d*, 0\.2\d*, 0\.[1-9]", changed)


@pytest.mark.parametrize(
    ("label", "key"),
    [
        ("arm (tool at the start)", "home: {tcp: {position: "),
        ("ball (site)", "ball: {position: "),
        ("front (camera)", "front: {position: "),
    ],
)
def test_a_tool_a_site_and_a_camera_are_dragged_and_written(label, key, shown, tab, server, touch):
    client = opened(tab, server)
    step_back(client)
    placing, before = taken(shown, tab, label), touch.read_text()
    pose = placing.pose
    drag(tab, client, *(pose.apply((0.0, along, 0.0)) for along in (0.19, 0.27)))
    wait_until(lambda: placing.values)
    moved = pose.inverse().apply(placing.pose.position)
    assert moved == pytest.approx((0.0, 0.08, 0.0), abs=0.03)
    press(tab, "button", "Write")
    wait_until(lambda: touch.read_text() != before)
    (changed,) = changed_lines(before, touch.read_text())
    assert key in changed
    wait_until(lambda: shown.place.placing is not placing)


def test_a_region_is_moved_resized_written_and_taken_back(page_of, with_region, tab, server):
    text = with_region.read_text()
    with turning(page_of(with_region)) as page:
        client = opened(tab, server)
        step_back(client)
        region = taken(page, tab, "cube (region)")
        drag(tab, client, *(region.pose.apply((along, 0.0, 0.0)) for along in (0.15, 0.25)))
        wait_until(lambda: region.values)
        assert region.center == pytest.approx((0.5, 0.2), abs=0.03)
        assert (region.center[1], region.size) == (0.2, (0.1, 0.2))
        tab.wait_for_timeout(DRAWN_MS)
        drag(tab, client, *(region.corner.apply((0.0, along, 0.0)) for along in (0.075, 0.125)))
        wait_until(lambda: len(region.values) == 2)
        assert region.size == pytest.approx((0.1, 0.3), abs=0.04)
        assert region.center[1] == 0.2
        press(tab, "button", "Write")
        tab.get_by_text(re.compile("Written to")).wait_for()
        (changed,) = changed_lines(text, with_region.read_text())
        assert re.search(r"center: \[0\.[45]\d*, 0\.2\], size: \[0\.1, 0\.[23]", changed)
        wait_until(lambda: page.place.placing is not region)  # the page follows the file
        press(tab, "button", "Undo")
        tab.get_by_text(re.compile("is as it was before")).wait_for()
        assert with_region.read_text() == text
