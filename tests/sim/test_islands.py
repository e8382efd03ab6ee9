from __future__ import annotations

import pytest

from taskbuilder.geometry import Pose
from taskbuilder.shapes import BoxShape, Part
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.client import Client
from taskbuilder.sim.islands import unite


def test_bodies_in_one_island_move_as_if_they_were_alone():
    ends = []
    for together in (False, True):
        with Client(physics_hz=120) as client:
            parts = {"cube": Part(BoxShape((0.04, 0.04, 0.04)))}
            places = ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0))
            cubes = [create_body(client, parts, mass=0.05, pose=Pose(at)) for at in places]
            if together:
                unite(cubes)
            client.bullet.resetBaseVelocity(cubes[1].id, (1.0, 2.0, 3.0), (0.5, 0.0, 0.0))
            client.step(60)
            ends.append([(cube.pose(), cube.velocity()) for cube in cubes])
    assert ends[0] == ends[1]
    assert ends[0][0] != ends[0][1]


def test_an_arm_and_things_without_joints_can_be_in_one_island(client, panda, panda_arm, make_cube):
    cube = make_cube((0.5, 0.5, 0.5))
    unite([panda, cube])
    home = (0.0, -0.5, 0.0, -2.3, 0.0, 1.8, 0.8)
    panda.reset_joints(tuple(range(7)), home)
    panda_arm.position(home)
    client.step(12)
    positions, _ = panda.joint_states(tuple(range(7)))
    assert positions == pytest.approx(home, abs=0.01)
    assert cube.pose().position == pytest.approx((0.5, 0.5, 0.5 - 9.81 * 0.1**2 / 2), abs=0.01)


def test_one_body_alone_needs_nothing(client, make_cube):
    unite([make_cube((0.0, 0.0, 1.0))])
    assert client.bullet.getNumConstraints() == 0
