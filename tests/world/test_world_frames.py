from __future__ import annotations

import math

import pytest

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose, add, cross, from_rpy_deg, scale, subtract, turn_between

SCENE = """
scene:
  robots:
    arm:
      model: ur5e
      base: {position: [0.1, 0.2, 0.3], rpy_deg: [0, 0, 90]}
      home: {tcp: {position: [0.1, 0.7, 0.6], rpy_deg: [180, 0, 30]}}
  objects:
    tray:
      parts:
        floor: {box: [0.4, 0.2, 0.02]}
        handle: {cylinder: {radius: 0.02, length: 0.1}, at: [0.2, 0, 0.05], rpy_deg: [90, 0, 0]}
      mass: 0.5
      grasps: {rim: {at: [0, 0.1, 0.01]}}
      position: [-1, 0, 1]
      rpy_deg: [0, 0, 90]
    ball: {shape: {sphere: 0.03}, mass: 0.1, in: tray, position: [0.1, 0, 0.1]}
  sites:
    lamp: {position: [1, 2, 3], rpy_deg: [0, 0, 90], marker: {box: [0.2, 0.4, 0.6]}}
    corner: {in: tray, position: [0.2, 0.1, 0]}
    above_corner: {in: corner, position: [0, 0, 0.5]}
    nail: {in: arm.tcp, position: [0, 0, 0.1]}
"""


def near(pose: Pose, position, rpy_deg=(0.0, 0.0, 0.0)) -> bool:
    off = math.dist(pose.position, position)
    return off < 1e-6 and turn_between(pose.quaternion, from_rpy_deg(rpy_deg)) < 1e-5


def test_frames_are_where_the_file_puts_them(build):
    world = build(SCENE)
    assert near(world.pose("tray"), (-1, 0, 1), (0, 0, 90))
    assert near(world.pose("tray.floor"), (-1, 0, 1), (0, 0, 90))
    assert near(world.pose("tray.rim"), (-1.1, 0, 1.01), (0, 0, 90))
    assert near(world.pose("ball"), (-1, 0.1, 1.1), (0, 0, 90))
    assert near(world.pose("arm.base"), (0.1, 0.2, 0.3), (0, 0, 90))
    assert near(world.pose("lamp"), (1, 2, 3), (0, 0, 90))
    handle = world.pose("tray.handle")
    assert handle.position == pytest.approx((-1, 0.2, 1.05))
    assert handle.axis(2) == pytest.approx((1, 0, 0), abs=1e-9)  # -y in the tray, which is turned


def test_the_tool_starts_at_the_home_that_the_file_gives(build):
    tool = build(SCENE).pose("arm.tcp")
    assert tool.position == pytest.approx((0.1, 0.7, 0.6), abs=1e-3)
    assert turn_between(tool.quaternion, from_rpy_deg((180, 0, 30))) < math.radians(0.5)


def test_the_tool_is_where_the_arms_kinematics_say(build):
    world = build(SCENE)
    arm = world.robots["arm"]
    expected = world.pose("arm.base") @ arm.chain.forward(arm.arm_state()[0])
    assert world.position("arm.tcp") == pytest.approx(expected.position, abs=1e-5)
    assert turn_between(world.pose("arm.tcp").quaternion, expected.quaternion) < 1e-4


def test_a_site_rides_on_what_it_is_in(build):
    world = build(SCENE)
    world.objects["tray"].body.place(Pose((0.0, -1.0, 2.0), from_rpy_deg((0, 0, 180))))
    world.refresh()
    assert near(world.pose("corner"), (-0.2, -1.1, 2), (0, 0, 180))
    assert near(world.pose("above_corner"), (-0.2, -1.1, 2.5), (0, 0, 180))
    tool = world.pose("arm.tcp")
    assert world.position("nail") == pytest.approx(tool.apply((0, 0, 0.1)))


def test_a_pose_stays_the_same_until_the_world_moves_on(build):
    world = build(SCENE)
    before = world.pose("ball")
    world.objects["ball"].body.place(Pose((0.0, 0.0, 5.0)))
    assert world.pose("ball") == before
    world.step()
    assert world.position("ball")[2] == pytest.approx(5.0, abs=0.1)


def test_velocities_are_those_of_points_of_a_rigid_body(build):
    world = build(SCENE)
    body = world.objects["tray"].body
    world.client.bullet.resetBaseVelocity(body.id, (0.1, 0.2, 0.3), (1.0, -2.0, 3.0))
    world.step()
    for frame in ("tray.floor", "tray.handle", "tray.rim", "corner", "above_corner"):
        linear, angular = world.velocity(frame)
        of_tray, spin = world.velocity("tray")
        arm = subtract(world.position(frame), world.position("tray"))
        assert angular == pytest.approx(spin)
        assert linear == pytest.approx(add(of_tray, cross(spin, arm)), abs=1e-6)
    assert math.hypot(*spin) > 1.0
    assert world.velocity("lamp") == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_velocities_agree_with_differences_of_positions(build):
    world = build("timing: {control_hz: 1000, physics_hz: 1000}\n" + SCENE)
    arm = world.robots["arm"]
    arm.arm.velocity([0.5, -0.3, 0.4, 0.2, 0.6, 1.0])
    for _ in range(50):
        world.step()
    for frame in ("arm.tcp", "nail", "ball"):
        world.refresh()
        before, (linear, _) = world.position(frame), world.velocity(frame)
        world.step()
        moved = scale(subtract(world.position(frame), before), 1000.0)
        assert moved == pytest.approx(linear, abs=0.02)
        assert math.hypot(*linear) > 0.1
    assert world.velocity("arm.base") == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_boxes_are_in_the_frame_of_what_they_bound(build):
    world = build(SCENE)
    assert world.box("tray").low == pytest.approx((-0.2, -0.1, -0.01))
    assert world.box("tray").high == pytest.approx((0.22, 0.1, 0.07))
    assert world.box("tray.floor").half == pytest.approx((0.2, 0.1, 0.01))
    assert world.box("tray.handle").half == pytest.approx((0.02, 0.02, 0.05))
    assert world.box("ball").half == pytest.approx((0.03, 0.03, 0.03))
    assert world.box("lamp").half == pytest.approx((0.1, 0.2, 0.3))


@pytest.mark.parametrize("frame", ["trey", "tray.lid", "arm", "arm.elbow", "lamp.top", "world"])
def test_a_frame_that_is_not_there_is_named(build, frame):
    world = build(SCENE)
    with pytest.raises(UnknownNameError, match=f'"{frame}"'):
        world.pose(frame)
    with pytest.raises(UnknownNameError):
        world.velocity(frame)


def test_what_has_no_volume_or_joint_says_so(build):
    world = build(SCENE)
    with pytest.raises(UnknownNameError, match="no marker"):
        world.box("corner")
    with pytest.raises(UnknownNameError, match=r"tray\.lid"):
        world.box("tray.lid")
    with pytest.raises(UnknownNameError, match="no joint"):
        world.joint("tray.hinge")
    with pytest.raises(UnknownNameError, match="no body"):
        world.touching("tray.rim", "ball")


def test_a_site_is_no_solid_and_an_object_is(build):
    world = build(SCENE)
    assert world.is_solid("tray")
    assert world.is_solid("tray.handle")
    assert not world.is_solid("lamp")
    assert world.robot_names == ("arm",)
    assert world.object_names == ("tray", "ball")
