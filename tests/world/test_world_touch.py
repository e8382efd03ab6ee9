from __future__ import annotations

import pytest
from moves import HANDS, bench, bring, squeeze

from taskbuilder.errors import UnknownNameError
from taskbuilder.sim.contacts import contacts

PARTS = """
    rack:
      parts:
        plate: {box: [0.3, 0.3, 0.01], at: [0, 0, 0.005]}
        pole: {box: [0.02, 0.02, 0.1], at: [0.1, 0.1, 0.05]}
      mass: 1
      position: [1, 1, 0]
    cup: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.2, position: [1, 1, 0.035]}
"""

TWO_ARMS = """
timing: {control_hz: 10, physics_hz: 120}
scene:
  robots:
    left:
      model: ur5e
      base: {position: [-0.6, 0, 0]}
      home: {tcp: {position: [-0.1, 0, 0.4], rpy_deg: [180, 0, 0]}}
    right:
      model: ur5e
      base: {position: [0.6, 0, 0], rpy_deg: [0, 0, 180]}
      home: {tcp: {position: [0.1, 0, 0.4], rpy_deg: [180, 0, 180]}}
  objects:
    post: {shape: {box: [0.1, 0.02, 0.385]}, fixed: true, position: [0, 0, 0.1925]}
    stick:
      parts:
        left_half: {box: [0.15, 0.03, 0.03], at: [-0.075, 0, 0]}
        right_half: {box: [0.15, 0.03, 0.03], at: [0.075, 0, 0]}
      mass: 0.08
      position: [0, 0, 0.4005]
"""


def test_a_gripper_that_closes_on_a_block_holds_it(build):
    world = build(bench())
    world.step()
    assert not world.fingers_touch("block", "arm")
    assert not world.held("block", "arm")
    assert world.grip_forces("block", "arm") == ()
    squeeze(world, "arm")
    assert world.fingers_touch("block", "arm")
    assert world.touching("arm", "block")
    assert world.touching("block", "arm")
    assert world.held("block", "arm")
    assert world.grip_forces("block", "arm") == pytest.approx((20.0, 20.0), rel=0.2)


def test_a_block_that_is_held_can_be_lifted_and_let_go(build):
    world = build(bench())
    squeeze(world, "arm")
    assert world.support("block", "post") > 0.0
    bring(world, "arm", (0.45, 0.1, 0.5), steps=10)
    world.step()
    assert world.held("block", "arm")
    assert world.position("block") == pytest.approx((0.45, 0.1, 0.5), abs=0.005)
    assert not world.touching("block", "post")
    assert world.support("block", "post") == 0.0
    squeeze(world, "arm", opening=1.0)
    assert not world.fingers_touch("block", "arm")
    assert not world.held("block", "arm")
    assert world.position("block")[2] < 0.3


def test_one_finger_that_pushes_does_not_hold(build):
    world = build(bench())
    bring(world, "arm", (0.45, 0.03, 0.4), steps=5)
    assert world.fingers_touch("block", "arm")
    assert sorted(world.grip_forces("block", "arm"))[0] == 0.0
    assert not world.held("block", "arm")


def test_the_outer_side_of_a_finger_does_not_hold(build):
    world = build(bench(height=0.5))
    bring(world, "arm", (0.45, 0.1, 0.5), steps=5)
    bring(world, "arm", (0.45, 0.1, 0.4), steps=5)
    bring(world, "arm", (0.45, 0.07, 0.4), steps=3)
    assert world.fingers_touch("block", "arm")
    assert max(world.grip_forces("block", "arm")) > 0.05
    assert not world.held("block", "arm")


def test_fingers_that_spread_inside_a_frame_hold_it_until_they_are_told_to_close(build):
    world = build(
        bench(height=0.6)
        + """
    frame:
      parts:
        one: {box: [0.1, 0.02, 0.06], at: [0, 0.05, 0]}
        other: {box: [0.1, 0.02, 0.06], at: [0, -0.05, 0]}
        back: {box: [0.02, 0.12, 0.06], at: [0.06, 0, 0]}
      fixed: true
      position: [0.45, 0, 0.6]
"""
    )
    world.robots["arm"].body.reset_joints(
        world.robots["arm"].gripper.joints, world.robots["arm"].gripper.positions(0.5)
    )
    squeeze(world, "arm", opening=1.0)
    forces = world.grip_forces("frame", "arm")
    assert len(forces) == 2
    assert min(forces) > 5.0
    assert world.held("frame", "arm")
    squeeze(world, "arm", opening=0.3, steps=1)
    assert not world.held("frame", "arm")


def test_closed_fingers_that_press_down_do_not_hold(build):
    world = build(bench(height=0.5))
    squeeze(world, "arm")
    bring(world, "arm", (0.45, 0.0, 0.435), steps=5)
    assert world.fingers_touch("block", "arm")
    assert not world.held("block", "arm")


def test_two_arms_hold_one_stick_each_by_its_half(build):
    world = build(TWO_ARMS)
    squeeze(world, "left")
    assert world.held("stick", "left")
    assert not world.held("stick", "right")
    squeeze(world, "right")
    assert world.held("stick", "left")
    assert world.held("stick", "right")
    assert world.held("stick.left_half", "left")
    assert not world.held("stick.right_half", "left")
    assert not world.held("stick.left_half", "right")
    assert not world.touching("left", "right")
    squeeze(world, "left", opening=1.0)
    assert not world.held("stick", "left")
    assert world.held("stick", "right")


def test_a_thing_is_carried_by_the_part_it_stands_on(build):
    world = build(bench() + PARTS)
    for _ in range(10):
        world.step()
    weight = 0.2 * 9.81
    assert world.support("cup", "rack") == pytest.approx(weight, rel=0.05)
    assert world.support("cup", "rack.plate") == pytest.approx(weight, rel=0.05)
    assert world.support("rack", "cup") == pytest.approx(-weight, rel=0.05)
    assert world.support("cup", "rack.pole") == 0.0
    assert world.touching("cup", "rack.plate")
    assert not world.touching("cup", "rack.pole")
    assert not world.touching("cup", "block")


def test_contacts_are_read_once_a_control_step(build, monkeypatch):
    read = []

    def counted(*bodies: object) -> object:
        read.append(bodies)
        return contacts(*bodies)

    world = build(TWO_ARMS)
    squeeze(world, "left")
    monkeypatch.setattr("taskbuilder.world.touch.contacts", counted)
    world.refresh()
    for _ in range(3):
        assert world.held("stick", "left")
        assert world.held("stick.left_half", "left")
    assert len(read) == 1


@pytest.mark.parametrize("name", ["blok", "block.top", "arm.tcp", "goal"])
def test_a_body_that_is_not_there_is_named(build, name):
    world = build(bench())
    with pytest.raises(UnknownNameError, match=name):
        world.touching(name, "post")


def test_the_tool_stays_where_it_holds(build):
    world = build(bench())
    squeeze(world, "arm")
    assert world.position("arm.tcp") == pytest.approx(HANDS, abs=2e-3)
    before = world.position("block")
    squeeze(world, "arm", steps=10)
    assert world.position("block") == pytest.approx(before, abs=5e-4)
