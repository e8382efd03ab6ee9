"""Objects as others ship them."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from made_robots import ascii_stl, box_mesh, open_box

from taskbuilder.assets.mesh import read_mesh
from taskbuilder.assets.urdf import read_urdf
from taskbuilder.errors import FileError, UsageError
from taskbuilder.importing.folders import ImportSource, import_object
from taskbuilder.importing.mesh_options import MeshOptions
from taskbuilder.importing.surfaces import welded_mesh
from taskbuilder.importing.writing import write_folder


def imported_urdf(source, folder):
    imported = import_object(source)
    write_folder(folder / imported.name, imported.files, overwrite=True)
    file = folder / imported.name / f"{imported.name}.urdf"
    return imported, read_urdf(file, (file.parent,))


def test_a_hollow_thing_stays_hollow(tmp_path):
    pytest.importorskip("coacd")
    file = tmp_path / "crate.stl"
    file.write_bytes(open_box().export(file_type="stl"))
    imported, urdf = imported_urdf(ImportSource(file), tmp_path / "out")
    (row,) = [row for row in imported.changes.rows if row.what == "collision"]
    assert row.after.endswith("convex pieces")
    text = urdf.link("body").collisions[0].mesh.read_text()
    assert text.count("o part_") >= 5
    hull = import_object(ImportSource(file, meshes=MeshOptions(collision="hull")))
    assert [row.after for row in hull.changes.rows if row.what == "collision"] == ["hull"]


def test_a_glb_is_turned_upright_and_its_texture_kept(tmp_path):
    import trimesh
    from PIL import Image

    mesh = box_mesh((0.02, 0.1, 0.04))
    uv = np.random.default_rng(0).random((len(mesh.vertices), 2))
    picture = Image.new("RGB", (8, 8), (200, 30, 40))
    mesh.visual = trimesh.visual.TextureVisuals(uv=uv, image=picture)
    file = tmp_path / "tower.glb"
    file.write_bytes(mesh.export(file_type="glb"))
    imported, urdf = imported_urdf(ImportSource(file), tmp_path / "out")
    points = np.asarray(read_mesh(urdf.link("body").visuals[0].mesh).points).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    np.testing.assert_allclose(high - low, (0.02, 0.04, 0.1), atol=1e-6)
    assert any(name.endswith(".png") for name in imported.files)
    assert [row.before for row in imported.changes.rows if row.what == "up axis"] == ["Y up"]


def test_mass_and_density(tmp_path):
    file = tmp_path / "brick.stl"
    file.write_bytes(ascii_stl(box_mesh((0.1, 0.1, 0.1))))
    _, urdf = imported_urdf(ImportSource(file, mass=0.3), tmp_path / "a")
    assert urdf.link("body").mass == pytest.approx(0.3)
    _, urdf = imported_urdf(ImportSource(file, density=2000.0), tmp_path / "b")
    assert urdf.link("body").mass == pytest.approx(2.0, rel=1e-4)


def test_a_mesh_that_faces_inwards_is_turned(tmp_path):
    mesh = box_mesh((0.1, 0.1, 0.1))
    mesh.invert()
    file = tmp_path / "inside_out.stl"
    file.write_bytes(mesh.export(file_type="stl"))
    imported, _ = imported_urdf(ImportSource(file), tmp_path / "out")
    assert [row.before for row in imported.changes.rows if row.what == "triangles"] == [
        "face inwards"
    ]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("empty.stl", b"solid x\nendsolid x\n", "TB404"),
        ("empty.obj", b"v 0 0 0\n", "TB404"),
        ("broken.glb", b"glTF nonsense", "TB404"),
        ("part.step", b"ISO-10303-21;", "STEP files are not read"),
        ("lfs.stl", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        ("bomb.dae", b'<!DOCTYPE x [<!ENTITY a "b">]><COLLADA/>', "document type"),
    ],
)
def test_meshes_that_cannot_be_used_are_findings(name, content, said, tmp_path):
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(FileError, match=said):
        import_object(ImportSource(file))


@pytest.mark.parametrize(
    ("extension", "said"),
    [("KHR_draco_mesh_compression", "Draco"), ("EXT_meshopt_compression", "meshopt")],
)
def test_a_compressed_mesh_is_said_to_be_compressed(extension, said, tmp_path):
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, "extensions": {extension: {}}}
    counts = [{"componentType": 5126, "count": 3, "type": "VEC3"}]
    counts += [{"componentType": 5123, "count": 3, "type": "SCALAR"}]
    text = json.dumps(
        {
            "asset": {"version": "2.0"},
            "extensionsUsed": [extension],
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [primitive]}],
            "accessors": counts,
        }
    ).encode()
    text += b" " * (-len(text) % 4)
    chunk = len(text).to_bytes(4, "little") + b"JSON" + text
    file = tmp_path / "packed.glb"
    header = b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunk)).to_bytes(4, "little")
    file.write_bytes(header + chunk)
    with pytest.raises(FileError, match=rf"compressed \({said}\)"):
        import_object(ImportSource(file))


def test_a_mesh_is_made_larger_as_asked_and_a_description_is_not(tmp_path):
    file = tmp_path / "thing.stl"
    file.write_bytes(ascii_stl(box_mesh((0.02, 0.04, 0.06))))
    larger = ImportSource(file, meshes=MeshOptions(scale=2.5))
    imported, urdf = imported_urdf(larger, tmp_path / "out")
    assert urdf.link("body").collisions[0].size == pytest.approx((0.05, 0.1, 0.15), abs=1e-5)
    (row,) = (row for row in imported.changes.rows if row.what == "scale")
    assert (row.before, row.after) == ("1", "2.5")
    description = tmp_path / "thing.urdf"
    description.write_text('<robot name="thing"><link name="body"/></robot>')
    with pytest.raises(UsageError, match="scale under shape in the task file"):
        import_object(replace(larger, file=description))


def test_units_that_cannot_be_guessed(tmp_path):
    file = tmp_path / "thing.stl"
    file.write_bytes(ascii_stl(box_mesh((7, 7, 7))))
    with pytest.raises(FileError, match=r"TB432.*--unit"):
        import_object(ImportSource(file))
    _, urdf = imported_urdf(ImportSource(file, meshes=MeshOptions(unit=0.01)), tmp_path / "out")
    assert urdf.link("body").collisions[0].size == pytest.approx((0.07, 0.07, 0.07), abs=1e-5)


def test_parts_that_reach_into_each_other_are_cut_one_by_one(monkeypatch):
    from taskbuilder.importing import fitting

    asked = []

    def cut(points, faces):
        asked.append(len(faces))
        return [points[points[:, 2] <= 0.05], points[points[:, 2] >= 0.0]]

    monkeypatch.setattr(fitting, "decomposed", cut)
    handle, ring = box_mesh((0.02, 0.01, 0.06), (0.055, 0, 0.05)), trimesh_torus()
    both = np.vstack([ring.vertices, handle.vertices])
    faces = np.vstack([ring.faces, handle.faces + len(ring.vertices)])
    pieces = fitting.convex_pieces(*welded_mesh(both, faces))
    assert asked == [len(ring.faces)]
    assert len(pieces) == 3


def test_what_cannot_be_cut_is_said(monkeypatch):
    from taskbuilder.importing import fitting

    monkeypatch.setattr(fitting, "decomposed", lambda points, faces: [])
    ring = trimesh_torus()
    found = fitting.fit(*welded_mesh(ring.vertices, ring.faces))
    assert "could not be cut" in found.words


def trimesh_torus():
    import trimesh

    return trimesh.creation.torus(0.05, 0.01, major_sections=24, minor_sections=8)


LONE = """<robot name="{name}"><link name="body"><collision><geometry>
<box size="0.05 0.05 0.05"/></geometry></collision></link></robot>"""


@pytest.mark.parametrize(
    ("path", "said", "proposed"),
    [
        ("YcbPear/model.urdf", "model.urdf", "YcbPear"),
        ("pear/urdf/model.urdf", "robot", "pear"),
        ("pear/fruit.urdf", "model", "fruit"),
        ("things/model.urdf", "pear.urdf", "pear"),
        ("things/model.urdf", "pear", "pear"),
    ],
)
def test_a_name_that_many_files_have_is_not_proposed(path, said, proposed, tmp_path):
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    file.write_text(LONE.format(name=said))
    assert import_object(ImportSource(file)).name == proposed


def test_a_mesh_that_is_only_called_mesh_is_named_by_its_folder(tmp_path):
    file = tmp_path / "cracker_box" / "meshes" / "textured.stl"
    file.parent.mkdir(parents=True)
    file.write_bytes(ascii_stl(box_mesh((0.1, 0.1, 0.1))))
    assert import_object(ImportSource(file)).name == "cracker_box"


def test_a_second_object_of_a_name_is_told_how_to_get_another(tmp_path):
    file = tmp_path / "pear.urdf"
    file.write_text(LONE.format(name="pear"))
    imported = import_object(ImportSource(file))
    write_folder(tmp_path / "objects" / "pear", imported.files, overwrite=False)
    with pytest.raises(UsageError, match=r"another name with --name, or replace that one"):
        write_folder(tmp_path / "objects" / "pear", imported.files, overwrite=False)
