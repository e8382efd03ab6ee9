from __future__ import annotations

import math

import pytest

from taskbuilder.errors import ExplosionError
from taskbuilder.geometry import Pose
from taskbuilder.sim.bullet import p
from taskbuilder.sim.divergence import check_joints, check_pose

STILL = (0.0, 0.0, 0.0)


def test_a_calm_scene_passes(client, table, tray, panda):
    client.step(10)
    for body in (table, tray, panda):
        check_pose(body.name, body.pose())
    check_joints("panda", panda.joint_speeds(range(9)))


def test_a_body_far_away_is_named(make_cube):
    cube = make_cube((0.0, 0.0, 60.0))
    with pytest.raises(ExplosionError, match=r"cube is at .*60"):
        check_pose("cube", cube.pose())


def test_a_joint_at_bullets_clamp_is_an_explosion(client, panda):
    for _ in range(3):
        client.bullet.setJointMotorControl2(panda.id, 0, p.TORQUE_CONTROL, force=1e9)
        client.step(1)
    with pytest.raises(ExplosionError, match="panda has its joint 0"):
        check_joints("panda", panda.joint_speeds([0]))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_explosions(bad):
    with pytest.raises(ExplosionError, match="stick"):
        check_pose("stick", Pose((0.0, bad, 0.0)))
    with pytest.raises(ExplosionError, match="orientation"):
        check_pose("stick", Pose(STILL, (0.0, bad, 0.0, 1.0)))
    with pytest.raises(ExplosionError, match="joint 1"):
        check_joints("arm", (0.0, bad))
