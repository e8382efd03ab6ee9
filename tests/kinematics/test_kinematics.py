from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pybullet_data
import pytest

from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, norm, subtract, turn_between
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.inverse import solve
from taskbuilder.sim.bodies import load_urdf

ASSETS = Path(pybullet_data.getDataPath())
BASE = Pose.from_rpy_deg((1.0, 0.2, 0.3), (10, 20, 30))
TOOL = Pose.from_rpy_deg((0.01, 0.02, 0.1), (5, 10, 15))

# URDF, the arm's joints, the link that carries the tool.
ARMS = {
    "kuka": ("kuka_iiwa/model.urdf", range(7), 6),
    "xarm6": ("xarm/xarm6_with_gripper.urdf", range(1, 7), 7),
    "panda": ("franka_panda/panda.urdf", range(7), 11),
}


@pytest.fixture(params=ARMS)
def arm(request, client):
    urdf, joints, tip = ARMS[request.param]
    body = load_urdf(client, ASSETS / urdf, name=request.param, pose=BASE, fixed_base=True)
    return body, list(joints), tip


@pytest.fixture
def chain(arm) -> Chain:
    return chain_of(*arm)


def chain_of(body, joints, tip):
    """The chain of a body that was loaded from a URDF, by Bullet's indices."""
    names = {joint.index: name for name, joint in body.joints.items()}
    links = {index: name for name, index in body.links.items()}
    urdf = read_urdf(ASSETS / ARMS[body.name][0], (), trusted=True)
    return Chain.of(urdf, [names[index] for index in joints], links[tip], TOOL)


def middle(chain: Chain) -> list[float]:
    return ((chain.lower + chain.upper) / 2).tolist()


def test_forward_kinematics_agrees_with_the_simulation(arm, chain):
    body, joints, tip = arm
    rng = np.random.default_rng(1)
    for _ in range(20):
        positions = rng.uniform(chain.lower, chain.upper).tolist()
        body.reset_joints(joints, positions)
        simulated, computed = body.link_pose(tip) @ TOOL, body.pose() @ chain.forward(positions)
        assert norm(subtract(simulated.position, computed.position)) < 2e-6
        assert turn_between(simulated.quaternion, computed.quaternion) < 2e-6


def test_nearly_every_reachable_pose_is_found(chain):
    rng = np.random.default_rng(2)
    targets = [chain.forward(rng.uniform(chain.lower, chain.upper)) for _ in range(100)]
    results = [solve(chain, target, start=middle(chain), rng=rng) for target in targets]
    assert sum(result.ok for result in results) >= 99
    for target, result in zip(targets, results, strict=True):
        if result.ok:
            assert chain.within_limits(result.joints)
            reached = chain.forward(result.joints)
            assert norm(subtract(reached.position, target.position)) <= 1e-3
            assert turn_between(reached.quaternion, target.quaternion) <= math.radians(0.5)


def test_the_same_generator_gives_the_same_solution(chain):
    target = chain.forward(np.random.default_rng(3).uniform(chain.lower, chain.upper))
    one, other = (
        solve(chain, target, start=middle(chain), rng=np.random.default_rng(4)) for _ in range(2)
    )
    assert one == other


def test_no_more_chance_is_used_than_the_attempts_that_it_took(chain):
    for seed in range(10):
        target = chain.forward(np.random.default_rng(seed).uniform(chain.lower, chain.upper))

        def found(attempts, seed=seed, target=target):
            rng = np.random.default_rng(seed)
            result = solve(chain, target, start=middle(chain), rng=rng, attempts=attempts)
            return result, rng.random()

        needed = next(count for count in range(1, 21) if found(count)[0].ok)
        assert found(20) == found(needed)


def test_an_unreachable_pose_is_reported_with_how_near_it_gets(chain):
    result = solve(
        chain, Pose((5.0, 0.0, 0.0)), start=middle(chain), rng=np.random.default_rng(0), attempts=3
    )
    assert not result.ok
    assert 2.0 < result.position_error_m < 5.0
    assert chain.within_limits(result.joints)


def test_joints_that_turn_on_and_on_stay_at_the_turn_they_are_on(client):
    urdf, joints, tip = ARMS["xarm6"]
    body = load_urdf(client, ASSETS / urdf, name="xarm6", fixed_base=True)
    chain = chain_of(body, joints, tip)
    start = np.array([5.5, -0.6, -0.9, -5.0, 0.7, 4.5])
    target = chain.forward(start)
    rng = np.random.default_rng(0)
    away = solve(chain, target, start=start + np.array([-0.3, 0.2, 0.1, 0.2, -0.1, 0.3]), rng=rng)
    assert away.ok
    assert away.joints == pytest.approx(start.tolist(), abs=0.02)


def test_joints_off_the_way_are_refused(client):
    body = load_urdf(client, ASSETS / ARMS["panda"][0], name="panda", fixed_base=True)
    with pytest.raises(SimulationError, match=r"panda\.urdf: joints"):
        chain_of(body, [0, 1, 9], 6)
