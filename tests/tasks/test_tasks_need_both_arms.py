"""What one arm must fetch is out of the other's reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scripted import tool_down

from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import solve

SEEDS = range(12)
UPPER_BOUND_M = 1.10
"""Farthest that a UR5e's tcp gets from its shoulder."""

OUT_OF_REACH = (
    ("handover", "right", "stick.left_end"),
    ("handover", "right", "stick"),
    ("handover", "right", "stick.right_end"),
    ("pick_push_place", "right", "cube.middle"),
    ("pick_push_place", "left", "tray.grip"),
    ("pick_push_place", "left", "tray"),
    ("collaborative_lift", "left", "tray.right_handle_top"),
    ("collaborative_lift", "right", "tray.left_handle_top"),
)
IN_REACH = (
    ("handover", "left", "stick.left_end"),
    ("pick_push_place", "left", "cube.middle"),
    ("pick_push_place", "right", "tray.grip"),
    ("collaborative_lift", "left", "tray.left_handle_top"),
    ("collaborative_lift", "right", "tray.right_handle_top"),
)


def reaches(world, robot, point, headings=6, attempts=4, slack_m=0.02):
    """Whether a tool that points down comes to within a slack of a point, however it is turned."""
    arm = world.robots[robot]
    base = arm.body.pose().inverse()
    rng = np.random.default_rng(0)
    for heading in np.linspace(0.0, 2 * math.pi, headings, endpoint=False):
        target = base @ Pose(point, tool_down(heading))
        found = solve(arm.chain, target, start=arm.home, rng=rng, attempts=attempts)
        if found.position_error_m < slack_m and found.angle_error < math.radians(5):
            return True
    return False


def nearest(world, robot, frame, count):
    """The seeds that put a frame nearest to a robot."""
    distances = {}
    for seed in SEEDS:
        world.reset(seed)
        distances[seed] = math.dist(world.position(f"{robot}.base"), world.position(frame))
    return sorted(distances, key=distances.__getitem__)[:count]


@pytest.mark.parametrize(("name", "robot", "frame"), OUT_OF_REACH)
def test_what_the_other_arm_fetches_is_out_of_reach_from_above(worlds, name, robot, frame):
    world = worlds[name]
    for seed in nearest(world, robot, frame, 3):
        world.reset(seed)
        assert not reaches(world, robot, world.position(frame))


@pytest.mark.parametrize(("name", "robot", "frame"), IN_REACH)
def test_what_an_arm_fetches_itself_is_in_reach_from_above(worlds, name, robot, frame):
    world = worlds[name]
    for seed in SEEDS:
        world.reset(seed)
        assert reaches(world, robot, world.position(frame), attempts=20)


@pytest.mark.parametrize(
    ("name", "robot", "frame"),
    [
        ("handover", "right", "stick"),
        ("pick_push_place", "right", "cube"),
        ("pick_push_place", "left", "tray"),
    ],
)
def test_stick_cube_and_tray_are_farther_than_the_other_arm_is_long(worlds, name, robot, frame):
    world = worlds[name]
    place = world.scene.objects[frame].place
    x = [place.center[0] + sign * place.size[0] / 2 for sign in (-1, 1)]
    y = [place.center[1] + sign * place.size[1] / 2 for sign in (-1, 1)]
    world.reset(0)
    shoulder = world.pose(f"{robot}.base").apply((0.0, 0.0, 0.1625))
    height = world.position(frame)[2]
    corners = [(a, b, height) for a in x for b in (*y, 0.0)]
    assert min(math.dist(shoulder, corner) for corner in corners) > UPPER_BOUND_M


def test_no_posture_takes_the_tool_farther_than_the_arm_is_long(worlds):
    chain = worlds["handover"].robots["left"].chain
    rng = np.random.default_rng(0)
    farthest = 0.0
    for _ in range(3000):
        joints = rng.uniform(-math.pi, math.pi, 6)
        joints[2] = 0.0  # the elbow stretched
        at = chain.forward(joints.tolist()).position
        farthest = max(farthest, math.dist(at, (0.0, 0.0, 0.1625)))
    assert 1.0 < farthest < UPPER_BOUND_M


def test_the_first_arm_cannot_bring_the_stick_to_the_goal_of_the_handover(worlds):
    world = worlds["handover"]
    place = world.scene.sites["goal"].place
    half = world.box("stick").half[0]
    near_x = place.center[0] - place.size[0] / 2
    base = np.array(world.position("left.base")[:2])
    for y in (-0.12, 0.0, 0.12):
        for z in (0.52, 0.64):
            way = np.array([near_x, y]) - base
            way /= np.linalg.norm(way)
            for back in np.linspace(0.0, half, 4):  # held anywhere up to its very end
                x, across = np.array([near_x, y]) - back * way
                assert not reaches(world, "left", (x, across, z), attempts=3, slack_m=0.005)
