"""Grippers that attach what they close around: what they take, until when, and to the bit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from moves import bring, squeeze, state
from written_tasks import read

from taskbuilder.geometry import Pose, from_rpy_deg
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.grasping import with_grasp
from taskbuilder.sim.attachments import UNLIMITED_N
from taskbuilder.world.building import build_world

ARMS = """
timing: {control_hz: 10, physics_hz: 120, episode_steps: 100}
scene:
  robots:
    left:
      model: ur5e
      base: {position: [-0.6, 0, 0.4]}
      home: {tcp: {position: [-0.2, 0, 0.6], rpy_deg: [180, 0, 0]}}
      grasp: {RULE}
    right:
      model: ur5e
      base: {position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}
      home: {tcp: {position: [0.2, 0, 0.6], rpy_deg: [180, 0, 0]}}
      grasp: {rule: attach}
  objects:
    table: {shape: {box: [1.6, 1.2, 0.04]}, fixed: true, position: [0, 0, 0.38]}
"""
CUBE = "    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: MASS, position: [-0.2, 0, 0.42]}\n"
BAR = "    bar: {shape: {box: [0.5, 0.03, 0.03]}, mass: 0.2, position: [0, 0, 0.415]}\n"
TOP = 0.44
URDFS = Path(__file__).resolve().parents[1] / "proven_tasks"


@pytest.fixture
def make(tmp_path):
    """Builds a world of two arms over a table, with some objects."""
    worlds = []

    def build(objects, grasp="rule: attach", rule="task"):
        file = read(tmp_path, ARMS.replace("RULE", grasp) + objects)
        world = build_world(with_grasp(file, rule))
        worlds.append(world)
        world.reset(0)
        return world

    yield build
    for world in worlds:
        world.close()


def cube(mass=0.1):
    return CUBE.replace("MASS", str(mass))


def wait(world, steps=8):
    for _ in range(steps):
        world.step()


def open_gripper(world, robot="left", steps=8):
    squeeze(world, robot, steps=steps, opening=1.0)


def height(world, name="cube"):
    return world.position(name)[2]


def lifted(world, at=(-0.2, 0.0, 0.425), name="cube"):
    """Close the left gripper at a place, and lift it by 15 cm; how far the object came along."""
    bring(world, "left", at, steps=8)
    wait(world, 3)
    before = height(world, name)
    squeeze(world, "left")
    bring(world, "left", (at[0], at[1], at[2] + 0.15), steps=8)
    wait(world, 3)
    return height(world, name) - before


def both_hold(world):
    """Have both grippers hold the bar, each near one end."""
    for robot, x in (("left", -0.15), ("right", 0.15)):
        bring(world, robot, (x, 0.0, 0.42), steps=8)
    for robot in ("left", "right"):
        squeeze(world, robot)
    assert world.held("bar", "left")
    assert world.held("bar", "right")


def raise_both(world, height, steps=10, apart=0.15):
    """Bring both tools to a height at once."""
    for step in range(1, steps + 1):
        share = step / steps
        now = {r: world.position(f"{r}.tcp") for r in ("left", "right")}
        for robot, x in (("left", -apart), ("right", apart)):
            place = np.array(now[robot]) + ((x, 0.0, height) - np.array(now[robot])) * share
            bring_targets(world, robot, place)
        world.step()


def bring_targets(world, robot, place):
    arm = world.robots[robot]
    goal = arm.body.pose().inverse() @ Pose(tuple(place), from_rpy_deg((180.0, 0.0, 0.0)))
    found = solve(arm.chain, goal, start=arm.commanded(), rng=np.random.default_rng(0))
    assert found.ok
    arm.move_arm(found.joints)


# --- taking and letting go


def test_it_takes_what_it_closes_around_and_lets_go_when_it_opens(make):
    world = make(cube())
    assert lifted(world) == pytest.approx(0.15, abs=0.003)
    assert world.held("cube", "left")
    assert not world.held("cube", "right")
    assert world.fingers_touch("cube", "left")
    open_gripper(world)
    assert not world.held("cube", "left")
    assert not world.fingers_touch("cube", "left")
    assert height(world) == pytest.approx(0.42, abs=0.002)


def test_what_it_takes_does_not_jump(make):
    world = make(cube())
    bring(world, "left", (-0.2, 0.0, TOP + 0.03), steps=8)  # the fingers end above the cube
    pose, seen = world.pose("cube"), []
    for _ in range(6):
        squeeze(world, "left", steps=1)
        seen.append(math.dist(pose.position, world.position("cube")))
    assert world.held("cube", "left")
    assert max(seen) < 5e-4


@pytest.mark.parametrize(("gap", "taken"), [(0.0385, True), (0.0415, False)])
def test_the_distance_is_from_the_tool_point_to_the_surface(make, gap, taken):
    world = make(cube())
    came = lifted(world, at=(-0.2, 0.0, TOP + gap))
    assert world.held("cube", "left") == taken
    assert came == pytest.approx(0.15 if taken else 0.0, abs=0.003)


def test_it_takes_from_any_side(make):
    world = make(cube())
    assert lifted(world, at=(-0.2 + 0.02 + 0.035, 0.0, 0.43)) == pytest.approx(0.15, abs=0.003)


@pytest.mark.parametrize(("distance", "taken"), [(0.01, False), (0.08, True)])
def test_a_robot_may_have_another_distance(make, distance, taken):
    world = make(cube(), grasp=f"rule: attach, distance: {distance}")
    lifted(world, at=(-0.2, 0.0, TOP + 0.06))
    assert world.held("cube", "left") == taken


def test_it_looks_once_when_it_closes(make):
    """A gripper that closed in the air takes nothing on its way."""
    world = make(cube())
    squeeze(world, "left")
    bring(world, "left", (-0.2, 0.0, TOP + 0.02), steps=8)
    wait(world)
    assert not world.held("cube", "left")
    assert "no object was within 40 mm" in world.robots["left"].gripper.words()
    open_gripper(world)
    squeeze(world, "left")
    assert world.held("cube", "left")
    assert "has an object attached" in world.robots["left"].gripper.words()


def test_it_takes_and_lets_go_half_way(make):
    world = make(cube())
    bring(world, "left", (-0.2, 0.0, 0.425), steps=8)
    held = []
    for opening in (0.51, 0.49, 0.0, 0.49, 0.5, 0.45):
        squeeze(world, "left", steps=1, opening=opening)
        held.append(world.held("cube", "left"))
    assert held == [False, True, True, True, False, True]


def test_it_takes_the_nearest(make):
    near = cube() + cube().replace("cube", "other").replace("-0.2, 0,", "-0.2, 0.05,")
    world = make(near)
    bring(world, "left", (-0.2, 0.032, TOP + 0.01), steps=8)
    squeeze(world, "left")
    assert [world.held(name, "left") for name in ("cube", "other")] == [False, True]


def test_of_a_group_it_takes_one(make):
    group = "count: 3, arrange: {line: 0.05}, position: [-0.2, 0, 0.42]"
    world = make(f"    ball: {{shape: {{sphere: 0.02}}, mass: 0.05, {group}}}\n")
    names = [name for name in world.objects if name.startswith("ball")]
    assert len(names) == 3
    x, y, z = world.position(names[2])
    bring(world, "left", (x, y, z + 0.01), steps=8)
    squeeze(world, "left")
    assert [world.held(name, "left") for name in names] == [False, False, True]


def test_what_is_fixed_is_not_taken(make):
    shape = "shape: {box: [0.04, 0.04, 0.04]}, fixed: true"
    world = make(f"    post: {{{shape}, position: [-0.2, 0, 0.42]}}\n")
    bring(world, "left", (-0.2, 0.0, TOP + 0.03), steps=8)
    squeeze(world, "left")
    bring(world, "left", (-0.2, 0.0, TOP + 0.1), steps=8)
    wait(world, 3)
    assert not world.held("post", "left")
    assert world.position("left.tcp")[2] == pytest.approx(TOP + 0.1, abs=0.003)


def test_it_attaches_to_the_moving_part_of_a_fixed_object(make, tmp_path):
    name = "drawer_by_its_knob.urdf"
    (tmp_path / name).write_bytes((URDFS / name).read_bytes())
    shape = f"shape: {{urdf: {name}}}, fixed: true"
    world = make(f"    cabinet: {{{shape}, position: [-0.11, 0.3, 0.401]}}\n")
    bring(world, "left", (-0.2, 0.155, 0.49), steps=8)
    squeeze(world, "left")
    assert world.held("cabinet.drawer", "left")
    assert world.held("cabinet", "left")
    assert not world.held("cabinet.case", "left")
    bring(world, "left", (-0.2, 0.055, 0.49), steps=8)
    wait(world, 2)
    assert world.joint("cabinet.runner") == pytest.approx(0.1, abs=0.005)


# --- loads


def test_no_load_slips(make):
    """A cube of 2 kg slips out of the fingers by friction; attached, it does not."""
    slipped = make(cube(mass=2.0), rule="friction")
    held = make(cube(mass=2.0))
    assert lifted(held) == pytest.approx(0.15, abs=0.01)
    assert held.held("cube", "left")
    assert lifted(slipped) < 0.15


@pytest.mark.parametrize(("mass", "stays"), [(0.1, True), (1.0, False)])
def test_with_a_force_it_lets_go_of_what_is_too_heavy(make, mass, stays):
    world = make(cube(mass), grasp="rule: attach, force: 4.0")
    came = lifted(world, at=(-0.2, 0.0, TOP + 0.03))
    assert world.held("cube", "left") == stays
    assert came == pytest.approx(0.15 if stays else 0.0, abs=0.005)


def test_the_limit_that_a_warning_about_heavy_loads_proposes_keeps_it_down(make):
    """What an unlimited gripper lifts, whatever it weighs, stays where it is."""
    unlimited, limited = make(cube(8.0)), make(cube(8.0), grasp="rule: attach, force: 38")
    assert lifted(unlimited) > 0.1
    assert lifted(limited) == pytest.approx(0.0, abs=0.005)
    assert not limited.held("cube", "left")


# --- two robots


def test_it_is_handed_over(make):
    world = make(BAR)
    both_hold(world)
    raise_both(world, 0.52)
    assert world.held("bar", "left")
    open_gripper(world, "left")
    assert [world.held("bar", robot) for robot in ("left", "right")] == [False, True]
    bring(world, "left", (-0.3, 0.0, 0.6), steps=8)
    bring(world, "right", (0.2, 0.0, 0.6), steps=8)
    assert height(world, "bar") > 0.5
    open_gripper(world, "right")
    assert not world.held("bar", "right")
    assert height(world, "bar") == pytest.approx(0.415, abs=0.01)


def test_two_robots_that_pull_it_apart_stay_in_bounds(make):
    world = make(BAR)
    both_hold(world)
    raise_both(world, 0.52)
    speeds, forces = [], []
    for step in range(40):
        apart = 0.15 + 0.1 * min(1.0, step / 10)
        for robot, x in (("left", -apart), ("right", apart)):
            bring_targets(world, robot, (x, 0.0, 0.52))
        world.step()
        speeds.append(max(map(abs, world.velocity("bar")[0])))
        forces.append(max(math.hypot(*holder.force()) for holder in world.client.holders))
    assert world.held("bar", "left")
    assert world.held("bar", "right")
    assert max(speeds) < 1.0
    assert 20.0 < max(forces) < 0.2 * UNLIMITED_N
    raise_both(world, 0.52)
    wait(world)
    assert world.position("bar") == pytest.approx((0.0, 0.0, 0.515), abs=0.01)


# --- to the bit


def goes_on(world):
    """What happens next: lifting, letting go, and taking again; every state on the way."""
    seen = []
    for robot, opening in (("left", 0.0), ("left", 1.0), ("right", 1.0), ("left", 0.0)):
        squeeze(world, robot, steps=2, opening=opening)
        seen.append(repr((state(world), world.held("bar", "left"), world.held("bar", "right"))))
    return seen


@pytest.mark.parametrize("holders", [("left",), ("right", "left"), ("left", "right")])
def test_it_goes_on_to_the_bit_from_a_state_in_which_it_holds(make, holders):
    world = make(BAR)
    bring(world, "left", (-0.15, 0.0, 0.42), steps=8)
    bring(world, "right", (0.15, 0.0, 0.42), steps=8)
    for robot in holders:
        squeeze(world, robot)
    kept = world.save()
    expected = goes_on(world)
    for disturbed in (lambda: None, lambda: world.reset(3), lambda: squeeze(world, "left")):
        disturbed()
        world.restore(kept)
        assert goes_on(world) == expected


def test_an_episode_is_the_same_after_one_that_ended_holding(make):
    world = make(BAR)
    world.reset(7)
    both_hold(world)
    expected = goes_on(world)
    raise_both(world, 0.52)
    world.reset(7)
    assert not world.held("bar", "left")
    both_hold(world)
    assert goes_on(world) == expected
