from __future__ import annotations

import numpy as np
import pytest

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import Pose
from taskbuilder.world.pictures import capture

SCENE = """
scene:
  robots:
    arm: {model: ur5e, base: {position: [-3, 0, 0]}}
  objects:
    ball: {shape: {sphere: 0.1}, mass: 1, position: [0.3, 0.2, 0.1], color: red}
  sites:
    lamp: {in: ball, position: [0, 0, 0.4], marker: {sphere: 0.1}, color: blue}
  cameras:
    front: {position: [0, -2, 0.5], look_at: [0, 0, 0.1], fov_deg: 40, size: [160, 120]}
    top: {position: [0, 0, 2], look_at: [0, 0, 0], size: [64, 64]}
    wrist: {mount: arm.tcp, size: [64, 64]}
    rider: {mount: ball, position: [0, 0, 1], look_at: [0, 0, 0]}
"""


def test_a_camera_in_the_world_stands_as_written(build):
    view = build(SCENE).camera("front")
    assert view.eye == (0, -2, 0.5)
    assert view.target == (0, 0, 0.1)
    assert view.up == (0, 0, 1)
    assert (view.fov_deg, view.width, view.height) == (40, 160, 120)
    assert (build(SCENE).camera("front", (32, 16)).width) == 32


def test_a_camera_that_looks_straight_down_has_y_at_the_top(build):
    world = build(SCENE)
    image = capture(world, world.camera("top"))
    rows, columns = np.nonzero(image.shows("ball"))
    assert len(rows) > 10
    assert rows.mean() < 31  # at +y: above the middle
    assert columns.mean() > 33  # at +x: to the right of it


def test_a_mounted_camera_rides_on_its_frame(build):
    world = build(SCENE)
    tool = world.pose("arm.tcp")
    view = world.camera("wrist")
    assert view.eye == pytest.approx(tool.apply((0.09, 0, -0.1)))
    assert view.target == pytest.approx(tool.apply((0, 0, 0.06)))
    assert view.up == pytest.approx(tool.axis(2))
    arm = world.robots["arm"]
    for step in range(1, 6):
        world.step({"arm": [joint + 0.05 * step for joint in arm.home]})
    assert world.camera("wrist").eye == pytest.approx(world.pose("arm.tcp").apply((0.09, 0, -0.1)))
    assert world.camera("wrist").eye != view.eye


def test_a_camera_that_looks_along_its_mounts_axis_still_sees(build):
    world = build(SCENE)
    turned = Pose.from_rpy_deg((0.0, 0.0, 3.0), (0.0, 90.0, 0.0))  # its x axis points down
    world.objects["ball"].body.place(turned)
    world.refresh()
    view = world.camera("rider")
    sight = np.subtract(view.target, view.eye)
    assert np.linalg.norm(np.cross(sight, view.up)) > 0.5


def test_markers_of_riding_sites_are_brought_along_for_pictures(build):
    world = build(SCENE)
    marker = world.sites["lamp"].marker
    world.objects["ball"].body.place(Pose((1.0, 1.0, 0.1)))
    world.refresh()
    world.move_markers()
    assert marker.pose().position == pytest.approx((1.0, 1.0, 0.5))


def test_a_camera_that_is_not_there_is_named(build):
    with pytest.raises(UnknownNameError, match=r'no camera "frnt"; did you mean "front"\?'):
        build(SCENE).camera("frnt")


ZONES = """
scene:
  robots:
    arm: {model: ur5e, base: {position: [-3, 0, 0]}}
  objects:
    wall: {shape: {box: [1, 0.1, 1]}, fixed: true, position: [0, 0.5, 0.5], color: red}
  sites:
    zone: {position: [-0.2, 0, 0.5], marker: {box: [0.2, 0.2, 0.2]}, color: [0, 0, 1]}
    spot: {position: [0.2, 0, 0.5], marker: {sphere: 0.025}, color: [0, 0, 1]}
    thin: {position: [0, 0, 0.7], marker: {sphere: 0.025}, color: [0, 0, 1], opacity: 0.1}
  cameras:
    front: {position: [0, -1, 0.5], look_at: [0, 0, 0.5], fov_deg: 60, size: [121, 121]}
"""


def test_markers_with_volume_are_translucent_and_others_solid(build):
    world = build(ZONES)
    world.move_markers()
    image = capture(world, world.camera("front"))
    focal = 60.5 / np.tan(np.radians(30))

    def seen(x, z, distance=1.0):
        row, column = int(60.5 - focal * (z - 0.5) / distance), int(60.5 + focal * x / distance)
        return image.names[image.mask[row, column]], image.rgb[row, column].astype(int)

    for x, z, opacity in ((-0.2, 0.5, 0.35), (0, 0.7, 0.1)):
        thing, (red, green, blue) = seen(x, z)
        assert thing == "wall"
        assert red > 0.8 * (1 - opacity) * 255 * 0.5
        assert 0.2 * opacity * 255 < blue < opacity * 255 + 40
        assert green < 45
    thing, (red, _, blue) = seen(0.2, 0.5)
    assert thing == "spot"
    assert blue > 100 > red
