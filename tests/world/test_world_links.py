"""Grasp points on links of articulated objects: they go where their link goes."""

from __future__ import annotations

import math

import pytest

CABINET = """<robot name="cabinet">
  <link name="case">
    <inertial><mass value="5"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.15"/><geometry><box size="0.3 0.3 0.02"/></geometry></collision>
  </link>
  <link name="drawer">
    <inertial><mass value="0.5"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.25 0.25 0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="case"/><child link="drawer"/><origin xyz="0 0 0.05"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.2" effort="50" velocity="1"/>
  </joint>
  <link name="flap">
    <inertial><mass value="0.2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.1 0.01"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="case"/><child link="flap"/><origin xyz="0 0 0.2"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="2" effort="50" velocity="1"/>
  </joint>
</robot>
"""

ROOM = """
timing: {control_hz: 20, physics_hz: 120}
scene:
  robots:
    arm: {model: ur5e, base: {position: [-1, 0, 0]}}
  objects:
    cabinet:
      shape: {urdf: cabinet.urdf}
      fixed: true
      position: [0, 1, 0.01]
      rpy_deg: [0, 0, 90]
      grasps:
        top: {at: [0, 0, 0.16]}
        knob: {at: [0.13, 0, 0], link: drawer}
        rim: {at: [0.2, 0, 0], link: flap}
  sites:
    beside: {position: [0, 0.1, 0], in: cabinet.knob}
"""


@pytest.fixture
def room(build, tmp_path):
    (tmp_path / "cabinet.urdf").write_text(CABINET, encoding="utf-8")
    return build(ROOM)


def put(world, joint, position, speed=0.0):
    body = world.objects["cabinet"].body
    index = body.joints[joint].index
    world.client.bullet.resetJointState(body.id, index, position, speed)
    world.refresh()


def test_a_knob_goes_where_its_drawer_goes(room):
    assert room.position("cabinet.knob") == pytest.approx((0, 1.13, 0.06), abs=1e-6)
    put(room, "slide", 0.15, speed=0.4)
    assert room.position("cabinet.knob") == pytest.approx((0, 1.28, 0.06), abs=1e-6)
    assert room.position("beside") == pytest.approx((-0.1, 1.28, 0.06), abs=1e-6)
    assert room.position("cabinet.top") == pytest.approx((0, 1, 0.17), abs=1e-6)
    for frame in ("cabinet.knob", "beside", "cabinet.drawer"):
        assert room.velocity(frame)[0] == pytest.approx((0, 0.4, 0), abs=1e-6)
    assert room.velocity("cabinet.top") == ((0, 0, 0), (0, 0, 0))


def test_a_rim_turns_with_its_flap(room):
    put(room, "hinge", math.pi / 2, speed=0.5)
    assert room.position("cabinet.rim") == pytest.approx((0, 1, 0.41), abs=1e-6)
    linear, angular = room.velocity("cabinet.rim")
    assert linear == pytest.approx((0, -0.1, 0), abs=1e-6)
    assert angular == pytest.approx((0.5, 0, 0), abs=1e-6)
    assert room.pose("cabinet.rim").axis(0) == pytest.approx((0, 0, 1), abs=1e-6)


def test_a_knob_is_back_after_a_reset_and_after_going_back(room):
    room.reset(0)
    begin = room.pose("cabinet.knob")
    put(room, "slide", 0.1)
    for _ in range(5):
        room.step()
    state, open_ = room.save(), room.pose("cabinet.knob")
    put(room, "slide", 0.0)
    assert room.pose("cabinet.knob") != open_
    room.restore(state)
    assert room.pose("cabinet.knob") == open_
    room.reset(0)
    assert room.pose("cabinet.knob") == begin
