"""`taskbuilder objects`."""

from __future__ import annotations

import math

import cv2
import pytest

from taskbuilder.schema.catalogue import Catalogue

OBJECTS = sorted(Catalogue().objects)


def test_the_list_names_every_object(run):
    rows = run("objects").out.splitlines()[1:]
    assert [name for row in rows if (name := row[:1].strip() and row.split()[0])] == OBJECTS


def test_the_list_for_programs(run):
    listed = {each["name"]: each for each in run("objects", "list", "--json").data["objects"]}
    assert sorted(listed) == OBJECTS
    assert listed["mug"]["shape"] == "mesh"
    assert {"rim", "handle"} <= set(listed["mug"]["grasps"])
    assert listed["jar"]["joints"] == ["rise", "screw"]


def test_a_check_renders_the_object(run):
    ran = run("objects", "check", "mug")
    assert ran.status == 0
    assert "0.28 kg" in ran.out
    assert "handle" in ran.out
    pixels = cv2.imread("renders/mug.png")
    reddish = (pixels[:, :, 2].astype(int) - pixels[:, :, 1]) > 60
    assert reddish.mean() > 0.03


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("object: block\nsummary: A block.\nshape: {mesh: no.obj}\nmass: 1\n", "no.obj"),
        ("object: brick\nsummary: A block.\nshape: {sphere: 0.1}\nmass: 1\n", "use one name"),
        ("object: block\nsummary: A block.\nshape: {sphere: 0.1}\n", "mass is missing"),
        ("object: block\nsummary: A block.\nmass: 1\n", "exactly one of shape, parts"),
        ("object: block\nsummary: A block.\nshape: {sphere: 0.1}\nmas: 1\n", '"mass"'),
        (
            "object: block\nsummary: A block.\nshape: {sphere: 0.1}\nmass: 1\n"
            "grasps: {top: {link: lid}}\n",
            "no URDF and has no links",
        ),
    ],
)
def test_what_is_wrong_with_an_object_is_said_where_it_is(run, tmp_path, text, message):
    file = tmp_path / "block" / "object.yaml"
    file.parent.mkdir()
    file.write_text(text, encoding="utf-8")
    ran = run("objects", "check", str(file))
    assert ran.status == 1
    assert message in ran.out
    assert "object.yaml:" in ran.out
    assert "(has errors)" in run("objects", "--task-path", str(tmp_path)).out


def test_an_object_that_there_is_not(run):
    ran = run("objects", "check", "mugg")
    assert ran.status == 2
    assert 'did you mean "mug"?' in ran.err


def test_check_wants_a_name(run):
    ran = run("objects", "check")
    assert ran.status == 2
    assert "which object?" in ran.err


BOX = """<robot name="box"><link name="body">
<inertial><mass value="{mass}"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
</inertial><collision><origin rpy="{roll} 0 0"/><geometry><box size="{size}"/></geometry>
</collision></link></robot>"""


@pytest.fixture
def box(tmp_path):
    """A URDF of a box in a folder of its own, as an import writes it."""

    def write(size, *, mass=0.2, roll=0.0):
        file = tmp_path / "objects" / "box" / "box.urdf"
        file.parent.mkdir(parents=True)
        file.write_text(BOX.format(size=size, mass=mass, roll=roll))
        return file

    return write


def test_a_urdf_is_measured_and_grasp_points_are_proposed(run, box):
    file = box("0.06 0.04 0.05")
    data = run("objects", "check", str(file), "--json").data
    assert data["ok"], data["findings"]
    assert data["size"] == pytest.approx([0.06, 0.04, 0.05])
    assert data["mass"] == pytest.approx(0.2)
    assert data["proposed_grasps"].keys() == {"grasp"}
    point = data["proposed_grasps"]["grasp"]
    assert point["across"] == "y"
    assert point["at"] == pytest.approx([0.0, 0.0, 0.005], abs=0.006)
    assert 0.04 < data["sides"]["y"]["opening"] < 0.05
    assert 0.06 < data["sides"]["x"]["opening"] < 0.07
    assert "panda" in data["sides"]["x"]["grippers"]
    assert "sawyer" not in data["sides"]["x"]["grippers"]
    assert data["flat_radius"] == pytest.approx(0.02, abs=0.003)
    assert data["rest"] == {
        "tilt_deg": 0.0,
        "rpy_deg": [0, 0, 0],
        "still": True,
        "rocks": False,
        "steady": True,
        "twitches": False,
    }


def test_grasp_points_and_joints_are_told_with_their_frames_and_limits(run):
    lines = run("objects", "check", "box").out.splitlines()
    (knob,) = (line for line in lines if line.split()[:1] == ["knob"])
    assert knob.endswith("at [0.0, -0.129, 0.004] in the frame of lid, approach down, across x")
    (hinge,) = (line for line in lines if line.split()[:1] == ["hinge"])
    assert hinge.endswith("moves lid from 0 to 110°")


HULL = """<robot name="hull"><link name="body"><inertial><origin xyz="{center}"/>
<mass value="0.1"/><inertia ixx="3e-4" iyy="4e-5" izz="3e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="hull.obj"/></geometry></collision></link></robot>"""


@pytest.fixture
def between(tmp_path):
    """A URDF of the hull between two polygons with as many corners, (n, 3) each."""

    def write(low, high, center="0 0 0"):
        n = len(low)
        caps = [(0, i + 1, i) for i in range(1, n - 1)]
        caps += [(n, n + i, n + i + 1) for i in range(1, n - 1)]
        sides = [(i, (i + 1) % n, n + (i + 1) % n) for i in range(n)]
        sides += [(i, n + (i + 1) % n, n + i) for i in range(n)]
        lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in [*low, *high]]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in [*caps, *sides]]
        (tmp_path / "hull.obj").write_text("\n".join(lines))
        file = tmp_path / "hull.urdf"
        file.write_text(HULL.format(center=center))
        return file

    return write


def test_what_rocks_on_a_round_underside_is_laid_on_another_side(run, between):
    round_side = [-0.02 + 0.004 * number for number in range(16)]
    profile = [(x, 0.1 - math.sqrt(0.01 - x * x)) for x in round_side]
    profile += [(0.04, 0.03), (-0.02, 0.03)]
    ends = ([(x, y, z) for x, z in profile] for y in (-0.08, 0.08))
    ran = run("objects", "check", str(between(*ends, center="0.01 0 0.015")))
    assert "on a table: it rocks; lay it on another side, as with rpy_deg: [180, 0, 0]" in ran.out
    assert "yaw_deg: [-180, 180], rpy_deg: [180, 0, 0]}" in ran.out


def test_a_hull_that_twitches_is_told(run, between):
    turns = [2.0 * math.pi * number / 32 for number in range(32)]
    low = [(0.03 * math.cos(turn), 0.09 * math.sin(turn), -0.01) for turn in turns]
    high = [(0.8 * x, 0.8 * y, 0.01) for x, y, _ in low]
    ran = run("objects", "check", str(between(low, high)))
    assert "on a table: it stands as it is" in ran.out
    assert "it twitches although nothing touches it" in ran.out
    assert "or import it with --collision boxes" in ran.out


def test_the_folder_of_an_import_is_an_object(run, box):
    folder = box("0.06 0.04 0.05").parent
    ran = run("objects", "check", str(folder))
    assert ran.status == 0
    assert "size: 60 × 40 × 50 mm (x, y, z)" in ran.out
    assert "across y: 40 mm wide; a gripper has to open 46 mm" in ran.out
    assert "on a table: it stands as it is" in ran.out
    assert "      shape: {urdf: objects/box/box.urdf}" in ran.out
    assert "        grasp: {at: [0.0, 0.0, " in ran.out


@pytest.mark.parametrize(
    ("size", "mass", "said"),
    [
        ("0.3 0.2 0.05", 0.2, "a gripper has to open 206 mm, which none of the"),
        ("0.3 0.2 0.05", 0.2, "grasp it at a rim or a handle, from the side, or by suction"),
        ("0.3 0.2 0.05", 0.2, "ur5e_suction (38 mm) holds it at [0.0, 0.0, 0.025]"),
        ("0.3 0.2 0.05", 9.0, "ur5e_suction holds 60 N, and it weighs 88 N"),
        ("0.03 0.03 0.05", 0.2, "that of ur5e_suction has 38 mm, so its edge is not on it"),
    ],
)
def test_what_can_hold_an_object_is_said(run, box, size, mass, said):
    assert said in run("objects", "check", str(box(size, mass=mass))).out


def test_of_what_tilts_the_orientation_is_said_in_which_it_lies(run, box):
    ran = run("objects", "check", str(box("0.2 0.1 0.04", roll=0.2)))
    assert "it tilts by 11°; place it with rpy_deg: [-11, 0, 0]" in ran.out
    assert "yaw_deg: [-180, 180], rpy_deg: [-11, 0, 0]}" in ran.out


def test_what_is_long_has_a_grasp_point_at_each_end(run, box):
    data = run("objects", "check", str(box("0.03 0.24 0.05")), "--json").data
    points = data["proposed_grasps"]
    assert points.keys() == {"grasp", "left_end", "right_end"}
    assert {point["across"] for point in points.values()} == {"x"}
    assert points["left_end"]["at"][1] < -0.04 < 0.04 < points["right_end"]["at"][1]


def test_a_mesh_is_an_object_without_a_mass(run, tmp_path):
    corners = [(x, y, z) for z in (0, 0.04) for y in (0, 0.04) for x in (0, 0.04)]
    faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    (tmp_path / "cube.obj").write_text("\n".join(lines))
    ran = run("objects", "check", "cube.obj")
    assert ran.status == 0
    assert "cube · 0.064 kg" in ran.out
    assert "density: 1000  # or mass: in kg" in ran.out


def test_what_is_no_object_is_said(run, box, tmp_path):
    (tmp_path / "thing.glb").write_bytes(b"glTF")
    ran = run("objects", "check", "thing.glb")
    assert ran.status == 2
    assert "taskbuilder objects import thing.glb" in ran.err
    folder = box("0.06 0.04 0.05").parent
    (folder / "other.urdf").write_text("")
    ran = run("objects", "check", str(folder))
    assert ran.status == 2
    assert "name one of box.urdf, other.urdf" in ran.err


def test_an_import_ends_with_lines_for_a_task(run, tmp_path):
    pytest.importorskip("trimesh")
    file = tmp_path / "theirs" / "brick" / "model.urdf"
    file.parent.mkdir(parents=True)
    file.write_text(BOX.format(size="0.06 0.04 0.05", mass=0.2, roll=0))
    file.write_text(file.read_text().replace('name="box"', 'name="model"'))
    ran = run("objects", "import", str(file))
    assert ran.status == 0
    assert "across y: 40 mm wide" in ran.out
    assert "    brick:\n      shape: {urdf: objects/brick/brick.urdf}\n" in ran.out
    assert "        grasp: {at: [0.0, 0.0, " in ran.out
    assert run("objects", "check", "objects/brick").status == 0
    again = run("objects", "import", str(file))
    assert again.status == 2
    assert "give this one another name with --name" in again.err
