"""Homes that are proposed for robots of which only the URDF is known, measured by PyBullet."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pybullet
import pytest
from loaded_robot import Load, LoadedRobot

from taskbuilder.assets.urdf import read_urdf
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import load_robot
from taskbuilder.world.robot_proposal import Proposal, propose

ROBOTS = sorted(Catalogue.discover().robots)


@pytest.fixture(scope="module", params=ROBOTS)
def proposed(request: pytest.FixtureRequest) -> tuple[str, Proposal]:
    """A robot of the library, and what its URDF alone says of it."""
    return request.param, propose(load_robot(Catalogue.discover().robots[request.param]).urdf)


@pytest.fixture
def at_home(proposed: tuple[str, Proposal], load: Load) -> LoadedRobot:
    """A robot where its URDF says that it is at home."""
    name, proposal = proposed
    robot = load(name)
    robot.move_arm(proposal.home)
    return robot


def moved_by(robot: LoadedRobot) -> dict[int, int]:
    """Link -> how many joints of the arm are between it and the base."""
    count = {-1: 0}
    for link in range(pybullet.getNumJoints(robot.body, physicsClientId=robot.client)):
        parent = robot.info(link)[16]
        count[link] = count[parent] + (link in robot.arm)
    return count


def nearest(robot: LoadedRobot, one: int, body: int, other: int, within: float) -> float:
    found = pybullet.getClosestPoints(
        robot.body, body, within, one, other, physicsClientId=robot.client
    )
    return min((point[8] for point in found), default=math.inf)


def test_the_tool_points_down_before_the_base(at_home):
    position, rotation = at_home.tcp_pose()
    assert rotation[2, 2] < -0.999
    assert position[0] > 0.1
    assert abs(position[1]) < 0.02
    assert position[2] > 0.03


def test_no_link_lies_on_the_plane_of_the_base(at_home):
    plane = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[9, 9, 0.5], physicsClientId=at_home.client
    )
    ground = pybullet.createMultiBody(
        0, plane, basePosition=[0, 0, -0.5], physicsClientId=at_home.client
    )
    for link, joints in moved_by(at_home).items():
        if joints >= 2:  # not a shoulder, which is where it is
            assert nearest(at_home, link, ground, -1, 1.0) > 0.02, at_home.info(link)[12]


def test_no_link_is_in_another(at_home):
    joints = moved_by(at_home)
    for one, other in itertools.combinations(joints, 2):
        if abs(joints[one] - joints[other]) >= 2:
            assert nearest(at_home, one, at_home.body, other, 0.02) > 0.0


def test_no_joint_is_near_a_limit(at_home):
    for joint in at_home.arm:
        info = at_home.info(joint)
        low, high = info[8:10]
        position = pybullet.getJointState(at_home.body, joint, physicsClientId=at_home.client)[0]
        if low < high and info[2] == pybullet.JOINT_REVOLUTE:
            assert low + math.radians(8) < position < high - math.radians(8)


FLAT = """<robot name="flat"><link name="base"/>
{links}</robot>"""
PIECE = """<link name="l{n}"><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.04 0.04"/></geometry></collision>
</link><joint name="j{n}" type="revolute"><parent link="{parent}"/><child link="l{n}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/><limit lower="{low}" upper="0.6" effort="9" velocity="2"/>
</joint>
"""


@pytest.mark.parametrize(("axis", "low", "said"), [("0 0 1", -2, 1), ("0 1 0", 0.3, 2)])
def test_a_home_that_is_not_what_it_should_be_is_a_question(axis, low, said, tmp_path):
    """An arm that is always level, and one that reaches below its base whatever it does."""
    turns = {"axis": axis, "low": low}
    links = PIECE.format(n=1, parent="base", at="0 0 0.05", **turns)
    links += "".join(PIECE.format(n=n, parent=f"l{n - 1}", at="0.2 0 0", **turns) for n in (2, 3))
    file = tmp_path / "flat.urdf"
    file.write_text(FLAT.format(links=links))
    proposal = propose(read_urdf(file, (tmp_path,), fixed=True))
    questions = [one for one in proposal.remarks if "home" in one]
    assert len(questions) == said
    assert "points down" in questions[0]
    assert np.isfinite(proposal.home).all()
