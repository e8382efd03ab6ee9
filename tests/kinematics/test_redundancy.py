"""Arms on a base: the base moves if the arm alone does not reach, and comes along with the tool."""

from __future__ import annotations

import math

import numpy as np
import pytest

from taskbuilder.geometry import norm, subtract, turn_between
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.differential_ik import DifferentialIK
from taskbuilder.kinematics.inverse import beginnings_of, solve
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import load_robot


def chain_of(name, *, posture=True):
    robot = load_robot(Catalogue.discover().robots[name])
    spec = robot.spec
    home = robot.home if posture else None
    return Chain.of(robot.urdf, spec.arm, spec.tcp.link, spec.tcp.pose, home), robot.home


@pytest.fixture(scope="module")
def mobile():
    return chain_of("mobile_ur5e")


def test_only_joints_beyond_six_of_an_arm_that_slides_are_a_base():
    names = ("ur5e", "panda", "xarm6", "gantry", "mobile_ur5e")
    assert [chain_of(name)[0].base for name in names] == [0, 0, 0, 0, 3]


def test_the_arm_alone_is_the_same_arm(mobile):
    chain, home = mobile
    rng = np.random.default_rng(1)
    for base in rng.uniform(-1, 1, (10, 3)).tolist():
        arm = chain.with_base_at(base)
        one, other = arm.forward(home[3:]), chain.forward([*base, *home[3:]])
        assert norm(subtract(one.position, other.position)) < 1e-12
        assert turn_between(one.quaternion, other.quaternion) < 1e-7


@pytest.mark.parametrize(("shift", "moves"), [((0.1, 0.1, -0.1), False), ((1.5, 0.4, 0.0), True)])
def test_the_base_moves_only_for_what_is_beyond_the_arm(mobile, shift, moves):
    chain, home = mobile
    target = chain.forward(home).moved(shift)
    found = solve(chain, target, start=home, rng=np.random.default_rng(0))
    assert found.ok
    assert (found.joints[:3] != tuple(home[:3])) is moves


def test_further_beginnings_bend_the_arm_as_it_likes_it(mobile):
    chain, home = mobile
    drawn = beginnings_of(chain, np.random.default_rng(0), 200)
    assert np.abs(drawn[:, 3:] - home[3:]).mean() < 0.4
    assert drawn[:, :3].std(axis=0).min() > 1.0
    assert ((drawn >= chain.lower) & (drawn <= chain.upper)).all()


def follow(ik, joints, shift, steps):
    for _ in range(steps):
        target = ik.forward(joints).moved(shift)
        joints = ik.step(joints, target, (0.3,) * len(joints))
        reached = ik.forward(joints)
        assert norm(subtract(reached.position, target.position)) < 2e-3
        assert turn_between(reached.quaternion, target.quaternion) < math.radians(1)
    return joints


def test_a_short_way_is_the_arms_and_a_long_one_the_bases(mobile):
    chain, home = mobile
    ik = DifferentialIK.of(chain)
    short = follow(ik, home, (0.02, 0.0, 0.0), 2)
    assert abs(short[0]) < 0.025  # of 0.04
    far = follow(ik, home, (0.03, 0.01, 0.0), 50)
    assert far[0] > 1.0
    assert max(abs(q - p) for q, p in zip(far[3:], home[3:], strict=True)) < 0.8


def test_a_tool_that_stands_still_keeps_the_base_still(mobile):
    chain, home = mobile
    ik = DifferentialIK.of(chain)
    joints = follow(ik, home, (0.04, 0.0, 0.0), 5)
    still = follow(ik, joints, (0.0, 0.0, 0.0), 20)
    np.testing.assert_allclose(still, joints, atol=1e-6)


def test_small_and_large_steps_lead_to_the_same_joints(mobile):
    chain, home = mobile
    ik = DifferentialIK.of(chain)
    small, large = follow(ik, home, (0.01, 0.0, 0.0), 60), follow(ik, home, (0.04, 0.0, 0.0), 15)
    np.testing.assert_allclose(small, large, atol=0.05)


def test_an_arm_without_a_base_does_not_care_for_a_posture():
    for name in ("panda", "ur5e"):
        (one, home), (other, _) = chain_of(name), chain_of(name, posture=False)
        target = one.forward(home).moved((0.1, -0.1, 0.05))
        found = [solve(c, target, start=home, rng=np.random.default_rng(0)) for c in (one, other)]
        assert found[0] == found[1]
        steps = [DifferentialIK.of(c).step(home, target, (0.3,) * len(home)) for c in (one, other)]
        assert steps[0] == steps[1]
