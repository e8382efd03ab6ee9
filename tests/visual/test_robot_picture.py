"""Pictures of robots alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cameras import STUDIO
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import load_robot
from taskbuilder.visual.robot_picture import take_robot_picture

BALL = """\
<robot name="ball">
  <link name="ball">
    <visual>
      <geometry><sphere radius="{0}"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material>
    </visual>
    <collision><geometry><sphere radius="{0}"/></geometry></collision>
  </link>
</robot>
"""


def reddish(picture):
    red, green, _ = np.moveaxis(picture.astype(int), 2, 0)
    return red > 2 * green


@pytest.mark.parametrize("radius", [0.005, 0.5, 20])
def test_small_and_large_things_fill_the_picture_alike(radius, tmp_path):
    file = tmp_path / "ball.urdf"
    file.write_text(BALL.format(radius))
    picture, _ = take_robot_picture(read_urdf(file, [tmp_path]), {}, trusted=True)
    assert (picture.shape, picture.dtype) == ((480, 480, 3), np.uint8)
    there = reddish(picture)
    assert 0.02 < there.mean() < 0.6
    assert not there[0].any()
    assert not there[:, 0].any()


def test_joints_are_where_they_are_asked_to_be():
    robot = load_robot(Catalogue.discover().robots["ur5e"])
    poses = [{}, {"elbow_joint": 1.5}, {"elbow_joint": 1.5}]
    pictures = [take_robot_picture(robot.urdf, pose, trusted=True)[0] for pose in poses]
    assert not np.array_equal(pictures[0], pictures[1])
    assert np.array_equal(pictures[1], pictures[2])


def test_a_robot_stands_before_the_backdrop():
    robot = load_robot(Catalogue.discover().robots["ur5e"])
    picture, said = take_robot_picture(robot.urdf, {}, trusted=True)
    assert picture[0, 0].tolist() == list(STUDIO.top)
    assert said == ()


def test_of_a_urdf_without_shapes_the_picture_is_empty(tmp_path: Path):
    file = tmp_path / "nothing.urdf"
    file.write_text('<robot name="nothing"><link name="base"/></robot>')
    picture, _ = take_robot_picture(read_urdf(file, [tmp_path]), {}, trusted=True)
    assert (picture.std(axis=1) == 0).all()
