"""Joints of articulated objects as task files describe them: springs, damping, limits, locks."""

from __future__ import annotations

import math

import pytest
from moves import state

from taskbuilder.sim.bullet import p

MACHINE = """<robot name="machine">
  <link name="case">
    <inertial><mass value="5"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="cap">
    <inertial><mass value="0.05"/>
      <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.04 0.04 0.02"/></geometry></collision>
  </link>
  <joint name="button" type="prismatic">
    <parent link="case"/><child link="cap"/><origin xyz="0 0 0.1"/><axis xyz="1 0 0"/>
    <limit lower="-0.05" upper="0.05" effort="50" velocity="1"/>
  </joint>
  <link name="hatch">
    <inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.1 0.01"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="case"/><child link="hatch"/><origin xyz="0 0.3 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="2" effort="50" velocity="1"/><dynamics damping="0.5" friction="0"/>
  </joint>
  <link name="wheel">
    <inertial><mass value="0.2"/>
      <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.1 0.1 0.01"/></geometry></collision>
  </link>
  <joint name="axle" type="continuous">
    <parent link="case"/><child link="wheel"/><origin xyz="0 -0.3 0"/><axis xyz="0 0 2"/>
  </joint>
</robot>
"""

ROOM = """
timing: {control_hz: 20, physics_hz: 240}
scene:
  robots:
    arm: {model: ur5e, base: {position: [-1, 0, 0]}}
  objects:
    machine:
      shape: {urdf: machine.urdf}
      fixed: true
      position: [0, 1, 0.5]
      joints: JOINTS
"""


@pytest.fixture
def room(build, tmp_path):
    (tmp_path / "machine.urdf").write_text(MACHINE, encoding="utf-8")

    def make(joints):
        world = build(ROOM.replace("JOINTS", joints))
        world.reset(0)
        return world

    return make


def push(world, joint, position, speed=0.0):
    body = world.objects["machine"].body
    index = body.joints[joint].index
    world.client.bullet.resetJointState(body.id, index, position, speed)
    world.refresh()


def pulled(world, joint, force, steps=10):
    """Where a joint is after a force (N or N m) has pulled at it."""
    body = world.objects["machine"].body
    index = body.joints[joint].index

    def pull():
        while True:
            world.client.bullet.setJointMotorControl2(body.id, index, p.TORQUE_CONTROL, force=force)
            yield

    world.onlooker = pull()
    for _ in range(steps):
        world.step()
    world.onlooker = None
    return world.joint(f"machine.{joint}")


def test_joints_start_where_they_are_written(room):
    world = room("{button: {start: 0.02}, hinge: {start_deg: 30}, axle: 400}")
    assert world.joint("machine.button") == pytest.approx(0.02, abs=1e-6)
    assert world.joint("machine.hinge") == pytest.approx(math.radians(30), abs=1e-6)
    assert world.joint("machine.axle") == pytest.approx(math.radians(400), abs=1e-6)


def test_a_joint_starts_anywhere_in_its_range_and_at_the_same_place_for_a_seed(room):
    world = room("{hinge: {start_range_deg: [20, 60]}, button: 0.01}")
    starts = []
    for seed in (*range(30), 0):
        world.reset(seed)
        starts.append(math.degrees(world.joint("machine.hinge")))
        assert world.joint("machine.button") == pytest.approx(0.01, abs=1e-6)
    assert starts[0] == starts[-1]
    assert 20 <= min(starts) < 27
    assert 53 < max(starts) <= 60


def test_a_lock_holds_a_joint_where_the_episode_has_put_it(room):
    world = room("{hinge: {start_range_deg: [20, 60], lock: {unless: allowed}}}")
    starts = []
    for seed in range(4):
        world.reset(seed)
        starts.append(world.joint("machine.hinge"))
        for _ in range(5):
            world.step()
        assert world.joint("machine.hinge") == pytest.approx(starts[-1], abs=math.radians(0.5))
    assert max(starts) - min(starts) > math.radians(5)


def test_a_pattern_speaks_of_all_joints_that_have_no_key_of_their_own(room):
    world = room('{"*": {start_deg: 30, friction: 0}, button: 0.02, axle: 400}')
    assert world.joint("machine.button") == pytest.approx(0.02, abs=1e-6)
    assert world.joint("machine.hinge") == pytest.approx(math.radians(30), abs=1e-3)
    assert world.joint("machine.axle") == pytest.approx(math.radians(400), abs=1e-6)


def test_limits_of_the_task_file_stop_a_joint(room):
    world = room("{button: {limits: [-0.01, 0.02]}, axle: {limits_deg: [-20, 45]}}")
    assert pulled(world, "button", 5.0) == pytest.approx(0.02, abs=1e-3)
    assert pulled(world, "button", -5.0) == pytest.approx(-0.01, abs=1e-3)
    assert pulled(world, "axle", 0.6, 40) == pytest.approx(math.radians(45), abs=0.02)


def test_a_spring_gives_way_as_far_as_its_stiffness_says(room):
    world = room("{button: {friction: 0, spring: {stiffness: 200}, damping: 4}}")
    assert pulled(world, "button", 4.0, 60) == pytest.approx(0.02, abs=2e-4)
    for _ in range(60):
        world.step()
    assert world.joint("machine.button") == pytest.approx(0.0, abs=2e-4)


def test_a_spring_pulls_to_where_it_rests(room):
    world = room("{hinge: {friction: 0, damping: 0.05, spring: {stiffness: 1, rest_deg: 40}}}")
    for _ in range(100):
        world.step()
    assert world.joint("machine.hinge") == pytest.approx(math.radians(40), abs=0.01)


def test_a_spring_swings_at_its_frequency(room):
    world = room("{button: {friction: 0, damping: 0, spring: {stiffness: 20}}}")
    push(world, "button", 0.03)
    seen = []
    for _ in range(20):
        world.step()
        seen.append(world.joint("machine.button"))
    period = 2 * math.pi * math.sqrt(0.05 / 20)
    wanted = [0.03 * math.cos(2 * math.pi * (k + 1) / 20 / period) for k in range(20)]
    assert seen == pytest.approx(wanted, abs=4e-3)


@pytest.mark.parametrize("damping", [0.5, 1e4])
def test_damping_slows_a_joint_and_never_turns_it_round(room, damping):
    world = room(f"{{button: {{friction: 0, damping: {damping}}}}}")
    push(world, "button", -0.04, speed=0.4)
    world.step()
    body = world.objects["machine"].body
    _, (speed,) = body.joint_states((body.joints["button"].index,))
    expected = 0.4 * math.exp(-damping / 0.05 * 0.05)
    assert speed == pytest.approx(expected, abs=0.02)
    assert speed >= -1e-9


def test_friction_of_a_joint_is_what_it_takes_to_move_it(room):
    world = room("{button: {friction: 3}, hinge: {friction: 0}}")
    assert pulled(world, "button", 2.8) == pytest.approx(0.0, abs=1e-4)
    assert pulled(world, "button", 3.5) > 0.01


class TestLocks:
    LOCKED = "{hinge: {start_deg: 20, friction: 0, damping: 0, lock: {unless: allowed}}}"

    def test_a_locked_joint_does_not_give_way(self, room):
        world = room(self.LOCKED)
        assert world.locked == {"machine.hinge": "allowed"}
        assert pulled(world, "hinge", 300.0, 40) == pytest.approx(math.radians(20), abs=2e-3)
        assert pulled(world, "hinge", -300.0, 40) == pytest.approx(math.radians(20), abs=2e-3)

    def test_it_is_free_while_its_condition_holds_and_held_where_it_is_afterwards(self, room):
        world = room(self.LOCKED)
        world.set_locks({"allowed": True})
        assert world.locked == {}
        opened = pulled(world, "hinge", 0.05)
        assert opened > math.radians(25)
        push(world, "hinge", opened)
        world.set_locks({"allowed": False})
        assert pulled(world, "hinge", 100.0) == pytest.approx(opened, abs=2e-3)

    def test_every_episode_begins_locked(self, room):
        world = room(self.LOCKED)
        world.set_locks({"allowed": True})
        pulled(world, "hinge", 0.05)
        world.reset(1)
        assert world.locked
        assert world.joint("machine.hinge") == pytest.approx(math.radians(20), abs=1e-6)

    def test_going_back_restores_locks_and_springs_to_the_bit(self, room):
        joints = self.LOCKED[:-1] + ", button: {spring: {stiffness: 100}, damping: 0.2}}"
        world = room(joints)

        def episode():
            seen = []
            for step in range(12):
                world.set_locks({"allowed": step in (3, 4, 5, 9)})
                pulled(world, "hinge", 0.08, 1)
                seen.append((state(world), dict(world.locked)))
            return seen

        push(world, "button", 0.03)
        locked = world.save()
        first = episode()
        world.set_locks({"allowed": True})
        free = world.save()
        second = episode()
        world.restore(locked)
        assert world.locked
        assert episode() == first
        world.restore(free)
        assert not world.locked
        assert episode() == second


def test_what_has_no_lock_and_no_spring_costs_nothing(room):
    world = room("{hinge: {friction: 2, limits_deg: [0, 50]}}")
    assert world.objects["machine"].passive == {}
