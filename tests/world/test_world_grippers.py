"""The joints of each robot's gripper move as one, and press with its nominal force."""

from __future__ import annotations

import numpy as np
import pytest
from moves import bench, squeeze

ROBOTS = ("panda", "ur5e", "xarm6")


def spread(world) -> float:
    """How far any joint of the gripper is from their common opening, as a share of the way."""
    arm = world.robots["arm"]
    positions, _ = arm.body.joint_states(arm.gripper.joints)
    closed, opened = np.array(arm.gripper.positions(0.0)), np.array(arm.gripper.positions(1.0))
    shares = (np.array(positions) - closed) / (opened - closed)
    return float(np.abs(shares - arm.opening()).max())


@pytest.mark.parametrize("model", ROBOTS)
class TestGripper:
    def test_opens_and_closes_all_the_way_with_its_joints_together(self, build, model):
        world = build(bench(model, height=0.5))
        arm = world.robots["arm"]
        assert arm.opening() == pytest.approx(1.0, abs=1e-6)
        worst = 0.0
        for opening in (0.0, 1.0, 0.5):
            arm.move_gripper(opening)
            for _ in range(96):
                world.client.step(1)
                worst = max(worst, spread(world))
            assert arm.opening() == pytest.approx(opening, abs=0.02)
        assert worst < 0.05

    def test_squeezes_with_its_joints_together_and_its_nominal_force(self, build, model):
        world = build(bench(model))
        arm = world.robots["arm"]
        arm.move_gripper(0.0)
        worst = 0.0
        for _ in range(96):
            world.client.step(1)
            worst = max(worst, spread(world))
        squeeze(world, "arm", steps=3)
        assert worst < 0.05
        assert 0.1 < arm.opening() < 0.9
        assert world.held("block", "arm")
        assert world.grip_forces("block", "arm") == pytest.approx((20.0, 20.0), rel=0.5)
