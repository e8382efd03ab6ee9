"""`taskbuilder robots` and `robots check`."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import pytest

from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.schema.catalogue import Catalogue

ROBOTS = sorted(Catalogue.discover().robots)
QUICK = ("gantry", "so101", "ur5e_suction")
"""One of each kind: on rails, on a base with fingers, and with a cup."""


def test_robots_are_listed(run):
    ran = run("robots")
    assert run("robots", "list").out == ran.out
    head, *rows = ran.out.splitlines()
    assert head.split() == ["robot", "joints", "gripper", "summary"]
    assert [row.split()[0] for row in rows] == ROBOTS


def test_robots_as_json_have_the_documented_shape(run):
    listed = run("robots", "--json").data["robots"]
    assert [robot["name"] for robot in listed] == ROBOTS
    keys = {"name", "path", "joints", "gripper", "stroke", "summary"}
    assert all(set(robot) == keys for robot in listed)
    (pusher,) = [robot for robot in listed if robot["name"] == "ur5e_pusher"]
    assert (pusher["gripper"], pusher["stroke"]) == (None, None)


@pytest.mark.parametrize(
    "robot",
    [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in ROBOTS],
)
def test_a_robot_of_the_catalogue_is_sound(robot, run):
    ran = run("robots", "check", robot, "--json")
    data = ran.data
    assert (ran.status, ran.err, data["ok"], data["findings"]) == (0, "", True, [])
    assert data["picture"] == f"renders/{robot}.png"
    picture = cv2.imread(data["picture"])
    assert picture.shape == (480, 480, 3)
    assert picture.std() > 10


def test_the_table_names_the_part_that_each_joint_plays(run):
    lines = run("robots", "check", "ur5e", "--out", "ur5e.png").out.splitlines()
    roles = {line.split()[0]: " ".join(line.split()[-2:]) for line in lines if "revolute" in line}
    assert roles["shoulder_pan_joint"] == "arm 1"
    assert roles["wrist_3_joint"] == "arm 6"
    assert lines[-3:] == ["ok", "ur5e.png", "ur5e-reach.png"]


def test_a_urdf_can_be_checked_by_the_name_that_a_robot_file_gives_it(run):
    ran = run("robots", "check", "package://pybullet_data/r2d2.urdf", "--json")
    assert (ran.status, ran.err) == (0, "")
    assert ran.data["ok"]
    assert len(ran.data["joints"]) > 5


def test_any_urdf_can_be_checked_by_its_path(run):
    urdf = Path(pybullet_data_folder()) / "r2d2.urdf"
    ran = run("robots", "check", str(urdf), "--json")
    assert ran.data["ok"]
    assert Path("renders/physics.png").is_file()


def test_a_urdf_of_a_ros_package_finds_its_meshes(run, tmp_path):
    package = tmp_path / "made_description"
    for name in ("urdf", "meshes"):
        (package / name).mkdir(parents=True)
    shutil.copy(Path(pybullet_data_folder()) / "cube.obj", package / "meshes" / "cube.obj")
    mesh = '<geometry><mesh filename="package://made_description/meshes/cube.obj"/></geometry>'
    text = f'<robot name="made"><link name="a"><collision>{mesh}</collision></link></robot>'
    (package / "urdf" / "made.urdf").write_text(text)
    ran = run("robots", "check", str(package / "urdf" / "made.urdf"), "--json")
    assert (ran.data["ok"], ran.data["findings"]) == (True, [])


def own_robot(folder, name):
    """A robot file, and a URDF, of a folder's own; by its name it may be one of the library."""
    entry = Catalogue.discover().robots["ur5e"]
    shutil.copytree(entry.file.parent, folder / name)
    text = entry.file.read_text().replace("robot: ur5e", f"robot: {name}")
    (folder / name / "robot.yaml").write_text(text)


@pytest.mark.parametrize(
    "words",
    [
        ("--task-path", "mine", "own"),
        ("--json", "mine/own/robot.yaml"),
    ],
)
def test_options_may_stand_before_the_robot(words, run, tmp_path):
    own_robot(tmp_path / "mine", "own")
    ran = run("robots", "check", *words)
    assert (ran.status, ran.err) == (0, "")
    assert "renders/own.png" in ran.out


def test_one_word_too_many_is_still_refused(run):
    ran = run("robots", "check", "--json", "ur5e", "panda")
    assert ran.status == 2
    assert '"panda" is one word too many' in ran.err


def test_a_robot_of_the_name_of_one_of_the_library_stops_only_what_uses_it(run, tmp_path):
    own_robot(tmp_path / "mine", "ur5e")
    path = ("--task-path", "mine")
    library = Catalogue.discover()
    twice = f'error[TB008] the robot "ur5e" is also {library.robots["ur5e"].file}'
    listed = run("robots", *path)
    assert listed.status == 0
    assert {line.split()[0] for line in listed.out.splitlines()} >= set(ROBOTS)
    assert twice in listed.err
    assert run("list", *path).out.count("\n") > len(library.tasks)
    assert run("validate", "reach", "--level", "static", *path).status == 0  # of a panda
    both = run("validate", "reach", "lift_pot", "--level", "static", *path)
    assert both.status == 1
    assert "reach · 1 robot" in both.out
    assert twice in both.out
