"""Robots as makers ship them become folders that check."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from made_robots import arm, ascii_stl, box_mesh, jaw, joint, link, snapshot, two_fingers

from taskbuilder.assets.mesh import read_mesh
from taskbuilder.errors import FileError
from taskbuilder.importing.folders import ImportSource, import_robot
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.writing import write_folder
from taskbuilder.schema.catalogue import CatalogueEntry
from taskbuilder.schema.robots import load_robot
from taskbuilder.world.robot_proposal import link_pose

BALL = '<sphere radius="0.1"/>'
MESH = '<mesh filename="{}"/>'


def written(imported, folder):
    write_folder(folder / imported.name, imported.files, overwrite=True)
    return load_robot(CatalogueEntry(imported.name, folder / imported.name / "robot.yaml"))


def rows(imported, what):
    return [row for row in imported.changes.rows if row.what == what]


def test_a_ros_layout_is_found_upwards_and_beside(write, tmp_path):
    stl = ascii_stl(box_mesh((0.05, 0.05, 0.1)))
    up = MESH.format("../meshes/part.stl")
    package = MESH.format("package://my_robot_description/meshes/part.stl")
    other = tmp_path / "ws" / "src" / "gripper_description"
    (other / "meshes").mkdir(parents=True)
    (other / "package.xml").write_text("<package><name>gripper_stuff</name></package>")
    (other / "meshes" / "finger.stl").write_bytes(stl)
    beside = MESH.format("package://gripper_stuff/meshes/finger.stl")
    inside = arm(up) + link("l7", package) + joint("j7", "l6", "l7")
    inside += link("l8", beside) + joint("f", "l7", "l8", kind="fixed", extra="")
    robot = written(import_robot(ImportSource(write(inside, {"part.stl": stl}))), tmp_path)
    assert robot.name == "my_arm"
    assert len(robot.arm) == 7


@pytest.mark.parametrize("kind", ["dae", "glb", "ply", "obj", "stl"])
def test_meshes_of_every_format(kind, write, tmp_path):
    if kind == "dae":
        pytest.importorskip("collada")
    data = box_mesh((0.05, 0.04, 0.1)).export(file_type=kind)
    data = data.encode() if isinstance(data, str) else data
    file = write(arm(MESH.format(f"../meshes/part.{kind}")), {f"part.{kind}": data})
    robot = written(import_robot(ImportSource(file)), tmp_path)
    assert all(path.suffix == ".obj" for path in robot.urdf.meshes)
    shape = robot.urdf.link("l3").collisions[0]
    assert shape.kind == "box"
    assert sorted(shape.size) == pytest.approx([0.04, 0.05, 0.1], abs=1e-4)


def test_the_source_is_untouched_and_the_second_run_gives_the_same_bytes(write, package, tmp_path):
    mesh = box_mesh((0.05, 0.05, 0.1))
    file = write(arm(MESH.format("../meshes/p.ply")), {"p.ply": mesh.export(file_type="ply")})
    before = snapshot(package)
    first = import_robot(ImportSource(file)).files
    assert import_robot(ImportSource(file)).files == first
    assert snapshot(package) == before


def test_mimic_joints_are_followed_and_pads_belong_to_fingers(write, tmp_path):
    robot = written(import_robot(ImportSource(write(arm() + two_fingers()))), tmp_path)
    gripper = robot.spec.gripper
    assert gripper.fingers == (("finger_a", "pad_a"), ("finger_b", "pad_b"))
    assert gripper.joints["slide_a"].open == gripper.joints["slide_b"].open == 0.03
    # the pads stand 3 mm from the middle when closed, and the fingers open by 30 mm each
    assert gripper.stroke == pytest.approx(0.066, abs=1e-3)
    assert robot.spec.tcp.link == "l6"
    np.testing.assert_allclose(robot.spec.tcp.pose.axis(2), (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(np.abs(robot.spec.tcp.pose.axis(1)), (1, 0, 0), atol=1e-6)


def test_one_jaw_against_a_fixed_one_is_a_gripper(write, tmp_path):
    imported = import_robot(ImportSource(write(arm() + jaw())))
    robot = written(imported, tmp_path)
    assert [joint.name for joint in robot.arm] == [f"j{n}" for n in range(1, 7)] + ["wrist"]
    assert robot.spec.gripper.fingers == (("moving_jaw",), ("l7",))
    assert set(robot.spec.gripper.joints) == {"gripper"}
    ends = robot.spec.gripper.joints["gripper"]
    assert ends.open > ends.closed
    text = imported.files["robot.yaml"].decode()
    assert "is taken for the fixed jaw" in " ".join(text.replace("#", " ").split())


def test_a_head_is_no_arm_and_is_held(write, tmp_path):
    head = link("head", '<box size="0.1 0.1 0.1"/>') + joint("pan", "l0", "head", "0.1 0 0.1")
    imported = import_robot(ImportSource(write(arm() + two_fingers() + head)))
    robot = written(imported, tmp_path)
    assert [joint.name for joint in robot.arm] == [f"j{n}" for n in range(1, 7)]
    assert robot.urdf.joint("pan").type == "fixed"
    assert any("head" in remark for remark in imported.proposal.remarks)


def test_a_rotor_before_the_fingers_is_no_finger(write, tmp_path):
    rotor = link("prop", '<cylinder radius="0.02" length="0.1"/>') + joint(
        "spin", "l6", "prop", axis="0 0 1", kind="continuous", extra=""
    )
    imported = import_robot(ImportSource(write(arm() + rotor + two_fingers())))
    robot = written(imported, tmp_path)
    assert len(robot.spec.gripper.fingers) == 2
    assert robot.urdf.joint("spin").type == "fixed"


def test_fingers_without_collision_get_it(write, tmp_path):
    fingers = two_fingers().replace("<collision>", "<!--").replace("</collision>", "-->")
    imported = import_robot(ImportSource(write(arm() + fingers)))
    robot = written(imported, tmp_path)
    assert robot.urdf.link("finger_a").collisions
    assert [row.subject for row in rows(imported, "collision")][:1] == ["link finger_a"]


def test_empty_material_names_and_joint_names(write, tmp_path):
    text = arm().replace(
        "</visual>", '<material name=""><color rgba="1 0 0 1"/></material></visual>'
    )
    text = text.replace('name="j3"', 'name=""')
    imported = import_robot(ImportSource(write(text + two_fingers())))
    robot = written(imported, tmp_path)
    assert "l3_joint" in [joint.name for joint in robot.arm]
    assert rows(imported, "name")


def test_a_mirrored_scale_is_baked_in(write, tmp_path):
    stl = ascii_stl(box_mesh((0.05, 0.05, 0.1), (0.01, 0, 0)))
    geometry = '<mesh filename="../meshes/p.stl" scale="-1 1 1"/>'
    imported = import_robot(ImportSource(write(arm(geometry), {"p.stl": stl})))
    robot = written(imported, tmp_path)
    (shape,) = robot.urdf.link("l2").visuals
    assert shape.size == (1, 1, 1)
    assert read_mesh(shape.mesh).bounds.center[0] == pytest.approx(-0.01, abs=1e-6)
    assert rows(imported, "mesh scale")


def test_colours_of_mtl_files_are_kept(write, tmp_path):
    mesh = box_mesh((0.05, 0.05, 0.1)).export(file_type="obj", include_normals=False)
    obj = b"mtllib p.mtl\nusemtl red\n" + mesh.encode().replace(b"mtllib", b"# mtllib")
    mtl = b"newmtl red\nKd 0.8 0.1 0.2\n"
    imported = import_robot(
        ImportSource(write(arm(MESH.format("../meshes/p.obj")), {"p.obj": obj, "p.mtl": mtl}))
    )
    (material,) = [text for name, text in imported.files.items() if name.endswith(".mtl")]
    assert b"Kd 0.8 0.102 0.2" in material or b"Kd 0.8 0.1 0.2" in material


@pytest.mark.parametrize("named", [False, True], ids=["own material", "named material"])
def test_a_texture_of_a_material_is_kept_where_the_mesh_has_texture_points(named, write, package):
    from PIL import Image

    (package / "textures").mkdir()
    Image.new("RGB", (8, 8), (250, 10, 10)).save(package / "textures" / "red.png")
    square = b"v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0.05\n"
    square += b"vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 4/4 2/2\n"
    texture = '<texture filename="package://my_robot_description/textures/red.png"/>'
    material = f'<material name="paint">{texture}</material>'
    used = '<material name="paint"/>' if named else material
    text = arm(MESH.format("../meshes/square.obj")).replace("</visual>", f"{used}</visual>")
    text = (material if named else "") + text
    imported = import_robot(ImportSource(write(text, {"square.obj": square})))
    pictures = [content for name, content in imported.files.items() if name.endswith(".png")]
    assert len(pictures) == 1
    assert {row.after for row in rows(imported, "texture")} == {"kept"}
    materials = b"".join(c for name, c in imported.files.items() if name.endswith(".mtl"))
    assert b"map_Kd" in materials


def test_a_texture_without_texture_points_is_left_out_and_said(write, package):
    text = arm().replace(
        "</visual>", '<material name="p"><texture filename="no.png"/></material></visual>'
    )
    imported = import_robot(ImportSource(write(text)))
    assert {row.after for row in rows(imported, "texture")} == {"left out"}


def test_placeholder_inertias_are_computed(write, tmp_path):
    text = arm().replace('ixx="0.01" iyy="0.01" izz="0.01"', 'ixx="1" iyy="1" izz="1"')
    imported = import_robot(ImportSource(write(text + two_fingers())))
    assert len(rows(imported, "inertia")) >= 7
    robot = written(imported, tmp_path)
    moments = next(robot.urdf.tree.all("link")).first("inertial").first("inertia").attributes
    # a box of 5 × 5 × 10 cm and 1 kg
    assert float(moments["ixx"]) == pytest.approx((0.05**2 + 0.1**2) / 12, rel=1e-3)
    assert float(moments["izz"]) == pytest.approx((0.05**2 * 2) / 12, rel=1e-3)


def test_millimetres_are_recognised_and_said(write, tmp_path):
    stl = ascii_stl(box_mesh((50, 50, 100)))
    imported = import_robot(
        ImportSource(write(arm(MESH.format("../meshes/p.stl")), {"p.stl": stl}))
    )
    (row,) = {row.after for row in rows(imported, "unit")}
    assert row == "taken for millimetres"
    shape = written(imported, tmp_path).urdf.link("l1").collisions[0]
    assert max(shape.size) == pytest.approx(0.1, abs=1e-4)


def test_a_drawing_mesh_is_decimated(write, tmp_path):
    pytest.importorskip("fast_simplification")
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.05)
    data = ball.export(file_type="stl")
    imported = import_robot(
        ImportSource(write(arm(MESH.format("../meshes/b.stl")), {"b.stl": data}))
    )
    (row,) = rows(imported, "triangles")
    assert row.before == "20,480"
    assert int(row.after.replace(",", "")) <= 8000
    shape = written(imported, tmp_path).urdf.link("l1").collisions[0]
    assert shape.kind == "sphere"
    assert shape.size[0] == pytest.approx(0.05, abs=1e-3)


GRIPPER = (
    link("palm", '<box size="0.05 0.05 0.1"/>')
    + two_fingers().replace('"l6"', '"palm"')
)  # fmt: skip


def test_a_gripper_is_mounted_on_an_arm(write, package, tmp_path):
    file = write(arm())
    gripper = package / "urdf" / "gripper.urdf"
    gripper.write_text(f'<robot name="hand">{GRIPPER}</robot>')
    imported = import_robot(ImportSource(file, mounts=(Mount(gripper, "l6@0,0,0.1"),)))
    robot = written(imported, tmp_path)
    assert len(robot.arm) == 6
    assert robot.spec.gripper is not None
    assert robot.spec.tcp.link == "palm"
    assert robot.spec.tcp.position[2] > 0.1
    alone = import_robot(ImportSource(gripper))
    assert alone.proposal is None
    assert "robot.yaml" not in alone.files
    with pytest.raises(FileError, match=r'no link "l66".*did you mean "l6"'):
        import_robot(ImportSource(file, mounts=(Mount(gripper, "l66"),)))
    with pytest.raises(FileError, match="no gripper"):
        import_robot(ImportSource(file, mounts=(Mount(_fixed(package), "l6"),)))


def test_an_adapter_may_be_between_arm_and_gripper(write, package, tmp_path):
    file = write(arm())
    gripper = package / "urdf" / "gripper.urdf"
    gripper.write_text(f'<robot name="hand">{GRIPPER}</robot>')
    adapter = package / "urdf" / "adapter.urdf"
    plate = link("l1", BALL) + link("top", BALL)  # the arm has an l1, too
    plate += joint("bolts", "l1", "top", "0 0 0.05", kind="fixed", extra="")
    adapter.write_text(f'<robot name="adapter">{plate}</robot>')
    chain = (Mount(adapter, "l6@0,0,0.1"), Mount(gripper, "top@0,0,0.02"))
    imported = import_robot(ImportSource(file, mounts=chain))
    robot = written(imported, tmp_path)
    assert robot.spec.gripper is not None
    parents = {joint.child: joint.parent for joint in robot.urdf.joints}
    assert parents["palm"] == "adapter_top"
    assert parents["adapter_l1"] == "l6"
    pose = link_pose(robot.urdf, "l6", "palm", {})
    assert pose.position == pytest.approx((0.0, 0.0, 0.17))
    mounted = [(row.subject, row.after) for row in rows(imported, "mounted")]
    assert mounted == [("adapter", "adapter_l1 on l6"), ("gripper", "palm on adapter_top")]
    with pytest.raises(FileError, match="mount the gripper on it with another --gripper and --at"):
        import_robot(ImportSource(file, mounts=chain[:1]))


def _fixed(package):
    file = package / "urdf" / "block.urdf"
    file.write_text(f'<robot name="block">{link("block", BALL)}</robot>')
    return file


def test_the_robot_file_is_what_is_read(write):
    text = import_robot(ImportSource(write(arm() + two_fingers()), name="mine")).files["robot.yaml"]
    data = yaml.safe_load(text)
    assert data["robot"] == "mine"
    assert data["urdf"] == "mine.urdf"
