"""The rasteriser beside Bullet's own renderer, on every camera of every task."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from taskbuilder import catalogue, load_task
from taskbuilder.world.building import build_world
from taskbuilder.world.pictures import capture

SIZE = (96, 72)
KERNEL = np.ones((3, 3), np.uint8)
ALWAYS = {"handover", "pick_push_place", "collaborative_lift", "lift_triangle"}
SEEN = [
    pytest.param(name, marks=() if name in ALWAYS else pytest.mark.slow, id=name)
    for name in catalogue().tasks
]

CLOSE_M = 0.004
"""How far decimated meshes and polygons in place of circles may be from Bullet's."""


def same_rays(world, view):
    """What Bullet's renderer sees along the rasteriser's rays, half a pixel from its own.

    Along other rays, what is thinner than a pixel (a strip of floor behind a table) is in other
    pixels. In a picture of twice the size, every second ray is that of the middle of a pixel.
    """
    image = capture(world, replace(view, width=2 * view.width, height=2 * view.height))
    return tuple(
        np.ascontiguousarray(array[::2, 1::2]) for array in (image.rgb, image.depth, things(image))
    )


def things(image):
    """The thing that each pixel shows, whichever of its links: the first of them, 0 for nothing."""
    owners = [name.partition(".")[0] for name in image.names]
    return np.array([owners.index(owner) for owner in owners])[image.mask]


def unexplained(one, two):
    """Pixels of a picture whose body is not among the neighbours in the other."""
    found = np.zeros(one.shape, bool)
    for body in np.unique(one):
        near = cv2.dilate((two == body).astype(np.uint8), KERNEL) > 0
        found |= (one == body) & ~near
    return found


@pytest.mark.parametrize("name", SEEN)
def test_it_sees_the_same_bodies_at_the_same_depths(name):
    task = load_task(name)
    worlds = [build_world(task.file, renderer=renderer) for renderer in ("raster", "tiny")]
    try:
        for world in worlds:
            world.reset(7)
            world.move_markers()
        for camera in worlds[0].scene.cameras:
            view = worlds[0].camera(camera, SIZE)
            raster = capture(worlds[0], view)
            rgb, depth, there = same_rays(worlds[1], view)
            here = things(raster)
            assert (here != there).mean() < 0.01, camera
            within = (slice(1, -1), slice(1, -1))  # the border has no neighbours beyond it
            assert unexplained(here, there)[within].mean() < 0.003, camera
            assert unexplained(there, here)[within].mean() < 0.003, camera
            assert (np.abs(raster.depth - depth) > CLOSE_M).mean() < 0.01, camera
            both = (here == there) & (here > 0)
            colors = np.abs(raster.rgb.astype(int) - rgb).max(axis=2)[both]
            assert np.median(colors) <= 12, camera
    finally:
        for world in worlds:
            world.client.close()


def test_a_color_that_changes_is_seen(tmp_path):
    world = build_world(load_task("reach").file, renderer="raster")
    try:
        world.reset(0)
        world.move_markers()
        view = world.camera("front", SIZE)
        before = capture(world, view)
        robot = next(iter(world.robots.values())).body
        robot.set_color((1.0, 0.0, 0.0, 1.0))
        after = capture(world, view)
        changed = (before.rgb != after.rgb).any(axis=2)
        np.testing.assert_array_equal(changed, after.shows(next(iter(world.robots))))
    finally:
        world.client.close()


def test_pictures_repeat_to_the_bit():
    world = build_world(load_task("handover").file, renderer="raster")
    try:
        world.reset(0)
        view = replace(world.camera("front", SIZE), fov_deg=40.0)
        one, two = (
            capture(world, view, shadow=True),
            capture(world, view, shadow=True),
        )
        assert one.rgb.tobytes() == two.rgb.tobytes()
        assert one.depth.tobytes() == two.depth.tobytes()
    finally:
        world.client.close()
