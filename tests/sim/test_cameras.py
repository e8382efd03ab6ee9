from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from taskbuilder.cameras import BACKGROUND, STUDIO, CameraView, Image
from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose
from taskbuilder.shapes import BoxShape, Part, SphereShape
from taskbuilder.sim.bodies import create_body
from taskbuilder.sim.client import Client
from taskbuilder.sim.pictures import Segments, capture
from taskbuilder.sim.renderers import probe_egl

ABOVE = CameraView((0.5, -1.0, 0.8), (0.0, 0.0, 0.0), width=80, height=60)
ROLLED = CameraView((0.5, -1.0, 0.8), (0.0, 0.0, 0.0), up=(0.5, 0.2, 1.0), width=80, height=60)
needs_egl = pytest.mark.skipif(not probe_egl().works, reason=f"no EGL: {probe_egl().reason}")


@pytest.fixture(params=["raster", "tiny", pytest.param("egl", marks=needs_egl)])
def drawing_client(request):
    with Client(physics_hz=120, renderer=request.param) as client:
        assert client.renderer == request.param
        yield client


def plane_depth_error(image: Image, view: CameraView) -> float:
    """Largest difference (m) of the depth image from that of the plane z = 0."""
    rows, columns = np.mgrid[: view.height, : view.width]
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    rays = pixels @ np.linalg.inv(image.intrinsics).T
    world_from_camera = np.linalg.inv(view.extrinsics)
    depth = -world_from_camera[2, 3] / (rays @ world_from_camera[2, :3])
    near = (image.depth < view.far) & (depth > 0) & (depth < 1.5)
    assert near.sum() > 1000
    return float(np.abs(image.depth - depth)[near].max())


@pytest.mark.parametrize("supersample", [1, 2, 3])
def test_intrinsics_and_extrinsics_explain_every_pixel(drawing_client, supersample):
    floor = {"floor": Part(BoxShape((4.0, 4.0, 0.2)))}
    create_body(drawing_client, floor, pose=Pose((0.0, 0.0, -0.1)))
    image = capture(drawing_client, ROLLED, supersample=supersample)
    assert plane_depth_error(image, ROLLED) < 1.5e-3
    # Half a pixel off would be an error of a centimetre.


def test_a_known_point_is_where_the_matrices_say(drawing_client):
    view = replace(ROLLED, width=320, height=240)
    point = np.array([0.1, 0.15, 0.05, 1.0])
    ball = create_body(drawing_client, {"b": Part(SphereShape(0.02))}, pose=Pose(tuple(point[:3])))
    image = capture(drawing_client, view, Segments([("ball", ball.id, -1)]))
    u, v, w = image.intrinsics @ (view.extrinsics @ point)[:3]
    rows, columns = np.nonzero(image.shows("ball"))
    assert (columns.mean(), rows.mean()) == pytest.approx((u / w, v / w), abs=0.5)
    assert image.depth[round(v / w), round(u / w)] == pytest.approx(w - 0.02, abs=2e-3)


def test_images_have_the_documented_shapes_and_types(client, table):
    image = capture(client, ABOVE, supersample=2, shadow=True, backdrop=STUDIO)
    assert (image.rgb.shape, image.rgb.dtype) == ((60, 80, 3), np.uint8)
    assert (image.depth.shape, image.depth.dtype) == ((60, 80), np.float32)
    assert (image.mask.shape, image.mask.dtype) == ((60, 80), np.int16)


def test_masks_tell_bodies_and_links_apart(drawing_client):
    parts = {
        "left": Part(BoxShape((0.3, 0.3, 0.3)), Pose((-0.2, 0.0, 0.0))),
        "right": Part(BoxShape((0.3, 0.3, 0.3)), Pose((0.2, 0.0, 0.0))),
    }
    create_body(drawing_client, {"other": Part(SphereShape(0.01))}, pose=Pose((0, 0, 9)))
    pair = create_body(drawing_client, parts)
    names = Segments([(f"pair.{link}", pair.id, index) for link, index in pair.links.items()])
    view = CameraView((0, -2, 0), (0, 0, 0), width=64, height=48)
    image = capture(drawing_client, view, names)
    assert image.names == (BACKGROUND, "pair.left", "pair.right")
    assert [image.names[image.mask[24, x]] for x in (24, 40)] == ["pair.left", "pair.right"]
    assert image.shows("pair.left")[24, 24]
    assert not image.shows("pair.left")[24, 40]
    assert image.shows("pair")[24, [24, 40]].all()
    assert image.mask[0, 0] == 0
    assert image.depth[0, 0] == pytest.approx(10.0, rel=1e-3)


def test_what_has_no_name_is_background(drawing_client):
    """Bodies that were built before and after the named one, and its other links."""
    box, ball = BoxShape((0.3, 0.3, 0.3)), SphereShape(0.1)
    first = create_body(drawing_client, {"first": Part(box, Pose((-0.4, 0, 0)))})
    parts = {"left": Part(box), "right": Part(ball, Pose((0.4, 0, 0)))}
    pair = create_body(drawing_client, parts)
    create_body(drawing_client, {"last": Part(box)}, pose=Pose((0, 0, 0.5)))
    view = CameraView((0, -2, 0), (0, 0, 0), width=64, height=48)
    for named, seen in ((first, (24, 22)), (pair, (24, 32))):
        image = capture(drawing_client, view, Segments([("it", named.id, -1)]))
        assert image.mask[seen] == 1
        assert image.mask.sum() == image.shows("it").sum() < 100
    assert not capture(drawing_client, view).mask.any()


def test_supersampling_changes_neither_depth_nor_masks(client, tray):
    names = Segments([(link, tray.id, index) for link, index in tray.links.items()])
    plain, fine = (capture(client, ABOVE, names, supersample=times) for times in (1, 3))
    assert len(np.unique(plain.mask)) > 3
    assert np.array_equal(plain.intrinsics, fine.intrinsics)
    assert np.mean(plain.mask == fine.mask) > 0.999
    assert np.allclose(plain.depth, fine.depth, atol=1e-3)
    assert not np.array_equal(plain.rgb, fine.rgb)


def test_a_backdrop_is_painted_only_where_nothing_is(client, tray):
    plain, painted = capture(client, ABOVE), capture(client, ABOVE, backdrop=STUDIO)
    nothing = plain.depth == ABOVE.far
    assert np.array_equal(plain.rgb[~nothing], painted.rgb[~nothing])
    assert tuple(painted.rgb[0, 0]) == STUDIO.top
    assert tuple(painted.rgb[-1, -1]) == STUDIO.bottom


def test_colours_come_out_as_given_under_full_light(client):
    red = {"red": Part(BoxShape((2.0, 2.0, 0.1)), color=(0.8, 0.2, 0.1, 1.0))}
    create_body(client, red)
    seen = capture(client, ABOVE).rgb[30, 40] / 255
    assert seen == pytest.approx((0.8, 0.2, 0.1), abs=0.06)


def test_pictures_are_the_same_every_time(drawing_client):
    create_body(drawing_client, {"ball": Part(SphereShape(0.2))})
    first = capture(drawing_client, ABOVE).rgb
    for _ in range(3):
        assert np.array_equal(capture(drawing_client, ABOVE).rgb, first)


def test_a_camera_that_looks_down_sees_x_to_the_right():
    view = CameraView((0, 0, 1), (0, 0, 0), up=(0, 1, 0))
    assert view.pose.axis(0) == pytest.approx((1, 0, 0))
    assert view.pose.axis(1) == pytest.approx((0, -1, 0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"target": (1.0, 1.0, 1.0)}, "own position"),
        ({"target": (1.0, 1.0, 0.0)}, "another up"),
        ({"up": (0.0, 0.0, 0.0)}, "another up"),
        ({"width": 0}, "from 1 to 4096"),
        ({"height": 20_000}, "from 1 to 4096"),
        ({"fov_deg": 180.0}, "fov_deg"),
        ({"near": 2.0, "far": 1.0}, "near < far"),
        ({"eye": (math.nan, 0.0, 0.0)}, "finite"),
    ],
)
def test_views_that_show_nothing_are_refused(change, message):
    with pytest.raises(SimulationError, match=message):
        CameraView(**{"eye": (1.0, 1.0, 1.0), "target": (0.0, 0.0, 0.0)} | change)


def test_supersampling_beyond_the_largest_picture_is_refused(client):
    with pytest.raises(SimulationError, match="supersampling included"):
        capture(client, CameraView((1, 1, 1), (0, 0, 0), width=2000), supersample=3)
    with pytest.raises(SimulationError, match="supersample"):
        capture(client, ABOVE, supersample=0)
