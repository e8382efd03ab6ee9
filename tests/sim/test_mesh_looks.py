"""Meshes are drawn in the colours of their materials, and mirrored ones as mirror images."""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np
import pytest

from taskbuilder.assets import read_urdf, resolved_text
from taskbuilder.assets.looks import with_looks
from taskbuilder.cameras import CameraView, Light
from taskbuilder.geometry import Pose
from taskbuilder.shapes import MeshShape, Part
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.client import Client
from taskbuilder.sim.pictures import capture
from taskbuilder.sim.redrawn import redrawn
from taskbuilder.sim.renderers import probe_egl

needs_egl = pytest.mark.skipif(not probe_egl().works, reason=f"no EGL: {probe_egl().reason}")
LAMP = Light(direction=(0.3, -1.0, 0.6), ambient=0.5, diffuse=0.5, specular=0.0)
VIEW = CameraView((0.0, -1.0, 0.5), (0.0, 0.0, 0.0), fov_deg=30.0, width=160, height=120)
CENTERS = (-0.15, 0.0, 0.15)
WHITE = (1.0, 1.0, 1.0, 1.0)
SIDES = ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4))
MATERIALS = """
newmtl first paint
Kd 1 0 0
newmtl second
Kd 0 1 0
newmtl third
Kd 0 0 1
"""


@pytest.fixture(params=["raster", "tiny", pytest.param("egl", marks=needs_egl)])
def client(request):
    with Client(physics_hz=120, renderer=request.param) as made:
        yield made


def cubes(uses=("first paint", "second", "third"), library="cubes.mtl") -> str:
    """An OBJ file of three cubes along x, each with a material."""
    lines = [f"mtllib {library}"]
    for number, (x, material) in enumerate(zip(CENTERS, uses, strict=True)):
        for dx, y, z in product((-0.05, 0.05), repeat=3):
            lines.append(f"v {x + dx} {y} {z}")
        lines += [f"vt {0.25 + 0.5 * (number % 2)} 0.5"]
        lines.append(f"usemtl {material}")
        for side in SIDES:
            lines.append("f " + " ".join(f"{8 * number + n}/{number + 1}" for n in side))
    return "\n".join(lines) + "\n"


def urdf(mesh: str, scale: str = "1 1 1", material: str = "") -> str:
    geometry = f'<geometry><mesh filename="{mesh}" scale="{scale}"/></geometry>'
    return (
        '<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="1e-2" ixy="0" '
        'ixz="0" iyy="1e-2" iyz="0" izz="1e-2"/></inertial>'
        f"<visual>{geometry}{material}</visual>"
        '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link></robot>'
    )


def load(client, folder, text, name="thing"):
    """Load a URDF as `world.loading` does."""
    file = folder / f"{name}.urdf"
    file.write_text(text)
    read = read_urdf(file, [folder])
    if client.renderer != "raster":
        parts = folder / f"parts-{name}"
        parts.mkdir()
        read = with_looks(read, lambda look: redrawn(look, parts), painted=True)
    copy = folder / f"{name}-copy.urdf"
    copy.write_text(resolved_text(read))
    return load_urdf(client, copy, fixed_base=True)


def fronts(client) -> list[np.ndarray]:
    """The colour of the front of each of the three cubes."""
    image = capture(client, VIEW, light=LAMP)
    found = []
    for x in CENTERS:
        in_camera = (VIEW.extrinsics @ np.array([x, -0.05, 0.0, 1.0]))[:3]
        u, v, w = image.intrinsics @ in_camera
        found.append(image.rgb[round(v / w), round(u / w)])
    return found


def hues(client) -> list[tuple[bool, ...]]:
    """For each of the three cubes, which of red, green and blue its front has."""
    return [tuple((pixel > 60).tolist()) for pixel in fronts(client)]


RED, GREEN, BLUE = (True, False, False), (False, True, False), (False, False, True)


def test_the_colours_of_materials_are_seen_on_a_mesh(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes())
    (tmp_path / "cubes.mtl").write_text(MATERIALS)
    create_body(client, {"mesh": Part(MeshShape(tmp_path / "cubes.obj"), Pose(), WHITE)})
    assert hues(client) == [RED, GREEN, BLUE]


def test_the_colours_of_materials_are_seen_in_a_urdf(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes())
    (tmp_path / "cubes.mtl").write_text(MATERIALS)
    load(client, tmp_path, urdf("cubes.obj"))
    assert hues(client) == [RED, GREEN, BLUE]


def test_a_colour_in_the_urdf_is_that_of_the_whole_mesh(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes())
    (tmp_path / "cubes.mtl").write_text(MATERIALS)
    paint = '<material name="paint"><color rgba="0 0 0.9 1"/></material>'
    load(client, tmp_path, urdf("cubes.obj", material=paint))
    assert hues(client) == [BLUE] * 3


def test_a_colour_set_later_is_that_of_the_whole_mesh(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes())
    (tmp_path / "cubes.mtl").write_text(MATERIALS)
    body = load(client, tmp_path, urdf("cubes.obj"))
    body.set_color((0.0, 0.9, 0.0, 1.0))
    assert hues(client) == [GREEN] * 3


def test_each_material_has_its_own_texture(tmp_path):
    """In the rasteriser; Bullet's renderers draw one texture per mesh."""
    (tmp_path / "cubes.obj").write_text(cubes())
    picture = np.zeros((4, 8, 3), np.uint8)  # blue, green, red, as OpenCV has it
    picture[:, :4], picture[:, 4:] = (0, 255, 0), (255, 0, 0)
    cv2.imwrite(str(tmp_path / "one.png"), picture)
    cv2.imwrite(str(tmp_path / "two.png"), picture[:, :, ::-1])
    (tmp_path / "cubes.mtl").write_text(
        "newmtl first paint\nmap_Kd one.png\nnewmtl second\nKd 1 0 0\nmap_Kd one.png\n"
        "newmtl third\nmap_Kd two.png\n"
    )
    with Client(physics_hz=120, renderer="raster") as client:
        create_body(client, {"mesh": Part(MeshShape(tmp_path / "cubes.obj"), Pose(), WHITE)})
        # The first and third cubes have texture points in the left half, the second in the right.
        assert hues(client) == [GREEN, BLUE, GREEN]


def test_a_painted_texture_keeps_its_pattern_and_not_its_hue(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes())
    picture = np.zeros((4, 8, 3), np.uint8)
    picture[:, :4], picture[:, 4:] = (0, 250, 0), (0, 120, 0)
    cv2.imwrite(str(tmp_path / "leaves.png"), picture)
    names = ("first paint", "second", "third")
    (tmp_path / "cubes.mtl").write_text("\n".join(f"newmtl {n}\nmap_Kd leaves.png" for n in names))
    paint = '<material name="paint"><color rgba="0.9 0 0 1"/></material>'
    load(client, tmp_path, urdf("cubes.obj", material=paint))
    assert hues(client) == [RED] * 3
    light, dark, _ = (int(pixel[0]) for pixel in fronts(client))
    assert light > 1.5 * dark


def test_a_mesh_without_its_material_file_is_white(client, tmp_path):
    (tmp_path / "cubes.obj").write_text(cubes(library="gone.mtl"))
    create_body(client, {"mesh": Part(MeshShape(tmp_path / "cubes.obj"), Pose(), WHITE)})
    assert hues(client) == [(True, True, True)] * 3


WEDGE = ((0, 0, 0), (0.3, 0, 0), (0, 0.1, 0), (0, 0, 0.2))
WEDGE_FACES = ((1, 3, 2), (1, 2, 4), (2, 3, 4), (1, 4, 3))


def wedge(signs=(1, 1, 1), faces=WEDGE_FACES) -> str:
    """A corner of a box as an OBJ file, mirrored without a scale."""
    flipped = np.prod(signs) < 0
    lines = ["v " + " ".join(str(s * c) for s, c in zip(signs, p, strict=True)) for p in WEDGE]
    lines += ["f " + " ".join(map(str, face[::-1] if flipped else face)) for face in faces]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("faces", [WEDGE_FACES, WEDGE_FACES[1:]], ids=["closed", "open"])
@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, -1, -1)], ids=str)
def test_a_mesh_with_a_negative_scale_is_a_mirror_image(client, tmp_path, signs, faces):
    (tmp_path / "plain.obj").write_text(wedge(faces=faces))
    (tmp_path / "mirrored.obj").write_text(wedge(signs, faces))
    paint = '<material name="paint"><color rgba="0.9 0.6 0.2 1"/></material>'
    pictures = []
    for name, scale in (("plain", " ".join(map(str, signs))), ("mirrored", "1 1 1")):
        with Client(physics_hz=120, renderer=client.renderer) as other:
            load(other, tmp_path, urdf(f"{name}.obj", scale, paint), name)
            views = (VIEW, CameraView((0.3, 0.9, -0.5), (0, 0, 0), width=80, height=60))
            images = [capture(other, view, light=LAMP) for view in views]
            pictures.append([(image.rgb.astype(int), image.depth) for image in images])
    for (rgb, depth), (true_rgb, true_depth) in zip(*pictures, strict=True):
        assert (depth < 5.0).sum() > 40
        assert (np.abs(rgb - true_rgb).max(axis=2) > 6).mean() < 0.002
        assert (np.abs(depth - true_depth) > 2e-3).mean() < 0.002


def test_averted_sides_of_a_mirrored_mesh_are_dark(client, tmp_path):
    (tmp_path / "cube.obj").write_text(cubes(library="gone.mtl"))
    load(client, tmp_path, urdf("cube.obj", "-1 1 1"))
    lamp = Light(direction=(0.0, -1.0, 0.0), ambient=0.3, diffuse=0.6, specular=0.0)
    front, back = (
        capture(client, CameraView((0.0, y, 0.0), (0.0, 0.0, 0.0)), light=lamp).rgb[240, 320]
        for y in (-1.0, 1.0)
    )
    assert front.min() > back.max() + 60


def test_a_urdf_that_is_scaled_keeps_its_density(tmp_path):
    file = tmp_path / "thing.urdf"
    file.write_text(urdf("cube.obj").replace("<visual>", "<!-- ").replace("</visual>", " -->"))
    with Client(physics_hz=120) as client:
        plain, larger = (load_urdf(client, file, fixed_base=False, scale=s) for s in (1.0, 2.0))
        assert larger.mass == pytest.approx(8.0 * plain.mass)
        moments = [client.bullet.getDynamicsInfo(body.id, -1)[2] for body in (plain, larger)]
        assert moments[1] == pytest.approx(np.multiply(moments[0], 32.0))
        still = load_urdf(client, file, fixed_base=True, scale=2.0)
        assert still.mass == 0.0
