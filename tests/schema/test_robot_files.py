"""Robot files: ten lines over a URDF, checked against it."""

from __future__ import annotations

import math

import pytest

from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robots import joint_values, load_robot

INERTIAL = """<inertial>
      <mass value="0.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <collision><geometry><box size="0.02 0.02 0.1"/></geometry></collision>"""

# An arm of one joint, with a hand of two fingers.
URDF = f"""\
<robot name="toy">
  <link name="base"/>
  <link name="hand">{INERTIAL}</link>
  <link name="thumb">{INERTIAL}</link>
  <link name="finger">{INERTIAL}</link>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1.6" effort="10" velocity="1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="hand"/><child link="thumb"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.3" effort="10" velocity="1"/>
  </joint>
  <joint name="other_slide" type="prismatic">
    <parent link="hand"/><child link="finger"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.3" effort="10" velocity="1"/>
  </joint>
</robot>
"""

ROBOT = """\
robot: toy
summary: A hinge with a hand
urdf: toy.urdf
arm: [hinge]
tcp: {link: hand, position: [0.1, 0, 0]}
home_deg: [45]
gripper:
  joints:
    slide: {open: 0.2, closed: 0.0}
    other_slide: {open: 0.1, closed: 0.0}
  fingers: [[thumb], [finger]]
  stroke: 0.1
"""


@pytest.fixture
def findings(folder):
    def load(*changes: tuple[str, str]) -> list[str]:
        text = ROBOT
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        (folder / "toy").mkdir(exist_ok=True)
        (folder / "toy" / "toy.urdf").write_text(URDF)
        (folder / "toy" / "robot.yaml").write_text(text)
        try:
            load_robot(Catalogue().robot("toy/robot.yaml", folder))
        except FileError as error:
            return [str(finding).replace("toy/robot.yaml:", "") for finding in error.findings]
        return []

    return load


def test_one_jaw_may_stand_still(findings):
    jaw = ("    other_slide: {open: 0.1, closed: 0.0}\n", "")
    assert findings(jaw, ("[[thumb], [finger]]", "[[thumb], [hand]]")) == []
    (said,) = findings(jaw, ("[[thumb], [finger]]", "[[thumb], [base]]"))
    assert 'no joint of the gripper moves "base"' in said
    (said,) = findings(jaw, ("[[thumb], [finger]]", "[[thumb], [hand], [finger]]"))
    assert 'no joint of the gripper moves "finger"' in said


def test_a_robot_knows_its_joints_and_home_in_radians(findings, folder):
    assert not findings()
    robot = load_robot(Catalogue().robot("./toy", folder))
    assert robot.name == "toy"
    assert [joint.name for joint in robot.arm] == ["hinge"]
    assert robot.home == pytest.approx((math.pi / 4,))
    assert robot.spec.tcp.pose.position == (0.1, 0, 0)


@pytest.mark.parametrize("name", Catalogue().robots)
def test_every_robot_of_the_library_is_sound(name):
    robot = load_robot(Catalogue().robots[name])
    assert len(robot.home) == len(robot.arm)
    assert robot.name == name


def test_degrees_are_for_joints_that_turn_and_metres_for_those_that_slide(findings, folder):
    findings()
    urdf = load_robot(Catalogue().robot("./toy", folder)).urdf
    values = joint_values([urdf.joint("hinge"), urdf.joint("slide")], [90, 0.1])
    assert values == pytest.approx((math.pi / 2, 0.1))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("robot: toy", "robot: tyo", '1:8: error[TB109] robot: is "tyo"; the folder is "toy"'),
        (
            "arm: [hinge]",
            "arm: [hing]",
            '4:7: error[TB301] arm[0]: the URDF\'s joint "hing" does not exist; did you mean',
        ),
        (
            "link: hand",
            "link: han",
            '5:13: error[TB301] tcp.link: the URDF has no link "han"; did you mean "hand"?',
        ),
        (
            "[finger]]",
            "[finge]]",
            '11:23: error[TB301] gripper.fingers[1][0]: the URDF has no link "finge"; did you mean',
        ),
        (
            "    slide: {open: 0.2",
            "    slid: {open: 0.2",
            '9:5: error[TB301] gripper.joints.slid: the URDF\'s joint "slid" does not exist',
        ),
        (
            "home_deg: [45]",
            "home_deg: [45, 0]",
            "6:11: error[TB301] home_deg: ",
        ),
        (
            "home_deg: [45]",
            "home_deg: [100]",
            "6:12: error[TB302] home_deg[0]: 100° is beyond the limits of hinge; from 0° to 91.67°",
        ),
        (
            "open: 0.2",
            "open: 0.4",
            "9:19: error[TB301] gripper.joints.slide.open: 0.4 m is beyond the limits of slide; "
            "from 0 m to 0.3 m",
        ),
        ("urdf: toy.urdf", "urdf: ty.urdf", "3:7: error[TB401] urdf: "),
        ("urdf: toy.urdf\n", "", "1:1: error[TB101] urdf: missing; path relative to this file"),
        (
            "  stroke: 0.1\n",
            "  stroke: 0\n",
            "12:11: error[TB104] gripper.stroke: is 0; must be more than 0",
        ),
        (
            "fingers: [[thumb], [finger]]",
            "fingers: [[thumb]]",
            "11:12: error[TB104] gripper.fingers: has 1 value; at least 2 are needed",
        ),
    ],
)
def test_what_does_not_fit_the_urdf_is_marked_where_it_stands(findings, old, new, message):
    (found,) = findings((old, new))
    assert found.startswith(message)


def test_a_wrong_robot_and_a_wrong_urdf_are_told_in_one_run(findings, folder):
    (folder / "toy").mkdir()
    found = findings(("arm: [hinge]", "arm: hinge"), ("urdf: toy.urdf", "urdf: nothing.urdf"))
    assert [line.split()[1] for line in found] == ["error[TB401]", "error[TB103]"]
