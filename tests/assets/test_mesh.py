"""Meshes: what is read from good ones, and that broken ones are refused."""

import os
import struct
import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taskbuilder.assets import AssetError, codes, read_mesh
from taskbuilder.assets.mesh import size_warning

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def stl(*triangles: tuple[float, ...], count: int | None = None) -> bytes:
    """A binary STL of triangles of nine coordinates."""
    rows = [struct.pack("<12f2x", 0, 0, 1, *triangle) for triangle in triangles]
    number = len(triangles) if count is None else count
    return b"\0" * 80 + struct.pack("<I", number) + b"".join(rows)


TRIANGLE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0)


def written(tmp_path: Path, name: str, content: str | bytes) -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_reads_an_obj(tmp_path: Path) -> None:
    mesh = read_mesh(written(tmp_path, "a.obj", TETRAHEDRON))
    assert mesh.points.tolist() == [0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3]
    assert mesh.corners.tolist() == [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    assert mesh.triangles == 4
    assert mesh.bounds.low == (0, 0, 0)
    assert mesh.bounds.high == (1, 2, 3)


@pytest.mark.parametrize("faces", ["f -4 -3 -2 -1", "f 1/1 2/1 3/1 4/1", "f 1//1 2//1 3//-1 4//1"])
def test_reads_negative_indices_polygons_and_all_corners(tmp_path: Path, faces: str) -> None:
    text = TETRAHEDRON.split("f")[0] + "vt 0 0\nvn 0 0 1\n" + faces + "\n"
    assert read_mesh(written(tmp_path, "a.obj", text)).corners.tolist() == [0, 1, 2, 0, 2, 3]


def test_reads_a_binary_stl_even_one_that_begins_with_solid(tmp_path: Path) -> None:
    content = bytearray(stl(TRIANGLE, TRIANGLE))
    content[:5] = b"solid"
    mesh = read_mesh(written(tmp_path, "a.STL", bytes(content)))
    assert mesh.points.tolist() == [*TRIANGLE, *TRIANGLE]
    assert mesh.corners.tolist() == [0, 1, 2, 3, 4, 5]
    assert mesh.bounds.high == (1, 2, 0)


BROKEN_OBJ = {
    "empty": "",
    "no faces": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "index too large": TETRAHEDRON + "f 1 2 5\n",
    "index far too large": TETRAHEDRON + "f 1 2 99999999999999\n",
    "index zero": TETRAHEDRON + "f 0 1 2\n",
    "index too negative": TETRAHEDRON + "f -1 -2 -5\n",
    "vertex below its face": "v 0 0 0\nv 1 0 0\nf 1 2 3\nv 0 1 0\n",
    "texture index": TETRAHEDRON + "f 1/1 2/1 3/1\n",
    "normal index": TETRAHEDRON + "f 1//1 2//1 3//1\n",
    "trailing slash": TETRAHEDRON + "f 1/ 2/ 3/\n",
    "fraction": TETRAHEDRON + "f 1.5 2 3\n",
    "two corners": TETRAHEDRON + "f 1 2\n",
    "comma": TETRAHEDRON + "v 1,5 0 0\n",
    "underscore": TETRAHEDRON + "v 1_5 0 0\n",
    "two numbers": TETRAHEDRON + "v 1 0\n",
    "nan": TETRAHEDRON + "v nan 0 0\n",
    "infinite": TETRAHEDRON + "v 0 inf 0\n",
    "huge": TETRAHEDRON + "v 0 1e30 0\n",
    "overflow": TETRAHEDRON + "v 0 1e308 0\nv 0 1e308 0\n",
    "on a line": "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
    "long line": TETRAHEDRON + "#" + "x" * 5000 + "\n",
    "binary": b"\xff\xfe\0\0" + TETRAHEDRON.encode(),
    "utf-16": TETRAHEDRON.encode("utf-16"),
}


@pytest.mark.parametrize("content", BROKEN_OBJ.values(), ids=BROKEN_OBJ)
def test_refuses_a_broken_obj(tmp_path: Path, content: str | bytes) -> None:
    with pytest.raises(AssetError) as caught:
        read_mesh(written(tmp_path, "a.obj", content))
    assert caught.value.code == codes.BAD_MESH


def test_names_the_line(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"a\.obj:9: a face refers to item 5 of 4; indices run"):
        read_mesh(written(tmp_path, "a.obj", TETRAHEDRON + "f 1 2 5\n"))


BROKEN_STL = {
    "no bytes": (b"", codes.BAD_MESH),
    "no triangles": (stl(), codes.BAD_MESH),
    "truncated": (stl(TRIANGLE)[:-1], codes.BAD_MESH),
    "more than it says": (stl(TRIANGLE, count=0), codes.BAD_MESH),
    "fewer than it says": (stl(TRIANGLE, count=4_000_000_000), codes.BAD_MESH),
    "nan": (stl((float("nan"), *TRIANGLE[1:])), codes.BAD_MESH),
    "infinite": (stl((float("-inf"), *TRIANGLE[1:])), codes.BAD_MESH),
    "a point": (stl((0.0,) * 9), codes.BAD_MESH),
    "ascii": (b"solid a\nfacet normal 0 0 1\nendsolid a\n", codes.MESH_FORMAT),
}


@pytest.mark.parametrize(("content", "code"), BROKEN_STL.values(), ids=BROKEN_STL)
def test_refuses_a_broken_stl(tmp_path: Path, content: bytes, code: str) -> None:
    with pytest.raises(AssetError) as caught:
        read_mesh(written(tmp_path, "a.stl", content))
    assert caught.value.code == code


@pytest.mark.parametrize("name", ["a.dae", "a.glb", "a", "a.urdf"])
def test_refuses_other_formats_and_says_which_to_use(tmp_path: Path, name: str) -> None:
    with pytest.raises(AssetError, match=r"convert it to \.obj") as caught:
        read_mesh(written(tmp_path, name, "<COLLADA/>"))
    assert caught.value.code == codes.MESH_FORMAT


def test_refuses_a_folder_and_a_missing_file(tmp_path: Path) -> None:
    (tmp_path / "folder.obj").mkdir()
    for name in ("folder.obj", "missing.obj"):
        with pytest.raises(AssetError):
            read_mesh(tmp_path / name)


def test_a_material_file_may_be_missing_but_not_elsewhere(tmp_path: Path) -> None:
    read_mesh(written(tmp_path, "a.obj", "mtllib a.mtl\n" + TETRAHEDRON))
    with pytest.raises(AssetError) as caught:
        read_mesh(written(tmp_path, "b.obj", "mtllib /etc/passwd\n" + TETRAHEDRON))
    assert caught.value.code == codes.OUTSIDE


def test_a_texture_elsewhere_is_a_warning(tmp_path: Path) -> None:
    written(tmp_path, "a.mtl", "newmtl a\nmap_Kd D:\\me\\wood.png\n")
    mesh = read_mesh(written(tmp_path, "a.obj", "mtllib a.mtl\n" + TETRAHEDRON))
    assert "wood.png" in mesh.warnings[0]


def test_millimetres_are_noticed(tmp_path: Path) -> None:
    mesh = read_mesh(written(tmp_path, "a.obj", TETRAHEDRON.replace("3\n", "3000\n", 1)))
    assert "millimetres" in size_warning(mesh)
    assert not size_warning(mesh, (0.001, 0.001, 0.001))


def test_a_large_mesh_is_read_in_seconds(tmp_path: Path) -> None:
    strip = "".join(f"v {i} {i % 2} 0\n" for i in range(100_002))
    faces = "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 100_001))
    path = written(tmp_path, "a.obj", strip + faces)
    start = time.process_time()
    assert read_mesh(path).triangles == 100_000
    assert time.process_time() - start < 5


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_any_content_is_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    suffix = data.draw(st.sampled_from([".obj", ".stl"]))
    good = TETRAHEDRON.encode() if suffix == ".obj" else stl(TRIANGLE, TRIANGLE)
    start = data.draw(st.integers(0, len(good)))
    end = data.draw(st.integers(start, len(good)))
    insert = data.draw(
        st.binary(max_size=8)
        | st.sampled_from([b"-", b"1e999", b"nan", b"/", b"\nf 1 2", b"\nmtllib ..\n", b"\r", b"_"])
    )
    try:
        mesh = read_mesh(written(tmp_path, "a" + suffix, good[:start] + insert + good[end:]))
    except AssetError:
        return
    assert mesh.triangles > 0


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    path = written(tmp_path, "a.obj", TETRAHEDRON)
    assert read_mesh(path) is read_mesh(path)
    written(tmp_path, "a.obj", TETRAHEDRON.replace("3", "4", 1))
    os.utime(path, ns=(1, 1))
    assert read_mesh(path).bounds.high == (1, 2, 4)


def test_warnings_follow_the_material_file(tmp_path: Path) -> None:
    material = written(tmp_path, "a.mtl", "newmtl a\nmap_Kd D:\\me\\wood.png\n")
    path = written(tmp_path, "a.obj", "mtllib a.mtl\n" + TETRAHEDRON)
    assert read_mesh(path).warnings
    material.write_text("newmtl a\n")
    assert not read_mesh(path).warnings


def test_corners_know_their_texture_points(tmp_path: Path) -> None:
    text = TETRAHEDRON.split("f")[0] + "vt 0 0.5\nvt 1 0.5\nf 1/1 2/-1 3\nf 1/2 3/2 4/1\n"
    mesh = read_mesh(written(tmp_path, "a.obj", text))
    assert mesh.texture_points.tolist() == [0, 0, 0, 0.5, 1, 0.5]
    assert mesh.texture_corners.tolist() == [1, 2, 0, 2, 2, 1]


FORMS = st.sampled_from(["{0}", "{0}/{1}", "{0}//{2}", "{0}/{1}/{2}"])


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(form=FORMS, size=st.integers(3, 5), data=st.data())
def test_lines_that_are_alike_are_read_as_each_alone(
    tmp_path: Path, form: str, size: int, data: st.DataObject
) -> None:
    """A comment between two lines keeps them from being read together."""
    index = st.tuples(st.integers(1, 4), st.integers(1, 2), st.integers(1, 1))
    faces = data.draw(st.lists(st.lists(index, min_size=size, max_size=size), min_size=1))
    lines = [
        *TETRAHEDRON.splitlines()[:4],
        *("vt 0 0", "vt 1 1", "vn 0 0 1"),
        *("f " + " ".join(form.format(*corner) for corner in face) for face in faces),
    ]
    together = read_mesh(written(tmp_path, "a.obj", "\n".join(lines)))
    apart = read_mesh(written(tmp_path, "b.obj", "\n#\n".join(lines)))
    assert together.points == apart.points
    assert together.corners == apart.corners
    assert together.texture_corners == apart.texture_corners
