"""A randomised camera is shifted and turned as far as the page on environments says, no further."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskbuilder import load_task
from taskbuilder.geometry import Pose, add, dot, from_rpy, scale, subtract
from taskbuilder.schema.camera import CameraSpec
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.world.cameras import camera_view
from taskbuilder.world.looks import AS_WRITTEN, MOST_TURN_DEG, SHIFT_M, draw_look

TASK = load_task("handover").file.spec
AT_ORIGIN = Pose()
ANGLES = st.floats(-math.pi, math.pi)


def views(camera: CameraSpec, seed: int, mount: Pose = AT_ORIGIN):
    """The view of a camera as written, and in an episode with random looks."""
    scene = TASK.scene.model_copy(update={"cameras": {"one": camera}})
    look = draw_look(TASK, scene, np.random.default_rng(seed), ("cameras",))
    return tuple(
        camera_view(scene.cameras, "one", lambda _: mount, each) for each in (AS_WRITTEN, look)
    )


def turn_deg(one, other) -> float:
    """The angle of the rotation between two views."""
    turn = one.extrinsics[:3, :3] @ other.extrinsics[:3, :3].T
    # From both parts of the rotation: the arccosine alone is blind to a hundred-thousandth degree.
    sine = np.linalg.norm((turn - turn.T)[[2, 0, 1], [1, 2, 0]]) / 2.0
    return math.degrees(math.atan2(sine, (np.trace(turn) - 1.0) / 2.0))


def sight_turn_deg(one, other) -> float:
    """The angle between the lines of sight of two views."""
    a, b = one.pose.axis(2), other.pose.axis(2)
    return math.degrees(math.atan2(np.linalg.norm(np.cross(a, b)), dot(a, b)))


@st.composite
def directions(draw):
    """Unit vectors; half of them nearly straight down or up, by an angle of 0 to 0.1."""
    azimuth = draw(ANGLES)
    if draw(st.booleans()):
        off = draw(st.one_of(st.just(0.0), st.floats(-9.0, -1.0).map(lambda e: 10.0**e)))
        upright = draw(st.sampled_from((-1.0, 1.0)))
        z, flat = upright * math.cos(off), math.sin(off)
    else:
        elevation = draw(st.floats(-math.pi / 2, math.pi / 2))
        z, flat = math.sin(elevation), math.cos(elevation)
    return (flat * math.cos(azimuth), flat * math.sin(azimuth), z)


@given(directions(), st.floats(0.01, 20.0), st.integers(0, 2**32), st.booleans(), ANGLES, ANGLES)
@settings(max_examples=300, deadline=None)
def test_a_camera_turns_no_further_than_its_line_of_sight(
    direction, distance, seed, mounted, roll, yaw
):
    eye = (0.3, -0.2, 0.7)
    camera = CameraSpec(
        mount="left.tcp" if mounted else None,
        position=eye,
        look_at=add(eye, scale(direction, distance)),
    )
    mount = Pose((1.0, 2.0, 0.5), from_rpy(roll, 0.3, yaw)) if mounted else AT_ORIGIN
    written, varied = views(camera, seed, mount)
    assert turn_deg(written, varied) == pytest.approx(sight_turn_deg(written, varied), abs=1e-4)
    assert turn_deg(written, varied) <= MOST_TURN_DEG + 1e-6 < 15.1
    most = min(0.006 if mounted else SHIFT_M, 0.1 * distance)
    for before, after, bound in (
        (written.eye, varied.eye, most),
        (written.target, varied.target, most / 2.0),
    ):
        shift = subtract(mount.inverse().apply(after), mount.inverse().apply(before))
        assert max(map(abs, shift)) <= bound + 1e-9
    assert 0.97 <= varied.fov_deg / written.fov_deg <= 1.1


def test_a_camera_that_does_not_vary_is_as_written():
    camera = CameraSpec(position=(0.0, 0.0, 2.0), look_at=(0.0, 0.0, 0.0))
    scene = TASK.scene.model_copy(update={"cameras": {"one": camera}})
    look = draw_look(TASK, scene, np.random.default_rng(0), ("light",))
    one, other = (
        camera_view(scene.cameras, "one", lambda _: AT_ORIGIN, each) for each in (AS_WRITTEN, look)
    )
    assert one == other
    assert one.up == (0.0, 1.0, 0.0)


@pytest.mark.parametrize("name", sorted(Catalogue.discover().tasks))
def test_the_cameras_of_the_library_turn_by_a_few_degrees(name):
    for camera in load_task(name).file.spec.scene.cameras.values():
        for seed in range(30):
            written, varied = views(camera, seed, Pose((0.1, 0.2, 0.6), from_rpy(3.0, 0.1, 0.4)))
            assert turn_deg(written, varied) < 12.0
