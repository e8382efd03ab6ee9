"""Xacro, SDF and MJCF."""

from __future__ import annotations

import pytest
from made_robots import arm, link, two_fingers

from taskbuilder.errors import FileError
from taskbuilder.importing.folders import ImportSource, import_object, import_robot
from taskbuilder.importing.postures import read_postures

SIZED = '<box size="$(arg size) 0.1 0.1"/>'
XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="made">
<xacro:arg name="size" default="0.05"/>
<xacro:include filename="$(find my_robot_description)/urdf/{included}"/>
{inside}
</robot>"""


@pytest.fixture
def xacro(package):
    pytest.importorskip("xacro")

    def write(inside: str, included: str = "more.xacro"):
        extra = link("extra", SIZED)
        (package / "urdf" / "more.xacro").write_text(
            f'<robot xmlns:xacro="http://www.ros.org/wiki/xacro">{extra}</robot>'
        )
        file = package / "urdf" / "arm.urdf.xacro"
        file.write_text(XACRO.format(inside=inside, included=included))
        return file

    return write


def test_xacro_is_expanded_without_ros(xacro):
    file = xacro("")
    text = import_object(ImportSource(file, arguments={"size": "0.2"})).files["made.urdf"].decode()
    assert 'box size="0.2 0.1 0.1"' in text


@pytest.mark.parametrize(
    ("inside", "included", "said"),
    [
        ("", "lost.xacro", "lost.xacro"),
        ('<link name="$(arg nobody)"/>', "more.xacro", "--arg nobody=VALUE"),
        ('<link name="${1/0}"/>', "more.xacro", "division"),
        ('<link name="$(find nowhere)"/>', "more.xacro", "--package nowhere=DIR"),
        ('<xacro:include filename="/etc/passwd"/>', "more.xacro", "outside the import root"),
    ],
)
def test_what_is_wrong_with_a_xacro_file_is_said(xacro, inside, included, said):
    file = xacro(inside, included)
    with pytest.raises(FileError) as error:
        import_object(ImportSource(file))
    assert said in str(error.value)
    assert error.value.findings[0].location.file.name


def test_nothing_is_executed(xacro, tmp_path):
    marker = tmp_path / "marker"
    tricks = (
        "().__class__.__base__.__subclasses__()",
        f"xacro.load_yaml('{tmp_path}/secret.yaml')",
        f"open('{marker}', 'w')",
    )
    (tmp_path / "secret.yaml").write_text("password: 1")
    for trick in tricks:
        with pytest.raises(FileError):
            import_object(ImportSource(xacro(f'<link name="${{{trick}}}"/>')))
    assert not marker.exists()


SDF = """<sdf version="1.7"><model name="box_arm"><static>0</static>
<link name="base"><pose>1 2 3 0 0 0</pose><inertial><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision></link>
<link name="tip"><pose>1 2 3.5 0 0 0</pose><inertial><mass>1</mass></inertial>
<visual name="v"><geometry><sphere><radius>0.05</radius></sphere></geometry>
<material><diffuse>1 0 0 1</diffuse></material></visual>
<sensor name="eye" type="camera"/></link>
<joint name="lift" type="prismatic"><parent>base</parent><child>tip</child>
<pose>0 0 -0.2 0 0 0</pose>
<axis><xyz>0 0 1</xyz><limit><lower>0</lower><upper>0.3</upper></limit></axis></joint>
</model></sdf>"""


def test_sdf_says_the_same(tmp_path):
    file = tmp_path / "model.sdf"
    file.write_text(SDF)
    imported = import_object(ImportSource(file))
    text = imported.files["box_arm.urdf"].decode()
    assert '<joint name="lift" type="prismatic">' in text
    assert 'xyz="0 0 0.3"' in text  # the joint, in the frame of the base
    assert 'xyz="0 0 0.2"' in text  # the ball, in the frame of the joint
    assert any("sensor" in what for what in imported.changes.left_out)
    file.write_text(SDF.replace('type="prismatic"', 'type="ball"'))
    with pytest.raises(FileError, match=r"model\.sdf:.*ball"):
        import_object(ImportSource(file))


MJCF = """<mujoco model="two_link"><compiler angle="degree"/>
<default><geom rgba="0 1 0 1"/><default class="big"><geom size="0.05 0.2"/></default></default>
<worldbody><body name="base"><geom type="box" size="0.1 0.1 0.05"/>
<body name="upper" pos="0 0 0.1"><joint name="shoulder" axis="0 1 0" range="-90 90"/>
<geom class="big" type="capsule" mass="1"/>
<body name="lower" pos="0 0 0.4"><joint name="elbow" pos="0 0 0.1" axis="0 1 0" range="0 120"/>
<geom class="big" type="cylinder"/></body></body></body></worldbody>
<actuator><motor joint="elbow"/></actuator>
<keyframe><key name="home" qpos="0.5 1"/></keyframe></mujoco>"""


def test_mjcf_says_the_same_and_its_keyframe_is_home(tmp_path):
    file = tmp_path / "arm.xml"
    file.write_text(MJCF)
    imported = import_robot(ImportSource(file))
    assert [joint.name for joint in imported.proposal.arm] == ["shoulder", "elbow"]
    assert imported.proposal.home == pytest.approx((0.5, 1.0))
    assert imported.proposal.arm[1].upper == pytest.approx(2.0944, abs=1e-3)
    assert imported.proposal.arm[1].origin.position == pytest.approx((0, 0, 0.5))
    assert "<actuator>" in imported.changes.left_out
    assert read_postures(file) == {"home": {"shoulder": 0.5, "elbow": 1.0}}
    assert 'capsule radius="0.05" length="0.4"' in imported.files["two_link.urdf"].decode()


SRDF = """<robot name="r"><group_state name="home" group="arm"><joint name="a" value="1.5"/>
</group_state><group_state name="open" group="hand"><joint name="f" value="0.04"/></group_state>
<group_state name="open" group="other"><joint name="g" value="{}"/></group_state></robot>"""


def test_group_states_of_srdf(tmp_path):
    file = tmp_path / "r.srdf"
    file.write_text(SRDF.format("0.1"))
    assert read_postures(file) == {
        "home": {"a": 1.5}, "hand/open": {"f": 0.04}, "other/open": {"g": 0.1},
    }  # fmt: skip
    file.write_text(SRDF.format("x"))
    with pytest.raises(FileError, match=r"r\.srdf:3:.*'x' should be a number"):
        read_postures(file)
    file.write_text("<robot/>")
    with pytest.raises(FileError, match="names no postures"):
        read_postures(file)


def test_archives_and_other_formats_are_named(tmp_path):
    for name, content, said in (
        ("robot.zip", b"PK\x03\x04", "archive"),
        ("robot.urdf", b"PK\x03\x04", "archive"),
        ("robot.usd", b"#usda", "USD files are not read"),
        ("robot.xml", b"<html/>", "the root element is <html>"),
    ):
        file = tmp_path / name
        file.write_bytes(content)
        with pytest.raises(FileError, match=said):
            import_robot(ImportSource(file))


def test_forty_joints(write):
    text = arm() + two_fingers()
    for number in range(34):
        text += link(f"d{number}", '<box size="0.01 0.01 0.01"/>')
        text += (
            f'<joint name="e{number}" type="revolute"><parent link="l0"/><child link="d{number}"/>'
            '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    imported = import_robot(ImportSource(write(text)))
    assert len(imported.proposal.arm) == 6
