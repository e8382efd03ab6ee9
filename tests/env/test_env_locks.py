"""Locks of joints in environments: a condition of the description frees and locks them."""

from __future__ import annotations

import pytest
from env_tasks import still

URDF = """<robot name="lift">
  <link name="base">
    <inertial><mass value="2"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="cabin">
    <inertial><mass value="0.5"/>
      <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="cabin"/><axis xyz="0 0 1"/>
    <limit lower="-0.5" upper="0.5" effort="100" velocity="5"/>
  </joint>
</robot>
"""
SCENE = """
timing: {control_hz: 10, physics_hz: 120, episode_steps: 20}
scene:
  floor: false
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    lift:
      shape: {urdf: lift.urdf}
      fixed: true
      position: [1.5, 0, 1]
      joints: {slide: {friction: 0, damping: 0, lock: {unless: free}}}
"""
DESCRIPTION = """
from taskbuilder.description import Above, Description, JointPosition, Paid, Height


class Made(Description):
    free = FREE
    success = JointPosition("lift.slide", above=0.4)
    reward = (Paid("height", Height("arm.tcp"), 0.0),)
"""
ALWAYS, NEVER = 'Above("arm.tcp", height=-9.0)', 'Above("arm.tcp", height=9.0)'


@pytest.fixture
def lift(make):
    """The environment, whose joint is free while a condition holds."""

    def make_lift(free):
        return make(SCENE, DESCRIPTION.replace("FREE", free), files={"lift.urdf": URDF})

    return make_lift


def heights(env, steps=3):
    env.reset(seed=0)
    slide = [env.episode.world.joint("lift.slide")]
    for _ in range(steps):
        env.step(still(env))
        slide.append(env.episode.world.joint("lift.slide"))
    return slide


def test_a_joint_holds_while_its_condition_does_not(lift):
    assert heights(lift(NEVER)) == pytest.approx([0.0] * 4, abs=0.001)


def test_a_joint_is_free_from_the_reset_on_while_its_condition_holds(lift):
    first, *_, last = heights(lift(ALWAYS))
    assert first > -0.1
    assert last < first - 0.2  # three control steps of falling


def test_a_joint_is_locked_as_soon_as_its_condition_ends(lift):
    env = lift('~JointPosition("lift.slide", below=-0.05)')
    slide = heights(env, steps=6)
    assert slide[-1] < -0.05
    assert slide[-1] == pytest.approx(slide[-2], abs=0.001)
    assert slide[-1] > -0.4  # not at the end of its range
