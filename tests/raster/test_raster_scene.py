"""Drawing shapes: where they are seen, how far they are, and in what light."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskbuilder.raster import (
    Drawing,
    Lamp,
    MeshInstance,
    Pattern,
    PinholeCamera,
    Scene,
    box,
    sphere,
)

NOWHERE = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
IN_LINK = np.eye(3, 4)
RED, GREEN = (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0)
EVEN = Lamp((0.0, 0.0, -1.0), (1.0, 1.0, 1.0), 1.0, 0.0)
LAMP = Lamp((0.0, 0.0, -1.0), (1.0, 1.0, 1.0), 0.4, 0.6)
"""The camera's own: it looks along z, and so does the light."""

CAMERA = PinholeCamera(np.eye(3, 4), focal=60.0, width=80, height=60, near=0.05, far=10.0)


def at(x: float, y: float, z: float) -> tuple[float, ...]:
    return (x, y, z, 0.0, 0.0, 0.0, 1.0)


def drawn(shapes: list[MeshInstance], links: list[tuple[float, ...]], lamp: Lamp = EVEN) -> Drawing:
    scene = Scene(shapes)
    scene.place(np.array(links))
    return scene.draw(CAMERA, lamp, backdrop=np.full((60, 3), 255, np.uint8))


def test_a_box_covers_the_pixels_whose_centres_it_covers():
    seen = drawn([MeshInstance(box((0.5, 0.25, 0.1)), 0, IN_LINK, RED)], [at(0, 0, 1.05)])
    # Its near side is 1 m away, 30 by 15 pixels around the middle of the picture.
    expected = np.full((60, 80), -1)
    expected[22:38, 25:55] = 0
    expected[22] = -1  # at 22.5: the centres of row 22 lie on the edge, which belongs to the box
    expected[22, 25:55] = 0
    np.testing.assert_array_equal(seen.shapes[23:37], expected[23:37])
    assert (seen.rgb[seen.shapes == 0] == (255, 0, 0)).all()
    assert (seen.rgb[seen.shapes < 0] == 255).all()
    np.testing.assert_allclose(seen.depth[30, 40], 1.0, atol=1e-6)
    assert (seen.depth[seen.shapes < 0] == 10.0).all()


@given(st.floats(-0.3, 0.3), st.floats(-0.2, 0.2), st.floats(0.4, 5.0), st.floats(0.02, 0.15))
@settings(max_examples=50)
def test_a_ball_is_seen_where_the_rays_meet_it(x, y, z, radius):
    seen = drawn([MeshInstance(sphere(radius), 0, IN_LINK, RED)], [at(x, y, z)])
    rows, columns = np.mgrid[0:60, 0:80]
    rays = np.stack([(columns + 0.5 - 40) / 60, (rows + 0.5 - 30) / 60, np.ones((60, 80))], -1)
    along = rays @ (x, y, z) / (rays**2).sum(-1)
    missed = np.linalg.norm(rays * along[..., None] - (x, y, z), axis=-1)
    assert (seen.shapes[missed < 0.95 * radius] == 0).all()
    assert (seen.shapes[missed > radius] == -1).all()
    inside = missed < 0.5 * radius
    depth = along - np.sqrt(np.maximum(0, radius**2 - missed**2) / (rays**2).sum(-1))
    np.testing.assert_allclose(seen.depth[inside], depth[inside], atol=0.02 * radius)


def test_what_is_nearer_hides_what_is_behind_in_whatever_order_it_is_drawn():
    near = MeshInstance(box((0.2, 0.2, 0.1)), 0, IN_LINK, RED)
    behind = MeshInstance(box((1.0, 1.0, 0.1)), 1, IN_LINK, GREEN)
    links = [at(0, 0, 1), at(0, 0, 2)]
    one, two = drawn([near, behind], links), drawn([behind, near], links)
    np.testing.assert_array_equal(one.rgb, two.rgb)
    assert (one.rgb[30, 40] == (255, 0, 0)).all()
    assert (one.rgb[30, 26] == (0, 255, 0)).all()


def test_neighbouring_faces_leave_no_pixel_between_them():
    turned = (0.01, -0.02, 2.0, *(np.array([0.2, 0.4, 0.1, 0.9]) / math.sqrt(1.02)))
    seen = drawn([MeshInstance(sphere(1.0), 0, IN_LINK, RED)], [turned])
    rows, columns = np.nonzero(seen.shapes == 0)
    for row in np.unique(rows):
        listed = columns[rows == row]
        assert len(listed) == listed.max() - listed.min() + 1


def test_a_wall_that_passes_the_camera_is_cut_at_the_near_plane():
    floor = MeshInstance(box((4.0, 0.1, 8.0)), 0, IN_LINK, RED)
    seen = drawn([floor], [at(0, 0.3, 3.0)])  # from 1 m behind the camera to 7 m in front
    assert (seen.shapes[59] == 0).all()
    rows = np.arange(36, 60)
    np.testing.assert_allclose(seen.depth[36:, 40], 0.25 * 60 / (rows + 0.5 - 30), rtol=1e-4)


def test_light_falls_off_where_a_surface_turns_away():
    seen = drawn([MeshInstance(sphere(0.4), 0, IN_LINK, RED)], [at(0, 0, 1.5)], LAMP)
    middle, edge = int(seen.rgb[30, 40, 0]), int(seen.rgb[30, 40 + 15, 0])
    assert middle >= 253
    assert 102 <= edge < 230


def test_surfaces_that_face_away_from_the_lamp_have_its_ambient_light_alone():
    wall = [MeshInstance(box((3.0, 3.0, 0.1)), 0, IN_LINK, RED)]
    behind = Lamp((0.0, 0.0, 1.0), (1.0, 1.0, 1.0), 0.4, 0.6)
    assert drawn(wall, [at(0, 0, 2)], behind).rgb[30, 40].tolist() == [102, 0, 0]
    aslant = Lamp((1.0, 0.0, 0.5), (1.0, 1.0, 1.0), 0.4, 0.6)
    assert drawn(wall, [at(0, 0, 2)], aslant).rgb[30, 40].tolist() == [102, 0, 0]


def test_translucent_shapes_are_painted_over_the_rest_and_leave_depth_and_segmentation():
    glass = MeshInstance(box((0.2, 0.2, 0.1)), 0, IN_LINK, (0.0, 0.0, 1.0, 0.25))
    wall = MeshInstance(box((3.0, 3.0, 0.1)), 1, IN_LINK, RED)
    seen = drawn([glass, wall], [at(0, 0, 1), at(0, 0, 2)])
    alone = drawn([wall], [NOWHERE, at(0, 0, 2)])
    assert (seen.rgb[30, 40] == (191, 0, 64)).all()
    np.testing.assert_array_equal(seen.depth, alone.depth)
    assert (seen.shapes == 1).all()
    hidden = drawn([glass, wall], [at(0, 0, 3), at(0, 0, 2)])
    np.testing.assert_array_equal(hidden.rgb, alone.rgb)


@pytest.mark.parametrize("shadow", [False, True])
def test_shapes_shade_what_is_behind_them_only_if_asked(shadow):
    shapes = [
        MeshInstance(box((0.3, 0.3, 0.05)), 0, IN_LINK, RED),
        MeshInstance(box((3.0, 3.0, 0.05)), 1, IN_LINK, GREEN, casts_shadow=False),
    ]
    scene = Scene(shapes)
    scene.place(np.array([at(-0.4, 0, 1.5), at(0, 0, 2.0)]))
    lamp = Lamp((-1.0, 0.0, -1.0), (1.0, 1.0, 1.0), 0.4, 0.6)  # from the left, over the camera
    seen = scene.draw(CAMERA, lamp, backdrop=np.full((60, 3), 255, np.uint8), shadow=shadow)
    wall = seen.rgb[seen.shapes == 1][:, 1]
    assert (wall.min() < 0.8 * wall.max()) == shadow
    # The box is 0.45 m in front of the wall, so its shadow falls 0.45 m to the right of it.
    assert (seen.rgb[30, 41, 1] < 0.8 * wall.max()) == shadow


def test_the_same_scene_gives_the_same_picture_to_the_bit():
    def picture() -> Drawing:
        shapes = [MeshInstance(sphere(0.1 + 0.01 * n), n, IN_LINK, RED) for n in range(20)]
        return drawn(shapes, [at(0.03 * n - 0.3, 0.01 * n, 1 + 0.1 * n) for n in range(20)], LAMP)

    one, two = picture(), picture()
    assert one.rgb.tobytes() == two.rgb.tobytes()
    assert one.depth.tobytes() == two.depth.tobytes()


def board(kind: str, distance: float, period: float = 0.1) -> Drawing:
    """A red and green board across the picture."""
    pattern = Pattern(kind, (0.0, 1.0, 0.0), period, 0.3)
    shape = MeshInstance(box((8.0, 8.0, 0.02)), 0, IN_LINK, RED, pattern=pattern)
    return drawn([shape], [at(0, 0, distance)])


@pytest.mark.parametrize("kind", ["checks", "stripes", "grain", "speckles"])
def test_a_pattern_alternates_between_two_colours(kind):
    seen = board(kind, 0.5)
    red, green, blue = np.moveaxis(seen.rgb.astype(int), -1, 0)
    assert (blue == 0).all()
    assert (np.abs(red + green - 255) <= 1).all()
    for channel in (red, green):
        assert channel.max() > 230
        assert 0.15 < channel.mean() / 255 < 0.85
    np.testing.assert_array_equal(seen.rgb, board(kind, 0.5).rgb)


def test_a_pattern_finer_than_pixels_is_seen_as_its_mean():
    fine = board("checks", 5.0, period=0.01).rgb.astype(int)
    assert (np.abs(fine[..., 0] - 128) <= 4).all()
    assert (np.abs(fine[..., 1] - 128) <= 4).all()


def test_a_pattern_moves_with_its_shape():
    period = 0.4
    one = board("stripes", 1.0, period).rgb
    pattern = Pattern("stripes", (0.0, 1.0, 0.0), period, 0.3)
    shape = MeshInstance(box((8.0, 8.0, 0.02)), 0, IN_LINK, RED, pattern=pattern)
    # 10 pixels at 60 pixels of focal length, and 0.99 m from the face of the board.
    moved = drawn([shape], [at(10 * 0.99 / 60, 0, 1.0)]).rgb
    difference = np.abs(moved[:, 10:].astype(int) - one[:, :-10])
    assert np.median(difference) <= 1
    assert np.abs(moved.astype(int) - one).mean() > 20


def test_only_the_shape_with_the_pattern_has_it():
    pattern = Pattern("stripes", (0.0, 0.0, 1.0), 0.1, 0.0)
    behind = MeshInstance(box((8.0, 8.0, 0.02)), 0, IN_LINK, RED)
    before = MeshInstance(box((0.4, 0.4, 0.02)), 1, IN_LINK, GREEN, pattern=pattern)
    seen = drawn([behind, before], [at(0, 0, 2.0), at(0, 0, 1.0)])
    assert (seen.rgb[seen.shapes == 0] == (255, 0, 0)).all()
    assert (seen.rgb[seen.shapes == 1][:, 2] > 200).any()
