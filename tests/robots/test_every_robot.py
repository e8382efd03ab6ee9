"""What holds for every robot of the library, whoever made its URDF."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pybullet
import pytest
from loaded_robot import ROBOTS, Load, LoadedRobot, load_robot

FILES = sorted(ROBOTS.glob("*/robot.yaml"))
NAMES = [path.parent.name for path in FILES]
WITH_FINGERS = [path.parent.name for path in FILES if "\ngripper:" in path.read_text()]
WITH_ONE_JAW = {"so101"}  # which closes against a fixed one
WITH_TWO_FINGERS = [name for name in WITH_FINGERS if name not in WITH_ONE_JAW]
ENDS = {"gripper", "suction"}


@pytest.fixture(scope="module")
def loaded() -> Iterator[dict[str, LoadedRobot]]:
    robots: dict[str, LoadedRobot] = {}
    yield robots
    for robot in robots.values():
        pybullet.disconnect(physicsClientId=robot.client)


@pytest.fixture
def load(loaded: dict[str, LoadedRobot]) -> Load:
    """Loads each robot once: these tests only pose it, and each finds it at home."""

    def load_or_reuse(name: str) -> LoadedRobot:
        if name not in loaded:
            loaded[name] = load_robot(name)
        loaded[name].go_home()
        return loaded[name]

    return load_or_reuse


def test_library_has_its_robots() -> None:
    assert {"panda", "ur5e", "xarm6"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
class TestRobot:
    def test_file_is_named_after_its_folder(self, load: Load, name: str) -> None:
        spec = load(name).spec
        assert spec["robot"] == name
        assert set(spec) - ENDS == {"robot", "summary", "urdf", "arm", "tcp", "home_deg"}
        assert len(ENDS & set(spec)) <= 1

    def test_names_exist_in_the_urdf(self, load: Load, name: str) -> None:
        robot = load(name)
        gripper = robot.spec.get("gripper", {"joints": {}, "fingers": []})
        assert set(robot.spec["arm"]) | set(gripper["joints"]) <= set(robot.joints)
        assert {robot.spec["tcp"]["link"], *itertools.chain(*gripper["fingers"])} <= set(
            robot.links
        )

    def test_all_moving_joints_are_driven(self, load: Load, name: str) -> None:
        robot = load(name)
        moving = {
            joint
            for joint, index in robot.joints.items()
            if pybullet.getJointInfo(robot.body, index, physicsClientId=robot.client)[2]
            != pybullet.JOINT_FIXED
        }
        assert moving == set(robot.spec["arm"]) | robot.gripper_joints

    def test_home_and_gripper_lie_within_limits(self, load: Load, name: str) -> None:
        robot = load(name)
        used = list(zip(robot.spec["arm"], robot.home, strict=True))
        for joint, ends in robot.spec.get("gripper", {"joints": {}})["joints"].items():
            used += [(joint, ends["open"]), (joint, ends["closed"])]
        for joint, position in used:
            info = pybullet.getJointInfo(
                robot.body, robot.joints[joint], physicsClientId=robot.client
            )
            assert info[8] - 1e-6 <= position <= info[9] + 1e-6, joint

    def test_tcp_is_in_front_of_the_base_and_points_down(self, load: Load, name: str) -> None:
        position, rotation = load(name).tcp_pose()
        far, high = (0.15, 0.05) if name == "so101" else (0.25, 0.1)  # it reaches 25 cm
        assert position[0] > far or name == "gantry"  # which stands around its workspace
        assert abs(position[1]) < 0.2
        assert position[2] > high
        # x forward, y to the right, z down: the same for every robot.
        np.testing.assert_allclose(rotation, np.diag([1.0, -1.0, -1.0]), atol=1e-4)


@pytest.mark.parametrize("name", WITH_TWO_FINGERS)
class TestFingers:
    def test_fingers_close_along_y_towards_the_tcp(self, load: Load, name: str) -> None:
        robot = load(name)
        opened = robot.finger_centers()
        robot.move_gripper("closed")
        closed = robot.finger_centers()
        sides = [np.sign(center[1]) for center in opened]
        assert sorted(sides) == [-1.0, 1.0]
        left = max(0.0, robot.gap())  # some fingers never touch each other
        stroke = robot.spec["gripper"]["stroke"] - left
        for side, before, after in zip(sides, opened, closed, strict=True):
            travel = side * (before[1] - after[1])
            assert travel == pytest.approx(stroke / 2, abs=0.002)
            assert abs(before[0]) < 0.002
            assert side * after[1] > 0

    def test_fingers_mirror_each_other(self, load: Load, name: str) -> None:
        robot = load(name)
        for key in ("open", "closed"):
            robot.move_gripper(key)
            one, other = robot.finger_centers()
            np.testing.assert_allclose(one * [1.0, -1.0, 1.0], other, atol=1e-3)


@pytest.mark.parametrize("name", WITH_FINGERS)
def test_pads_surround_the_tcp_and_close_on_it(load: Load, name: str) -> None:
    robot = load(name)
    widths = []
    for share in (0.5, 0.75):
        robot.open_gripper(share)
        widths.append(robot.open_along_y())
    assert 0.0 < widths[0] < widths[1]
    assert widths[1] < robot.spec["gripper"]["stroke"]
