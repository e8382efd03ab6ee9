from __future__ import annotations

import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.sim.motors import Motors, couple

HOME = [0.0, -0.4, 0.0, -2.0, 0.0, 1.6, 0.8]
FINGERS = (9, 10)


def test_position_commands_are_reached(client, panda, panda_arm):
    panda_arm.position(HOME)
    client.step(360)
    positions, speeds = panda.joint_states(panda_arm.indices)
    assert positions == pytest.approx(HOME, abs=5e-3)
    assert max(map(abs, speeds)) < 1e-2


def test_position_commands_keep_to_the_velocity_limit_in_every_later_command(client, panda):
    panda.reset_joints(range(7), HOME)
    motors = Motors(panda, range(7), forces=[200.0] * 7, velocities=[0.5] * 7)
    motors.velocity([0.0] * 7)
    client.step(2)
    for _ in range(2):
        motors.position([1.0, *HOME[1:]])
        client.step(30)
        assert panda.joint_states([0])[1][0] == pytest.approx(0.5, abs=0.02)


def test_velocity_commands_are_reached(client, panda):
    panda.reset_joints(range(7), HOME)
    motors = Motors(panda, range(7), forces=[200.0] * 7)
    motors.velocity([0.2, 0, 0, 0, 0, 0, -0.3])
    client.step(60)
    assert panda.joint_states([0, 6])[1] == pytest.approx((0.2, -0.3), abs=1e-2)


def test_torque_lasts_one_physics_step_unless_repeated(client, panda):
    client.bullet.setGravity(0, 0, 0)
    motors = Motors(panda, [6], forces=[10.0])
    motors.torque([0.1])
    client.step(1)
    after_one = panda.joint_states([6])[1][0]
    client.step(1)
    assert panda.joint_states([6])[1][0] <= after_one
    client.step(1, drives=[iter(motors.repeat, "never")])
    assert panda.joint_states([6])[1][0] > 1.5 * after_one


def test_released_motors_let_go(client, panda, panda_arm):
    panda_arm.position(HOME)
    client.step(60)
    before = panda.joint_states([1])[0][0]
    panda_arm.release()
    client.step(60)
    assert abs(panda.joint_states([1])[0][0] - before) > 0.2


def test_coupled_fingers_stay_symmetric_under_a_load_on_one(client, panda):
    def difference() -> float:
        for _ in range(60):
            client.bullet.applyExternalForce(panda.id, 10, (0.0, 5.0, 0.0), (0, 0, 0), 1)
            client.step(1)
        left, right = panda.joint_states(FINGERS)[0]
        return abs(left - right)

    panda.reset_joints(FINGERS, [0.02, 0.02])
    Motors(panda, range(7), forces=[200.0] * 7).velocity([0.0] * 7)
    Motors(panda, [9], forces=[20.0]).position([0.02])
    couple(client, panda, 9, 10)
    assert difference() < 1e-3


def test_lists_of_different_length_are_refused(panda):
    with pytest.raises(SimulationError, match="7 motors"):
        Motors(panda, range(7), forces=[1.0] * 6)


def test_a_command_with_a_value_too_few_is_refused(panda_arm):
    with pytest.raises(SimulationError):
        panda_arm.position([0.0] * 6)
