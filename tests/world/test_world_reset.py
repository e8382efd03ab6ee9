from __future__ import annotations

import gc
from pathlib import Path

import pytest
from moves import bench, bring, squeeze, state
from written_tasks import NAMES

from taskbuilder.errors import SimulationError

PLACED = (
    bench(height=0.5)
    + """
    ball: {shape: {sphere: 0.02}, mass: 0.05, place: {surface: shelf, center: [0, 0], size: [1, 1]}}
    shelf:
      shape: {box: [2, 2, 0.02]}
      fixed: true
      place: {center: [2, 0, 0.5], size: [0, 0, 0.4]}
  sites:
    goal: {marker: {sphere: 0.02}, place: {center: [0, 1, 1], size: [0.5, 0.5, 0.5]}}
"""
)


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * 4096 / 1e6


@pytest.mark.parametrize("name", NAMES)
class TestReset:
    def test_the_same_seed_gives_the_same_episode_to_the_bit(self, library, name):
        world = library[name]
        world.reset(5)
        first = state(world)
        world.step()
        later = state(world)
        for robot in world.robots.values():
            robot.move_arm([joint + 0.5 for joint in robot.home])
            robot.move_gripper(0.0)
        for _ in range(10):
            world.step()
        world.reset(6)
        world.step()
        world.reset(5)
        assert state(world) == first
        world.reset(5)
        assert state(world) == first
        world.step()
        assert state(world) == later

    def test_seeds_differ_in_what_is_placed_and_in_nothing_else(self, library, name):
        world = library[name]
        world.reset(1)
        before = {thing: world.position(thing) for thing in world.object_names}
        joints = {robot: world.robots[robot].arm_state()[0] for robot in world.robots}
        world.reset(2)
        for thing, spec in world.scene.objects.items():
            assert (world.position(thing) != before[thing]) == (spec.place is not None)
        for robot, positions in joints.items():
            assert world.robots[robot].arm_state()[0] == pytest.approx(positions, abs=1e-6)

    def test_an_episode_begins_at_rest_at_home_at_time_zero(self, library, name):
        world = library[name]
        for seed in range(5):
            world.reset(seed)
            assert world.time == 0.0
            for thing in world.object_names:
                linear, angular = world.velocity(thing)
                assert max(map(abs, linear)) < 0.01
                assert max(map(abs, angular)) < 0.2
            for robot in world.robots.values():
                assert robot.arm_state()[0] == pytest.approx(robot.home, abs=1e-3)
                assert robot.opening() == pytest.approx(1.0, abs=1e-3)

    def test_many_resets_do_not_grow_the_process(self, library, name):
        world = library[name]
        for seed in range(20):
            world.reset(seed)
        gc.collect()
        before = resident_mb()
        for seed in range(300):
            world.reset(seed)
        gc.collect()
        assert resident_mb() - before < 2.0

    def test_two_worlds_of_one_task_do_not_share_anything(self, library, build, name):
        text = library[name].task.entry.file.read_text(encoding="utf-8")
        body = text.split("\n", 2)[2]
        world, other = library[name], build(body)
        world.reset(3)
        other.reset(3)
        assert state(world) == state(other)
        world.step({robot: world.robots[robot].home for robot in world.robots})
        other.reset(4)
        other.reset(3)
        other.step()
        assert world.position(world.object_names[-1]) == other.position(other.object_names[-1])


def test_a_moment_in_mid_grasp_comes_back_to_the_bit(build):
    world = build(bench())
    world.reset(0)
    squeeze(world, "arm")
    bring(world, "arm", (0.45, 0.05, 0.45), steps=3)
    moment = world.save()
    at_moment = state(world)

    def go_on() -> list[object]:
        bring(world, "arm", (0.4, 0.1, 0.5), steps=4)
        squeeze(world, "arm", steps=2)
        assert world.held("block", "arm")
        return state(world)

    first = go_on()
    for seed in (1, 2):
        world.robots["arm"].move_gripper(1.0)
        world.step()
        world.reset(seed)
        world.step()
        world.restore(moment)
        assert state(world) == at_moment
        assert go_on() == first
    world.release(moment)
    with pytest.raises(SimulationError):
        world.restore(moment)


@pytest.mark.parametrize("height", [0.4, 0.6])
def test_no_contact_carries_over_from_one_episode_to_the_next(build, height):
    world = build(bench(height=height))  # the block starts a hair above its post: nothing touches
    states = []
    for steps in (0, 1, 5, 0):
        world.reset(0)
        states.append(state(world))
        squeeze(world, "arm", steps=steps)
    assert states[1:] == states[:1] * 3


def test_a_moment_knows_what_was_held_in_it(build):
    world = build(bench())
    squeeze(world, "arm")
    moment = world.save()
    world.reset(0)
    assert not world.held("block", "arm")
    world.restore(moment)
    world.step()
    assert world.held("block", "arm")


def test_fixed_things_and_markers_come_back_too(build):
    world = build(PLACED)
    world.reset(1)
    moment, before = world.save(), state(world)
    marker = world.sites["goal"].marker.pose()
    assert marker == world.pose("goal")
    world.reset(2)
    assert world.pose("shelf") != before[world.object_names.index("shelf") * 3 + 1]
    assert world.sites["goal"].marker.pose() == world.pose("goal") != marker
    world.restore(moment)
    assert state(world) == before
    assert world.sites["goal"].marker.pose() == marker == world.pose("goal")
