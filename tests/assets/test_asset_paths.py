"""References to files: which file they mean, and which are refused."""

from pathlib import Path

import pytest

from taskbuilder.assets import AssetError, codes, read_urdf, resolve
from taskbuilder.assets.paths import packages_named_in, pybullet_data_folder
from taskbuilder.errors import FileError, Location


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A robot's folder inside its root, with a mesh; a secret lies outside the root."""
    folder = tmp_path / "root" / "arm"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "finger.stl").write_bytes(b"x")
    (tmp_path / "root" / "shared").mkdir()
    (tmp_path / "root" / "shared" / "palm.obj").write_bytes(b"x")
    (tmp_path / "secret.obj").write_bytes(b"x")
    return folder


@pytest.mark.parametrize(
    ("reference", "leads_to"),
    [
        ("meshes/finger.stl", "arm/meshes/finger.stl"),
        ("./meshes/../meshes/finger.stl", "arm/meshes/finger.stl"),
        ("../shared/palm.obj", "shared/palm.obj"),
        ("package://meshes/finger.stl", "arm/meshes/finger.stl"),
        ("package://shared/palm.obj", "shared/palm.obj"),
        ("package://arm/meshes/finger.stl", "arm/meshes/finger.stl"),
        ("package://root/arm/meshes/finger.stl", "arm/meshes/finger.stl"),
    ],
)
def test_finds_the_file(folder: Path, reference: str, leads_to: str) -> None:
    root = folder.parent
    assert resolve(reference, folder, [root]) == (root / leads_to).resolve()


ROBOT = """<robot name="arm">
  <link name="arm">
    <inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><mesh filename="{}"/></geometry></collision>
  </link>
</robot>"""
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A URDF of the layout of ROS: in a folder beside that of its meshes."""
    for name in ("urdf", "meshes"):
        (tmp_path / "home" / "arm_description" / name).mkdir(parents=True)
    folder = tmp_path / "home" / "arm_description"
    (folder / "meshes" / "arm.obj").write_text(MESH)
    (tmp_path / "home" / "secret.obj").write_text(MESH)
    return folder


def test_a_urdf_may_name_the_meshes_of_its_ros_package(package: Path) -> None:
    file = package / "urdf" / "arm.urdf"
    file.write_text(ROBOT.format("package://arm_description/meshes/arm.obj"))
    with pytest.raises(FileError, match=r"TB402.* put its package\.xml into it"):
        read_urdf(file, [file.parent])
    assert packages_named_in(file) == (package,)
    assert read_urdf(file, [file.parent, *packages_named_in(file)]).meshes
    (package / "package.xml").write_text("<package/>")
    assert read_urdf(file, [file.parent]).meshes == (package / "meshes" / "arm.obj",)


@pytest.mark.parametrize(
    "reference",
    [
        "package://arm_description/../secret.obj",
        "package://home/secret.obj",
        "../../secret.obj",
        "package://arm_description/meshes/link.obj",
    ],
)
def test_a_package_opens_no_folder_above_it(package: Path, reference: str) -> None:
    (package / "package.xml").write_text("<package/>")
    (package / "meshes" / "link.obj").symlink_to(package.parent / "secret.obj")
    file = package / "urdf" / "arm.urdf"
    file.write_text(ROBOT.format(reference))
    with pytest.raises(FileError, match="TB402"):
        read_urdf(file, [file.parent])


@pytest.mark.parametrize(
    ("reference", "code"),
    [
        ("", codes.MISSING),
        ("meshes/fingr.stl", codes.MISSING),
        ("nowhere/finger.stl", codes.MISSING),
        ("package://nobody/x.obj", codes.MISSING),
        ("package:///x.obj", codes.MISSING),
        ("package://../x.obj", codes.MISSING),
        ("meshes", codes.NOT_READABLE),
        ("a" * 5000, codes.NOT_READABLE),
        ("../../secret.obj", codes.OUTSIDE),
        ("../../not_even_there.obj", codes.OUTSIDE),
        ("package://meshes/../../../secret.obj", codes.OUTSIDE),
        ("/etc/passwd", codes.OUTSIDE),
        ("~/x.obj", codes.OUTSIDE),
        ("file:///etc/passwd", codes.OUTSIDE),
        ("http://example.org/x.obj", codes.OUTSIDE),
        ("C:/x.obj", codes.OUTSIDE),
        ("meshes\\finger.stl", codes.OUTSIDE),
        ("meshes/fin\0ger.stl", codes.OUTSIDE),
    ],
)
def test_refuses(folder: Path, reference: str, code: str) -> None:
    with pytest.raises(AssetError) as caught:
        resolve(reference, folder, [folder.parent])
    assert caught.value.code == code
    assert ";" in caught.value.message or "cannot be read" in caught.value.message


@pytest.mark.parametrize("reference", ["meshes/fingr.stl", "meshes/FINGER.STL"])
def test_suggests_the_closest_name(folder: Path, reference: str) -> None:
    with pytest.raises(AssetError, match=r'did you mean "finger\.stl"'):
        resolve(reference, folder, [folder.parent])


def test_suggests_no_material_file_for_a_mesh(folder: Path) -> None:
    (folder / "meshes" / "pear.mtl").write_text("")
    with pytest.raises(AssetError, match="put it in the folder"):
        resolve("meshes/pear.obj", folder, [folder.parent])


def test_a_symbolic_link_does_not_lead_out(folder: Path, tmp_path: Path) -> None:
    (folder / "inside.stl").symlink_to(folder / "meshes" / "finger.stl")
    (folder / "outside.obj").symlink_to(tmp_path / "secret.obj")
    (folder / "loop.obj").symlink_to(folder / "loop.obj")
    assert resolve("inside.stl", folder, [folder]).name == "finger.stl"
    for name in ("outside.obj", "loop.obj"):
        with pytest.raises(AssetError):
            resolve(name, folder, [folder])


def test_a_huge_file_is_refused_unread(folder: Path) -> None:
    with (folder / "huge.obj").open("wb") as file:
        file.truncate(65 * 2**20)
    with pytest.raises(AssetError, match="at most 64 MB") as caught:
        resolve("huge.obj", folder, [folder])
    assert caught.value.code == codes.NOT_READABLE


def test_pybullet_data_is_always_allowed(folder: Path) -> None:
    data = pybullet_data_folder()
    assert data is not None
    assert resolve("package://pybullet_data/cube.obj", folder, [folder]) == data / "cube.obj"
    assert resolve("meshes/visual/hand.obj", data / "franka_panda", []).is_file()


def test_an_error_becomes_a_finding_where_the_caller_says(folder: Path) -> None:
    place = Location(folder / "arm.urdf", 3, 7)
    finding = AssetError(codes.MISSING, "there is no such file").finding("link a", place)
    assert (finding.code, finding.path, finding.location) == (codes.MISSING, "link a", place)
    assert finding.severity == "error"


def test_every_code_is_explained() -> None:
    used = {value for name, value in vars(codes).items() if name.isupper() and name != "CODES"}
    assert used == set(codes.CODES)
    for title, explanation in codes.CODES.values():
        assert title
        assert explanation.endswith(".")
