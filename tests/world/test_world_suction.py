"""A suction cup holds on to what is within its reach, up to its force, and repeats to the bit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from taskbuilder.geometry import Pose
from taskbuilder.kinematics.inverse import solve
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry
from taskbuilder.schema.load import read_task
from taskbuilder.world.building import build_world

TASK = """
task: sucking
summary: Two arms with suction cups over a table.
timing: {{control_hz: 10, physics_hz: 240, episode_steps: 100}}
scene:
  robots:
    left: {{model: ur5e_suction, base: {{position: [-0.6, 0, 0.4]}}}}
    right: {{model: ur5e_suction, base: {{position: [0.6, 0, 0.4], rpy_deg: [0, 0, 180]}}}}
  objects:
    table: {{shape: {{box: [1.6, 1.2, 0.04]}}, fixed: true, position: [0, 0, 0.38]}}
    plate: {{shape: {{box: [0.3, 0.16, 0.01]}}, mass: {mass}, position: [0, 0, 0.405]}}
    cabinet:
      shape: {{urdf: drawer_by_its_knob.urdf}}
      position: [-0.05, 0.4, 0.401]
      fixed: true
"""
TOP = 0.41
URDFS = Path(__file__).resolve().parents[1] / "proven_tasks"


@pytest.fixture
def make(tmp_path):
    """Builds the world with a plate of a given mass, and puts the cups over it."""
    worlds = []
    urdf = "drawer_by_its_knob.urdf"
    (tmp_path / urdf).write_bytes((URDFS / urdf).read_bytes())

    def build(mass=0.3):
        file = tmp_path / "sucking.yaml"
        file.write_text(TASK.format(mass=mass))
        world = build_world(read_task(CatalogueEntry("sucking", file), Catalogue.discover()))
        worlds.append(world)
        world.reset(0)
        return world

    yield build
    for world in worlds:
        world.close()


def joints_at(world, robot, position, rpy_deg=(180, 0, 0)):
    built = world.robots[robot]
    target = built.body.pose().inverse() @ Pose.from_rpy_deg(position, rpy_deg)
    found = solve(built.chain, target, start=built.commanded(), rng=np.random.default_rng(0))
    assert found.ok
    return found.joints


def go(world, steps=10, **positions):
    """Move cups to positions in the world in a number of control steps, and wait for three."""
    goals = {}
    for robot, position in positions.items():
        yaw = 0 if robot == "left" else 180
        goals[robot] = np.array(joints_at(world, robot, position, (180, 0, yaw)))
    begin = {robot: np.array(world.robots[robot].commanded()) for robot in goals}
    for step in range(1, steps + 1):
        world.step({r: (begin[r] + step / steps * (goals[r] - begin[r])).tolist() for r in goals})
    for _ in range(3):
        world.step()


def suck(world, robot="left", on=True):
    world.robots[robot].move_gripper(0.0 if on else 1.0)
    world.step()


def height(world):
    return world.position("plate")[2]


def state(world):
    """All that can be read of a world, to the bit."""
    found = [world.time, world.pose("plate"), world.velocity("plate")]
    for name, robot in world.robots.items():
        found += [robot.arm_state(), robot.gripper.command, world.held("plate", name)]
        found += [world.grip_forces("plate", name)]
    return repr(found)


def lifted(world, robot="left", x=-0.05):
    go(world, **{robot: (x, 0, TOP)})
    suck(world, robot)
    held = world.held("plate", robot)
    go(world, **{robot: (x, 0, TOP + 0.15)})
    return held


def test_it_lifts_what_is_within_its_reach_and_lets_go(make):
    world = make()
    assert lifted(world, x=0.0)
    assert height(world) == pytest.approx(0.405 + 0.15, abs=0.005)
    assert world.held("plate", "left")
    assert not world.held("plate", "right")
    assert world.fingers_touch("plate", "left")
    assert world.robots["left"].opening() == 0.0
    assert world.grip_forces("plate", "left")[0] == pytest.approx(0.3 * 9.81, abs=0.4)
    suck(world, on=False)
    assert not world.held("plate", "left")
    for _ in range(8):
        world.step()
    assert height(world) == pytest.approx(0.405, abs=0.002)


@pytest.mark.parametrize(("gap", "holds"), [(0.004, True), (0.009, False)])
def test_only_what_is_within_its_reach_is_held(make, gap, holds):
    world = make()
    go(world, left=(0, 0, TOP + gap))
    suck(world)
    assert world.held("plate", "left") is holds
    go(world, left=(0, 0, TOP + 0.1))
    assert (height(world) > 0.45) is holds


def test_on_nothing_it_holds_nothing_until_it_meets_a_surface(make):
    world = make()
    before = height(world)
    suck(world)
    world.step()
    assert not any(world.held(name, "left") for name in world.object_names)
    assert height(world) == pytest.approx(before, abs=1e-4)
    go(world, left=(0, 0, TOP))
    assert world.held("plate", "left")  # it was on all the time


@pytest.mark.parametrize(("mass", "holds"), [(4.0, True), (6.7, False)])
def test_it_lets_go_of_what_weighs_more_than_its_force(make, mass, holds):
    world = make(mass)
    assert lifted(world, x=0.0)
    assert world.held("plate", "left") is holds
    assert (height(world) > 0.5) is holds


@pytest.mark.parametrize("way", [(0, 0, -1), (1, 0, 0), (0.6, 0.8, 0), (0.48, 0.64, -0.6)])
def test_its_force_is_the_same_in_all_directions(make, way):
    world = make(0.5)
    lifted(world, x=0.0)
    bullet, body = world.client.bullet, world.objects["plate"].body

    def pulled(newtons):
        force = [newtons * part for part in way]
        force[2] += 0.5 * 9.81  # what its weight pulls already

        def pull():
            while True:
                bullet.applyExternalForce(body.id, -1, force, body.pose().position, 1)
                yield

        world.onlooker = pull()
        for _ in range(5):
            world.step()
        world.onlooker = None
        return world.held("plate", "left")

    assert pulled(54)
    assert not pulled(66)


def test_pressing_hard_on_what_it_holds_does_not_free_it(make):
    world = make()
    go(world, left=(0, 0, TOP))
    suck(world)
    go(world, left=(0, 0, TOP - 0.02))
    assert world.held("plate", "left")
    go(world, left=(0, 0, TOP + 0.1))
    assert world.held("plate", "left")


def test_it_does_not_hold_what_is_beside_it(make):
    world = make()
    go(world, left=(0, 0.083, TOP - 0.001))  # its mouth is past the edge
    suck(world)
    assert not world.held("plate", "left")


def test_a_link_of_an_articulated_object_is_held_by_name(make):
    world = make()
    x, y, z = world.pose("cabinet").apply((0.0, 0.0, 0.0))
    top = z + world.box("cabinet").seen_from(Pose()).high[2]
    go(world, left=(x, y, top + 0.05))
    suck(world)
    go(world, left=(x, y, top))
    links = [
        name for name in world.objects["cabinet"].boxes if world.held(f"cabinet.{name}", "left")
    ]
    assert len(links) == 1
    assert world.held("cabinet", "left")


def script_of(world):
    """Both lift the plate, one lets go and takes hold again: gripper, opening and goal by step."""
    goals = {
        robot: [
            joints_at(world, robot, (x, 0, z), (180, 0, yaw)) for z in (TOP, TOP + 0.12, TOP + 0.05)
        ]
        for robot, x, yaw in (("left", -0.1, 0), ("right", 0.1, 180))
    }
    script = [(None, None, 0)] * 14 + [("right", 0.0, 0), ("left", 0.0, 0)] + [(None, None, 1)] * 8
    script += [("right", 1.0, 1), (None, None, 1), ("right", 0.0, 1)] + [(None, None, 2)] * 6
    return goals, script + [("left", 1.0, 2)] + [(None, None, 1)] * 4


def run(world, script, goals, seen, save_at=None):
    """Play a script, note the state after each step, and save before one of them."""
    kept = None
    for number, (robot, opening, goal) in enumerate(script):
        if number == save_at:
            kept = world.save()
        if robot is not None:
            world.robots[robot].move_gripper(opening)
        steps = {}
        for name, built in world.robots.items():
            at, to = np.array(built.commanded()), np.array(goals[name][goal])
            steps[name] = (at + np.clip(to - at, -0.12, 0.12)).tolist()
        world.step(steps)
        seen.append(state(world))
    return kept


@pytest.mark.parametrize("moment", [10, 15, 16, 20, 25, 26, 28, 33])
def test_a_saved_state_goes_on_to_the_bit(make, moment):
    world = make()
    goals, script = script_of(world)
    seen: list[str] = []
    kept = run(world, script, goals, seen, save_at=moment)
    assert any("held=Attachment" in each for each in seen)
    again: list[str] = []
    world.restore(kept)
    run(world, script[moment:], goals, again)
    assert again == seen[moment:]
    world.reset(5)  # another episode in between, which ends holding
    lifted(world, "right", 0.05)
    world.restore(kept)
    again.clear()
    run(world, script[moment:], goals, again)
    assert again == seen[moment:]


def test_an_episode_repeats_to_the_bit_in_this_world_and_another(make):
    traces = []
    world, other = make(), make()
    for one in (world, other, world):
        one.reset(3)
        goals, script = script_of(one)
        seen: list[str] = []
        run(one, script, goals, seen)
        traces.append(seen)
    assert traces[0] == traces[1] == traces[2]
    assert math.isfinite(height(world))


def test_a_reset_lets_go(make):
    world = make()
    lifted(world)
    world.reset(1)
    assert not world.held("plate", "left")
    assert world.robots["left"].opening() == 1.0
    assert height(world) == pytest.approx(0.405, abs=0.001)
