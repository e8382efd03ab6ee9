"""Demonstrations are cut where objects are taken, passed on and put down, and stages reached."""

from __future__ import annotations

from itertools import pairwise

import pytest

from taskbuilder.geometry import Pose
from taskbuilder.multiplying.anchors import WORLD, Hold, anchors_of, holds_of
from taskbuilder.multiplying.demonstration import Milestone, ReplayedDemonstration

STEPS = 60


def line(*points):
    """Poses along x through (step, x) points, at even speed between them."""
    poses = []
    for (begin, at), (end, to) in pairwise(points):
        poses += [
            Pose((at + (to - at) * (step - begin) / (end - begin), 0.0, 0.0))
            for step in range(begin, end)
        ]
    return [*poses, Pose((points[-1][1], 0.0, 0.0))]


def demonstration(held, tools, frames, milestones=()):
    return ReplayedDemonstration(
        name="made-up",
        variation=0,
        tools=tools,
        openings={robot: [1.0] * (STEPS + 1) for robot in tools},
        held={
            robot: [next((n for n, b, e in spans if b <= t <= e), "") for t in range(STEPS + 1)]
            for robot, spans in held.items()
        },
        frames=frames,
        milestones=tuple(milestones),
        stage_ends=(),
    )


def frames_of(anchors):
    return [anchor.frame for anchor in anchors]


def test_what_is_held_for_a_moment_was_only_touched_and_slips_do_not_count():
    tools = {"arm": line((0, 0.0), (STEPS, 1.0))}
    held = {"arm": [("cube", 5, 6), ("cube", 20, 30), ("cube", 32, 40)]}
    shown = demonstration(held, tools, {"cube": line((0, 0.0), (STEPS, 0.0))})
    assert holds_of(shown, "arm") == [Hold("arm", "cube", 20, 40)]


def test_a_tool_moves_with_what_it_takes_and_then_with_where_it_brings_it():
    tools = {"arm": line((0, 0.0), (20, 0.5), (22, 0.5), (40, 1.0), (42, 1.0), (STEPS, 0.0))}
    frames = {
        "cube": line((0, 0.5), (22, 0.5), (40, 1.0), (STEPS, 1.0)),
        "lid": line((0, 0.5), (22, 0.5), (40, 1.0), (STEPS, 1.0)),  # lies on the cube
        "mark": line((0, 1.0), (STEPS, 1.0)),
    }
    milestones = [Milestone(44, ("cube", "lid", "mark"))]
    shown = demonstration({"arm": [("cube", 20, 42)]}, tools, frames, milestones)
    start, taken, brought = anchors_of(shown, "arm")
    assert (start.frame, taken.frame, brought.frame) == (WORLD, "cube", "mark")
    assert taken.fixed == taken.begin < 20 < taken.end
    assert brought.begin < 42 < brought.end
    assert brought.fixed is None
    assert shown.tools["arm"][taken.begin].position[0] == pytest.approx(0.4, abs=0.03)


def test_what_is_put_down_anywhere_is_put_down_where_it_was():
    tools = {"arm": line((0, 0.0), (20, 0.5), (22, 0.5), (40, 1.0), (42, 1.0), (STEPS, 0.0))}
    frames = {"cube": line((0, 0.5), (22, 0.5), (40, 1.0), (STEPS, 1.0))}
    shown = demonstration({"arm": [("cube", 20, 42)]}, tools, frames)
    assert frames_of(anchors_of(shown, "arm")) == [WORLD, "cube", WORLD]


def test_what_is_passed_on_is_passed_on_where_it_was():
    tools = {
        "left": line((0, 0.0), (10, 0.3), (25, 0.6), (35, 0.6), (STEPS, 0.0)),
        "right": line((0, 1.0), (30, 0.65), (35, 0.65), (STEPS, 1.0)),
    }
    frames = {"stick": line((0, 0.3), (10, 0.3), (25, 0.6), (35, 0.6), (STEPS, 1.0))}
    held = {"left": [("stick", 10, 34)], "right": [("stick", 31, STEPS)]}
    shown = demonstration(held, tools, frames)
    left, right = anchors_of(shown, "left"), anchors_of(shown, "right")
    assert frames_of(left) == [WORLD, "stick", WORLD]
    assert left[-1].begin < 31
    assert right[1].frame == "stick"
    assert right[1].fixed == 28  # the other arm may still move it until then


def test_robots_that_lift_together_agree_on_when():
    tools = {
        "left": line((0, 0.0), (10, 0.3), (15, 0.3), (40, 0.8), (STEPS, 0.8)),
        "right": line((0, 1.0), (14, 0.5), (15, 0.5), (40, 1.0), (STEPS, 1.0)),
    }
    frames = {
        "pot": line((0, 0.4), (15, 0.4), (40, 0.9), (STEPS, 0.9)),
        "hob": line((0, 0.9), (STEPS, 0.9)),
    }
    held = {"left": [("pot", 10, 50)], "right": [("pot", 14, 51)]}
    shown = demonstration(held, tools, frames, [Milestone(45, ("pot", "hob"))])
    left, right = anchors_of(shown, "left"), anchors_of(shown, "right")
    assert frames_of(left) == frames_of(right) == [WORLD, "pot", "hob"]
    assert left[1].end == right[1].end
    assert left[2].begin == right[2].begin


def test_a_button_is_pressed_by_the_tool_that_is_there():
    tools = {"near": line((0, 0.0), (30, 0.5), (STEPS, 0.0)), "far": line((0, 2.0), (STEPS, 2.0))}
    frames = {"button": line((0, 0.55), (STEPS, 0.55))}
    shown = demonstration({"near": [], "far": []}, tools, frames, [Milestone(30, ("button",))])
    assert frames_of(anchors_of(shown, "near")) == [WORLD, "button"]
    assert frames_of(anchors_of(shown, "far")) == [WORLD]
