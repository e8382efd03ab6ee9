from __future__ import annotations

import math

import numpy as np
import pytest
from moves import bench

from taskbuilder.errors import ExplosionError
from taskbuilder.geometry import Pose

WEIGHTS = """
    one: {shape: {box: [0.2, 0.2, 0.2]}, mass: 500, position: [2, 0, 1]}
    other: {shape: {sphere: 0.1}, mass: 0.001, position: [3, 0, 1]}
"""


def test_a_control_step_takes_its_time(build):
    world = build("timing: {control_hz: 20, physics_hz: 240}\n" + bench().split("\n", 2)[2])
    world.objects["block"].body.place(Pose((1.0, 0.0, 3.0)))
    for _ in range(10):
        world.step()
    assert world.time == pytest.approx(0.5)
    assert world.velocity("block")[0][2] == pytest.approx(-9.81 * 0.5, rel=0.05)  # Bullet damps


def test_targets_reach_their_end_with_the_last_physics_step(build, monkeypatch):
    world = build(bench())
    arm = world.robots["arm"]
    told: list[tuple[float, ...]] = []

    def listening(issue):
        def listen(positions):
            told.append(tuple(positions))
            issue(positions)

        return listen

    for way in ("pass_by", "position"):
        monkeypatch.setattr(arm.arm, way, listening(getattr(arm.arm, way)))
    target = tuple(joint + 0.12 for joint in arm.home)
    world.step({"arm": target})
    assert told[-1] == target == arm.arm.command.values
    expected = np.linspace(arm.home, target, 13)[1:]
    np.testing.assert_allclose(told, expected, atol=1e-12)


def test_targets_that_do_not_change_leave_the_physics_as_it_was(build):
    world = build(bench())
    moment = world.save()
    world.step()
    alone = world.robots["arm"].arm_state()
    world.restore(moment)
    world.step({"arm": world.robots["arm"].home})
    assert world.robots["arm"].arm_state() == alone


def test_an_arm_follows_a_moving_target_with_little_lag_and_no_overshoot(build):
    world = build(bench(height=0.6))
    arm = world.robots["arm"]
    turn = [0.06] + [0.0] * 5  # 5 cm at the reach of 0.8 m
    at = np.array(arm.home)
    for _ in range(10):
        at = at + turn
        world.step({"arm": tuple(at)})
        lag = at[0] - arm.arm_state()[0][0]
        assert 0.0 < lag < 0.01
    for _ in range(5):
        world.step()
        assert arm.arm_state()[0][0] < at[0] + 1e-3
    assert arm.arm_state()[0][0] == pytest.approx(at[0], abs=1e-3)


def test_a_ramp_after_other_commands_begins_where_the_arm_is(build, monkeypatch):
    world = build(bench(height=0.6))
    arm = world.robots["arm"]
    arm.arm.velocity([0.5, 0, 0, 0, 0, 0])
    for _ in range(5):
        world.step()
    start = arm.arm_state()[0]
    assert start[0] > arm.home[0] + 0.1
    world.step({"arm": start})
    assert arm.arm.command.values == start
    assert arm.arm_state()[0] == pytest.approx(start, abs=0.02)


def test_torques_last_through_a_control_step(build):
    world = build(bench(height=0.6))
    arm = world.robots["arm"]
    arm.arm.torque([5.0, 0, 0, 0, 0, 0])
    world.client.step(1)
    after_one = arm.arm_state()[1][0]
    world.step()
    assert after_one > 0.0
    assert arm.arm_state()[1][0] > 8.0 * after_one


def test_an_absurd_force_on_an_arm_is_an_explosion(build):
    world = build(bench())
    world.robots["arm"].arm.torque([1e9] * 6)
    with pytest.raises(ExplosionError, match="arm has its joint"):
        world.step()


def test_an_object_that_flies_off_is_an_explosion(build):
    world = build(bench() + WEIGHTS)
    world.objects["other"].body.place(Pose((49.9, 0.0, 1.0)))
    world.client.bullet.resetBaseVelocity(world.objects["other"].body.id, (20.0, 0.0, 0.0))
    with pytest.raises(ExplosionError, match="other is at"):
        world.step()


def test_an_object_without_a_place_any_more_is_an_explosion(build):
    world = build(bench() + WEIGHTS)
    body = world.objects["one"].body
    world.client.bullet.resetBasePositionAndOrientation(body.id, (math.nan, 0, 0), (0, 0, 0, 1))
    with pytest.raises(ExplosionError, match="one"):
        world.step()
