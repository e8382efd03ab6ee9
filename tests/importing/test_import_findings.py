"""What cannot be imported is a finding with file and line, and nothing is written."""

from __future__ import annotations

import pytest
from made_robots import BOX, arm, ascii_stl, box_mesh, joint, link, snapshot, two_fingers

from taskbuilder.assets.urdf import read_urdf
from taskbuilder.cli import main
from taskbuilder.errors import FileError, UsageError
from taskbuilder.importing.folders import ImportSource, import_object, import_robot, read_robot
from taskbuilder.importing.mounting import Mount
from taskbuilder.importing.packages import Packages
from taskbuilder.importing.writing import write_folder

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="2"/>'


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (joint("j7", "l6", "l7", kind="floating", extra=""), r"TB433.*floating"),
        (joint("j7", "l6", "l7", kind="planar", extra=""), r"TB433.*planar"),
        (joint("j7", "l6", "l7", extra=""), r"TB417.*needs <limit"),
        (joint("j7", "l6", "l7") + joint("j8", "l7", "l2"), r"TB419.*one parent"),
        (joint("j7", "l6", "l7", extra='<limit lower="1" upper="0"/>'), r"TB417"),
    ],
)
def test_joints(wrong, said, write):
    file = write(arm() + "\n" + link("l7", "<sphere radius='0.1'/>") + wrong)
    with pytest.raises(FileError, match=said) as error:
        import_robot(ImportSource(file))
    place = error.value.findings[0].location
    assert place.file.name == "arm.urdf"
    assert place.line > 10


def test_a_circle_of_joints_without_a_beginning(write):
    circle = link("a", "<sphere radius='0.1'/>") + link("b", "<sphere radius='0.1'/>")
    file = write(circle + joint("x", "a", "b") + joint("y", "b", "a"))
    with pytest.raises(FileError, match=r"TB419.*a → b → a"):
        import_robot(ImportSource(file))


def test_more_joints_in_a_row_than_an_arm_has(write):
    text = link("s0", "<sphere radius='0.1'/>")
    for number in range(1, 21):
        text += link(f"s{number}", "<sphere radius='0.1'/>")
        text += joint(f"t{number}", f"s{number - 1}", f"s{number}")
    with pytest.raises(FileError, match=r"TB433.*20 joints.*at most 16") as error:
        import_robot(ImportSource(write(text)))
    finding = error.value.findings[0]
    assert finding.path == "joint t17"
    assert finding.location.file.name == "arm.urdf"
    line = finding.location.file.read_text().splitlines()[finding.location.line - 1]
    assert 'name="t17"' in line


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "TB410"),
        (b"\x00\xff\x13" * 100, "TB410"),
        (b'<!DOCTYPE a [<!ENTITY a "b">]><robot name="&a;"/>', "TB410.*document type"),
        (b"<robot name='deep'>" + b"<link>" * 5000, "TB410"),
    ],
    ids=["empty", "binary", "entities", "deep"],
)
def test_files_that_are_no_description(content, said, tmp_path):
    file = tmp_path / "robot.urdf"
    file.write_bytes(content)
    with pytest.raises(FileError, match=said):
        import_robot(ImportSource(file))


def test_a_mesh_of_more_than_is_read(write, package):
    from taskbuilder.importing.packages import MAX_BYTES

    file = write(arm('<mesh filename="../meshes/huge.stl"/>'))
    with (package / "meshes" / "huge.stl").open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)  # a file of holes takes no room
    with pytest.raises(FileError, match=r"TB403.*huge.stl") as error:
        import_robot(ImportSource(file))
    assert error.value.findings[0].location.line > 1


def test_a_mesh_of_a_hundred_megabytes_of_triangles_is_refused_before_it_is_read(write, package):
    file = write(arm('<mesh filename="../meshes/large.stl"/>'))
    count = 4_000_000
    with (package / "meshes" / "large.stl").open("wb") as stream:
        stream.write(b"\0" * 80 + count.to_bytes(4, "little"))
        stream.truncate(84 + 50 * count)
    with pytest.raises(FileError, match=r"TB404.*4,000,000 triangles; reduce it"):
        import_robot(ImportSource(file))


def test_a_file_outside_the_root(write, tmp_path):
    (tmp_path / "secret.stl").write_bytes(ascii_stl(box_mesh((0.1, 0.1, 0.1))))
    for path in ("../../../../secret.stl", f"file://{tmp_path}/secret.stl"):
        with pytest.raises(FileError, match=r"TB402.*outside the import root"):
            import_robot(ImportSource(write(arm(f'<mesh filename="{path}"/>'))))
    file = write(arm('<mesh filename="../../../../secret.stl"/>'))
    assert import_robot(ImportSource(file, root=tmp_path)).files


def test_a_link_that_leads_outside(write, package, tmp_path):
    (tmp_path / "secret.stl").write_bytes(ascii_stl(box_mesh((0.1, 0.1, 0.1))))
    (package / "meshes" / "p.stl").symlink_to(tmp_path / "secret.stl")
    with pytest.raises(FileError, match="outside the import root"):
        import_robot(ImportSource(write(arm('<mesh filename="../meshes/p.stl"/>'))))


def test_a_package_that_is_there_twice(write, tmp_path):
    for name in ("one", "two"):
        folder = tmp_path / "ws" / "src" / name
        folder.mkdir()
        (folder / "package.xml").write_text("<package><name>parts</name></package>")
        (folder / "p.stl").write_bytes(ascii_stl(box_mesh((0.05, 0.05, 0.1))))
    file = write(arm('<mesh filename="package://parts/p.stl"/>'))
    with pytest.raises(FileError, match=r"TB431.*--package parts=DIR"):
        import_robot(ImportSource(file))
    assert import_robot(ImportSource(file, {"parts": tmp_path / "ws" / "src" / "one"})).files


def test_a_package_that_is_nowhere(write):
    with pytest.raises(FileError, match=r"TB401.*--package nowhere=DIR"):
        import_robot(ImportSource(write(arm('<mesh filename="package://nowhere/p.stl"/>'))))


def test_packages_do_not_open_the_whole_disk(tmp_path):
    packages = Packages.around(tmp_path / "robot.urdf")
    for name in ("etc", "usr", "home"):
        with pytest.raises(Exception, match="no package"):
            packages.find(name)


def test_what_is_there_is_not_overwritten(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(UsageError, match="not written by an import"):
        write_folder(folder, {"a.urdf": b"imported by taskbuilder"}, overwrite=True)
    assert snapshot(folder) == {"notes.txt": b"mine"}
    other = tmp_path / "other"
    write_folder(other, {"a.urdf": b"<!-- imported by taskbuilder -->"}, overwrite=False)
    with pytest.raises(UsageError, match="--overwrite"):
        write_folder(other, {"b.urdf": b"imported by taskbuilder"}, overwrite=False)
    write_folder(other, {"b.urdf": b"imported by taskbuilder"}, overwrite=True)
    assert list(snapshot(other)) == ["b.urdf"]
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == [
        "mine", "other", "work",
    ]  # fmt: skip


def test_the_flange_is_read(write):
    for text in ("", "l6@1,2", "l6@a,b,c", "@0,0,0"):
        with pytest.raises(UsageError, match="--at"):
            import_robot(
                ImportSource(write(arm()), mounts=(Mount(write(arm(), name="g.urdf"), text),))
            )


def test_an_argument_may_be_that_of_the_arm_or_of_the_gripper(tmp_path):
    known = '<xacro:arg name="{}" default="1"/>'
    opened = '<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    files = [tmp_path / "arm.urdf.xacro", tmp_path / "hand.urdf.xacro", tmp_path / "hand.urdf"]
    palm = two_fingers().replace('link="l6"', 'link="palm"') + link("palm", BOX)
    files[0].write_text(f"{opened}{known.format('size')}{arm()}</robot>")
    files[1].write_text(f"{opened}{known.format('width')}{palm}</robot>")
    files[2].write_text(f'<robot name="x">{palm}</robot>')
    for hand, arguments, wrong in (
        (files[1], {"size": "2", "width": "3"}, ""),
        (files[2], {"size": "2"}, ""),
        (files[1], {"size": "2", "heigth": "3"}, 'has no argument "heigth"'),
        (files[2], {"width": "2"}, 'has no argument "width"'),
    ):
        source = ImportSource(files[0], arguments=arguments, mounts=(Mount(hand, "l6"),))
        if not wrong:
            read_robot(source)
            continue
        with pytest.raises(FileError, match=wrong):
            read_robot(source)
    with pytest.raises(FileError, match='has no argument "size", as it is no xacro file'):
        read_robot(ImportSource(files[2], arguments={"size": "1"}))


def test_an_argument_that_a_xacro_file_does_not_have(tmp_path):
    file = tmp_path / "arm.urdf.xacro"
    said = '<xacro:arg name="hand" default="false"/>' + arm()
    file.write_text(f'<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">{said}</robot>')
    with pytest.raises(FileError, match=r'TB430.*no argument "hands"; did you mean "hand"'):
        import_robot(ImportSource(file, arguments={"hands": "true"}))
    for wrong in ("l1", "name"):  # which are words of the file, and no arguments
        with pytest.raises(FileError, match=r"TB430.*no argument"):
            import_robot(ImportSource(file, arguments={wrong: "true"}))


@pytest.mark.parametrize(
    "content",
    [
        b"PK\x03\x04rest",
        b"\xfd7zXZ\x00rest",
        b"7z\xbc\xaf\x27\x1crest",
        b"Rar!rest",
        b"BZh9rest",
        b"robot.urdf" + b"\0" * 247 + b"ustar\x0000" + b"\0" * 300,
    ],
    ids=["zip", "xz", "7z", "rar", "bz2", "tar"],
)
def test_an_archive_is_known_by_its_content(content, tmp_path):
    file = tmp_path / "robot.urdf"
    file.write_bytes(content)
    with pytest.raises(FileError, match=r"TB433.*is an archive; unpack it"):
        import_robot(ImportSource(file))


def test_a_mesh_is_no_robot_and_no_gripper(write, package):
    mesh = package / "meshes" / "hand.stl"
    mesh.write_bytes(ascii_stl(box_mesh((0.05, 0.05, 0.1))))
    for source in (ImportSource(mesh), ImportSource(write(arm()), mounts=(Mount(mesh, "l6"),))):
        with pytest.raises(FileError, match=r"TB433.*hand.stl is a mesh.*objects import"):
            import_robot(source)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("m.obj", b"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0" + b"\nf 1 2 3" * 3_000_001),
        ("m.ply", b"ply\nformat ascii 1.0\nelement face 4000000\nend_header\n"),
        ("m.dae", b'<COLLADA><polylist count="2000000"/><triangles count="2000000"/></COLLADA>'),
    ],
    ids=["obj", "ply", "dae"],
)
def test_too_many_triangles_are_counted_before_they_are_read(name, content, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(FileError, match=r"TB404.*[34],000,00[01] triangles; reduce it"):
        import_object(ImportSource(tmp_path / name))


SHEET = b"v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n"
FINS = b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nv 0 0 -.1\nv .1 .1 .1\n" + (
    b"f 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 6\nf 3 4 5\n"  # edges of four faces, and no volume
)


@pytest.mark.parametrize("content", [SHEET, FINS], ids=["flat", "fins"])
def test_meshes_without_volume_collide(content, tmp_path):
    if content is FINS:
        pytest.importorskip("coacd")  # what has volume at all is cut into pieces first
    (tmp_path / "m.obj").write_bytes(content)
    imported = import_object(ImportSource(tmp_path / "m.obj", name="thing"))
    write_folder(tmp_path / "thing", imported.files, overwrite=False)
    urdf = read_urdf(tmp_path / "thing" / "thing.urdf", (tmp_path / "thing",))
    (shape,) = urdf.links[0].collisions
    if content is SHEET:
        assert shape.kind == "box"
        assert sorted(shape.size) == pytest.approx([0.001, 0.1, 0.1])


def test_what_is_wrong_with_the_result_is_said_at_the_source(write):
    file = write(arm().replace('value="1"', 'value="1e9"'))
    with pytest.raises(FileError, match=r"TB414") as error:
        import_robot(ImportSource(file))
    assert {finding.location.file for finding in error.value.findings} == {file}
    lines = file.read_text().splitlines()
    for finding in error.value.findings:
        link_name = finding.path.removeprefix("link ")
        assert f'name="{link_name}"' in lines[finding.location.line - 1]


def test_folders_and_names_that_cannot_be_are_refused_before_anything_is_read(write, capsys):
    file = str(write(arm()))
    assert main(["robots", "import", file, "--out", "robots/my-arm"]) == 2
    assert '"my-arm" is no name of a robot' in capsys.readouterr().err
    assert main(["robots", "import", file, "--root", "nowhere"]) == 2
    assert "--root nowhere: there is no such folder" in capsys.readouterr().err


@pytest.mark.parametrize("more", [[], ["--quick"]])
def test_a_snake_is_no_arm_when_it_is_checked(more, tmp_path, capfd):
    text = link("s0", BOX)
    for number in range(1, 41):
        text += link(f"s{number}", BOX) + joint(f"t{number}", f"s{number - 1}", f"s{number}")
    fingers = two_fingers().replace('"l6"', '"s40"')
    (tmp_path / "snake.urdf").write_text(f'<robot name="snake">{text}{fingers}</robot>')
    assert main(["robots", "check", str(tmp_path / "snake.urdf"), *more]) == 1
    said = " ".join(capfd.readouterr().out.split())
    assert "error[TB433] joint t17: 40 joints move one after the other" in said
    assert "snake.urdf:" in said
    assert "robot.yaml" not in said
