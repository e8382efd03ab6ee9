"""Robot descriptions: what is read from good ones, and every way in which they may be wrong."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taskbuilder.assets import Urdf, codes, read_urdf, resolved_text
from taskbuilder.assets.looks import with_looks
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.errors import FileError, UnknownNameError
from taskbuilder.quiet import captured
from taskbuilder.sim.engine_output import import_pybullet

ARM = """<?xml version="1.0"?>
<robot name="arm">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0 0"/>
      <mass value="1.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
    <visual>
      <origin xyz="0  0   0.1" rpy="0 0 1"/>
      <geometry><mesh filename="meshes/part.obj" scale="0.1 0.1 0.1"/></geometry>
      <material name="red"/>
    </visual>
    <collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <origin xyz="0 0 1"/>
    <axis xyz="0 2 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
  </joint>
  <joint name="wrist" type="fixed">
    <parent link="upper"/>
    <child link="hand"/>
  </joint>
</robot>
"""
PART = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
LINK = '<link name="{}"/>'
JOINT = '<joint name="{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'

Reader = Callable[..., Urdf]


@pytest.fixture
def read(tmp_path: Path) -> Reader:
    """Writes a URDF beside a mesh and reads it."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "part.obj").write_text(PART)
    (tmp_path / "meshes" / "notes.txt").write_text("no mesh")

    def _read(text: str | bytes, **options: bool) -> Urdf:
        path = tmp_path / "arm.urdf"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_urdf(path, [tmp_path], **options)

    return _read


def changed(old: str, new: str) -> str:
    """The good arm with one thing replaced."""
    assert old in ARM
    return ARM.replace(old, new, 1)


def with_more(text: str) -> str:
    """The good arm with more elements at its end."""
    return changed("</robot>", text + "</robot>")


def test_reads_links_joints_and_files(read: Reader, tmp_path: Path) -> None:
    arm = read(ARM)
    upper, shoulder = arm.link("upper"), arm.joint("shoulder")
    assert (arm.name, arm.root, arm.warnings) == ("arm", "base", ())
    assert [link.name for link in arm.links] == ["base", "upper", "hand"]
    assert (upper.mass, arm.link("hand").mass) == (1.5, None)
    assert (upper.collisions[0].kind, upper.collisions[0].size) == ("box", (0.1, 0.2, 0.3))
    assert upper.visuals[0].mesh == (tmp_path / "meshes" / "part.obj").resolve()
    assert upper.visuals[0].pose.position == (0, 0, 0.1)
    assert arm.meshes == (upper.visuals[0].mesh,)
    assert (shoulder.axis, shoulder.lower, shoulder.upper) == ((0, 1, 0), -1, 1)
    assert (shoulder.effort, shoulder.velocity) == (10, 2)
    assert shoulder.origin.position == (0, 0, 1)
    assert arm.moving_joints == (shoulder,)
    assert arm.joint_above("hand") == arm.joint("wrist")
    assert arm.joint_above("base") is None


def test_looking_up_a_wrong_name_suggests_the_right_one(read: Reader) -> None:
    arm = read(ARM)
    with pytest.raises(UnknownNameError, match='did you mean "upper"'):
        arm.link("uper")
    with pytest.raises(UnknownNameError, match='did you mean "wrist"'):
        arm.joint("Wrist")


BROKEN: dict[str, tuple[str | bytes, str]] = {
    "empty": ("", codes.XML),
    "truncated": (ARM[:-20], codes.XML),
    "not XML": ("robot: arm", codes.XML),
    "wrong root": ("<sdf/>", codes.STRUCTURE),
    "doctype": ('<!DOCTYPE robot SYSTEM "x"><robot name="a"><link name="a"/></robot>', codes.XML),
    "entity bomb": (
        '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>',
        codes.XML,
    ),
    "unknown encoding": (b'<?xml version="1.0" encoding="martian"?><robot/>', codes.XML),
    "nested": ("<robot>" * 100 + "</robot>" * 100, codes.XML),
    "long line": (changed("<link", f"<!-- {'x' * 9000} --><link"), codes.XML),
    "xacro": (with_more("<xacro:macro/>"), codes.XML),
    "huge": (b" " * (2 * 2**20 + 1), codes.NOT_READABLE),
    "no robot name": (changed('name="arm"', ""), codes.NAME),
    "no links": ('<robot name="a"></robot>', codes.STRUCTURE),
    "two axes": (changed("<axis", '<axis xyz="1 0 0"/><axis'), codes.STRUCTURE),
    "link name twice": (with_more(LINK.format("hand")), codes.NAME),
    "joint name twice": (
        with_more(LINK.format("x") + JOINT.format("wrist", "hand", "x")),
        codes.NAME,
    ),
    "link without name": (with_more("<link/>"), codes.NAME),
    "long name": (changed('name="hand"', f'name="{"h" * 200}"'), codes.NAME),
    "line break in name": (changed('name="hand"', 'name="ha&#10;nd"'), codes.NAME),
    "two roots": (with_more(LINK.format("stray")), codes.TREE),
    "two parents": (with_more(JOINT.format("x", "base", "hand")), codes.TREE),
    "loop": (
        with_more(
            LINK.format("x")
            + LINK.format("y")
            + JOINT.format("j", "x", "y")
            + JOINT.format("k", "y", "x")
        ),
        codes.TREE,
    ),
    "only a loop": (
        '<robot name="r">'
        + LINK.format("x")
        + LINK.format("y")
        + JOINT.format("j", "x", "y")
        + JOINT.format("k", "y", "x")
        + "</robot>",
        codes.TREE,
    ),
    "own parent": (with_more(LINK.format("x") + JOINT.format("j", "x", "x")), codes.TREE),
    "unknown parent": (changed('<parent link="upper"/>', '<parent link="uper"/>'), codes.JOINT),
    "unknown child": (changed('<child link="hand"/>', '<child link="hnd"/>'), codes.JOINT),
    "no parent": (changed('<parent link="upper"/>', ""), codes.JOINT),
    "no joint type": (changed('type="fixed"', ""), codes.JOINT),
    "floating": (changed('type="fixed"', 'type="floating"'), codes.JOINT),
    "unknown joint type": (changed('type="fixed"', 'type="hinge"'), codes.JOINT),
    "zero axis": (changed("0 2 0", "0 0 0"), codes.JOINT),
    "nan axis": (changed("0 2 0", "0 nan 0"), codes.NUMBER),
    "mimics nobody": (changed("<axis", '<mimic joint="elbow"/><axis'), codes.JOINT),
    "mimics itself": (changed("<axis", '<mimic joint="shoulder"/><axis'), codes.JOINT),
    "mimics with nothing": (
        with_more(
            LINK.format("x")
            + '<joint name="j" type="continuous"><parent link="hand"/><child link="x"/>'
            '<mimic joint="shoulder" multiplier="0"/></joint>'
        ),
        codes.JOINT,
    ),
    "mimic each other": (
        with_more(
            LINK.format("x")
            + '<joint name="j" type="continuous"><parent link="hand"/><child link="x"/>'
            '<mimic joint="shoulder"/></joint>'
        ).replace("<axis", '<mimic joint="j"/><axis', 1),
        codes.JOINT,
    ),
    "no limit": (
        changed('<limit lower="-1" upper="1" effort="10" velocity="2"/>', ""),
        codes.LIMIT,
    ),
    "no lower": (changed('lower="-1"', ""), codes.LIMIT),
    "limits exchanged": (changed('lower="-1"', 'lower="3"'), codes.LIMIT),
    "infinite limit": (changed('lower="-1"', 'lower="-inf"'), codes.NUMBER),
    "negative effort": (changed('effort="10"', 'effort="-10"'), codes.LIMIT),
    "negative velocity": (changed('velocity="2"', 'velocity="-2"'), codes.LIMIT),
    "comma": (changed('value="1.5"', 'value="1,5"'), codes.NUMBER),
    "nan mass": (changed('value="1.5"', 'value="nan"'), codes.NUMBER),
    "inf mass": (changed('value="1.5"', 'value="inf"'), codes.NUMBER),
    "text mass": (changed('value="1.5"', 'value="heavy"'), codes.NUMBER),
    "empty mass": (changed('value="1.5"', 'value=""'), codes.NUMBER),
    "overflowing mass": (changed('value="1.5"', 'value="1e999"'), codes.NUMBER),
    "negative mass": (changed('value="1.5"', 'value="-1"'), codes.MASS),
    "zero mass": (changed('value="1.5"', 'value="0"'), codes.MASS),
    "absurd mass": (changed('value="1.5"', 'value="1e5"'), codes.MASS),
    "no mass": (changed('<mass value="1.5"/>', ""), codes.MASS),
    "negative inertia": (changed('ixx="0.01"', 'ixx="-0.01"'), codes.INERTIA),
    "zero inertia": (changed('ixx="0.01"', 'ixx="0"'), codes.INERTIA),
    "indefinite inertia": (changed('ixy="0"', 'ixy="0.5"'), codes.INERTIA),
    "no izz": (changed('izz="0.01"', ""), codes.INERTIA),
    "no geometry": (changed('<geometry><box size="0.1 0.2 0.3"/></geometry>', ""), codes.GEOMETRY),
    "two solids": (changed("<box", '<sphere radius="1"/><box'), codes.GEOMETRY),
    "unknown solid": (changed('box size="0.1 0.2 0.3"', "cone"), codes.GEOMETRY),
    "negative box": (changed("0.1 0.2 0.3", "0.1 -0.2 0.3"), codes.GEOMETRY),
    "flat box": (changed("0.1 0.2 0.3", "0.1 0 0.3"), codes.GEOMETRY),
    "two edges": (changed("0.1 0.2 0.3", "0.1 0.2"), codes.NUMBER),
    "huge box": (changed("0.1 0.2 0.3", "0.1 1e7 0.3"), codes.NUMBER),
    "no radius": (changed('box size="0.1 0.2 0.3"', "sphere"), codes.GEOMETRY),
    "zero scale": (changed("0.1 0.1 0.1", "0.1 0 0.1"), codes.GEOMETRY),
    "one scale": (changed("0.1 0.1 0.1", "0.1"), codes.NUMBER),
    "far away": (changed('xyz="0 0 1"', 'xyz="0 0 1e9"'), codes.NUMBER),
    "missing mesh": (changed("part.obj", "prt.obj"), codes.MISSING),
    "no mesh name": (changed('filename="meshes/part.obj"', ""), codes.MISSING),
    "mesh elsewhere": (changed("meshes/part.obj", "../../x.obj"), codes.OUTSIDE),
    "absolute mesh": (changed("meshes/part.obj", "/etc/passwd"), codes.OUTSIDE),
    "not a mesh": (changed("part.obj", "notes.txt"), codes.MESH_FORMAT),
    "missing texture": (changed("<color", '<texture filename="x.png"/><color'), codes.MISSING),
    "texture of no image type": (
        changed("<color", '<texture filename="meshes/notes.txt"/><color'),
        codes.NOT_READABLE,
    ),
}


@pytest.mark.parametrize(("text", "code"), BROKEN.values(), ids=BROKEN)
def test_refuses(read: Reader, text: str | bytes, code: str) -> None:
    with pytest.raises(FileError) as caught:
        read(text)
    errors = [finding for finding in caught.value.findings if finding.severity == "error"]
    assert code in {finding.code for finding in errors}
    assert all(finding.location for finding in errors)


@pytest.mark.parametrize("name", ["folder.urdf", "missing.urdf"])
def test_refuses_what_is_no_file(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.urdf").mkdir()
    with pytest.raises(FileError):
        read_urdf(tmp_path / name, [tmp_path])


def test_tells_everything_at_once_with_its_place(read: Reader) -> None:
    text = ARM.replace('value="1.5"', 'value="1,5"').replace("part.obj", "prt.obj")
    with pytest.raises(FileError) as caught:
        read(text.replace("0 2 0", "0 0 0"))
    found = [
        (finding.code, finding.path, finding.location.line)
        for finding in caught.value.findings
        if finding.location
    ]
    assert found == [
        (codes.NUMBER, "link upper", 8),
        (codes.MISSING, "link upper", 13),
        (codes.JOINT, "joint shoulder", 23),
    ]
    said = str(caught.value)
    assert "arm.urdf:8:7: error[TB413] link upper" in said
    assert "a point, not a comma" in said
    assert 'did you mean "part.obj"?' in said


WARNED = {
    "misspelt element": (changed("<axis", "<axsis/><axis"), codes.IGNORED),
    "inertia of no body": (changed('ixx="0.01"', 'ixx="0.05"'), codes.INERTIA),
    "no inertia": (
        changed(ARM[ARM.index("<inertial>") : ARM.index("    <visual>")], ""),
        codes.MASS,
    ),
    "no effort": (changed('effort="10"', ""), codes.LIMIT),
    "degrees": (changed('lower="-1" upper="1"', 'lower="-90" upper="90"'), codes.LIMIT),
    "millimetres": (changed("0.1 0.1 0.1", "5000 5000 5000"), codes.BAD_MESH),
}


@pytest.mark.parametrize(("text", "code"), WARNED.values(), ids=WARNED)
def test_warns(read: Reader, text: str, code: str) -> None:
    assert {finding.code for finding in read(text).warnings} == {code}


def test_what_is_fixed_to_the_world_needs_no_mass(read: Reader) -> None:
    shape = "<collision><geometry><box size='1 1 1'/></geometry></collision>"
    wall = f'<link name="wall">{shape}</link>' + JOINT.format("holds", "base", "wall")
    stands = with_more(wall)
    assert [finding.code for finding in read(stands).warnings] == [codes.MASS]
    assert read(stands, fixed=True).warnings == ()
    moved = changed(ARM[ARM.index("<inertial>") : ARM.index("    <visual>")], "")
    assert {finding.code for finding in read(moved, fixed=True).warnings} == {codes.MASS}


MASSLESS = """<robot name="block">
  <link name="block">
    <inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
</robot>"""
OF_THE_WORLD = """<robot name="block">
  <link name="world"/>
  <link name="block">
    <inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <joint name="j" type="fixed"><parent link="world"/><child link="block"/></joint>
</robot>"""


@pytest.mark.parametrize(("text", "line"), [(MASSLESS, 3), (OF_THE_WORLD, 2)])
def test_an_immovable_root_is_to_be_fixed(read: Reader, text: str, line: int) -> None:
    (finding,) = read(text).warnings
    assert (finding.code, finding.severity) == (codes.MASS, "warning")
    assert finding.location
    assert finding.location.line == line
    assert "write fixed: true" in finding.message
    assert read(text, fixed=True).warnings == ()


@pytest.mark.parametrize("name", ["", 'name=""'])
def test_materials_need_no_names_and_keep_their_colours(read: Reader, name: str) -> None:
    text = changed('material name="red"/', f"material {name}/")
    shape = '<geometry><box size="0.1 0.1 0.1"/></geometry>'
    for rgba in ("0 1 0 1", "0 0 1 1"):
        color = f'<material {name}><color rgba="{rgba}"/></material>'
        text = text.replace("</visual>", f"</visual><visual>{shape}{color}</visual>", 1)
    urdf = read(text)
    assert urdf.warnings == ()
    materials = [
        m for link in urdf.tree.all("link") for v in link.all("visual") for m in v.all("material")
    ]
    assert len(materials) == 3
    path = urdf.path.with_name("resolved.urdf")
    path.write_text(resolved_text(urdf))
    bullet = import_pybullet()
    client = bullet.connect(bullet.DIRECT)
    body = bullet.loadURDF(str(path))
    colors = [data[7] for data in bullet.getVisualShapeData(body)]
    bullet.disconnect(client)
    assert {(0, 1, 0, 1), (0, 0, 1, 1)} <= set(colors)


def test_what_belongs_to_other_programs_is_left_out_in_silence(read: Reader) -> None:
    arm = read(with_more('<gazebo reference="hand"><x/></gazebo><transmission name="t"/>'))
    assert arm.warnings == ()
    assert "gazebo" not in resolved_text(arm)


def test_a_bad_mesh_is_read_only_if_it_is_not_trusted(read: Reader, tmp_path: Path) -> None:
    read(ARM)
    (tmp_path / "meshes" / "part.obj").write_text("f 1 2 3\n")
    assert read(ARM, trusted=True).meshes
    with pytest.raises(FileError, match="TB404"):
        read(ARM)


def test_the_resolved_text_names_absolute_files_and_reads_the_same(
    read: Reader, tmp_path: Path
) -> None:
    arm = read(ARM)
    text = resolved_text(arm)
    assert str(tmp_path.resolve() / "meshes" / "part.obj") in text
    assert 'xyz="0 0 0.1"' in text  # single spaces
    assert 'xyz="0.0 1.0 0.0"' in text  # an axis of length 1
    again = read(text.replace(f"{tmp_path.resolve()}/", ""))
    assert again.joints == arm.joints
    assert again.link("hand").mass == 0


def test_names_with_special_characters_survive(read: Reader) -> None:
    text = ARM.replace('"hand"', '"h &amp; &lt;&quot;ä"')
    assert 'name="h &amp; &lt;&quot;ä"' in resolved_text(read(text))


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_text_is_read_or_refused(read_any: Reader, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(ARM)))
    length = data.draw(st.sampled_from([0, 0, 1, 2, 5, 40, 400]))
    insert = data.draw(
        st.sampled_from(["<", "/>", '"', "&x;", "&#0;", "nan", "-", "0", "1e400", " ", "<link/>"])
        | st.text(max_size=6)
    )
    text = ARM[:start] + insert + ARM[start + length :]
    try:
        urdf = read_any(text.encode("utf-8", "surrogatepass"))
    except FileError:
        return
    resolved_text(urdf)


@pytest.fixture
def read_any(read: Reader) -> Reader:
    return read


def _loads(path: Path) -> int:
    """The number of joints with which Bullet loads a file."""
    bullet = import_pybullet()
    client = bullet.connect(bullet.DIRECT)
    try:
        with captured():
            body = bullet.loadURDF(str(path), physicsClientId=client)
            return int(bullet.getNumJoints(body, physicsClientId=client))
    finally:
        bullet.disconnect(client)


def test_what_passes_loads_in_bullet(read: Reader, tmp_path: Path) -> None:
    (tmp_path / "resolved.urdf").write_text(resolved_text(read(ARM)))
    assert _loads(tmp_path / "resolved.urdf") == 2


@pytest.mark.parametrize(
    "name", ["xarm/xarm6_with_gripper.urdf", "franka_panda/panda.urdf", "kuka_iiwa/model.urdf"]
)
def test_public_robots_pass_and_load(tmp_path: Path, name: str) -> None:
    data = pybullet_data_folder()
    assert data is not None
    robot = read_urdf(data / name, [])
    path = tmp_path / "robot.urdf"
    path.write_text(resolved_text(robot))
    assert _loads(path) == len(robot.joints)


def test_importing_the_package_imports_neither_pybullet_nor_numpy() -> None:
    code = (
        "import sys; import taskbuilder.assets; "
        "sys.exit(not {'pybullet', 'numpy', 'urllib.request'}.isdisjoint(sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(("links", "right"), [(128, True), (129, False)])
def test_more_links_than_the_engine_takes_are_refused_where_they_are_read(links, right, read):
    chain = [JOINT.format(f"j{n}", f"l{n - 1}", f"l{n}") for n in range(1, links)]
    text = "\n".join([*(LINK.format(f"l{n}") for n in range(links)), *chain])
    text = f'<robot name="chain">{text}</robot>'
    if right:
        assert len(read(text).links) == links
        return
    with pytest.raises(FileError) as refused:
        read(text)
    (finding,) = refused.value.findings
    assert (finding.code, finding.location.line) == (codes.TOO_MANY, 1)
    assert "has 129 links; at most 128" in finding.message


def test_other_meshes_may_be_looked_at_but_not_collided_with(read: Reader, tmp_path: Path) -> None:
    mesh = '<geometry><mesh filename="meshes/part.obj" scale="0.1 0.1 0.1"/></geometry>'
    box = '<geometry><box size="0.1 0.2 0.3"/></geometry>'
    arm = read(ARM.replace(box, mesh))
    part = (tmp_path / "meshes" / "part.obj").resolve()
    light = tmp_path / "light.obj"
    other = with_looks(arm, lambda look: [replace(look, file=light)])
    visual, collision = resolved_text(other).split("<collision")
    assert ("light.obj" in visual, str(part) in visual) == (True, False)
    assert ("light.obj" in collision, str(part) in collision) == (False, True)
