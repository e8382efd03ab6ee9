"""Poses and boxes, checked against rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from taskbuilder import geometry
from taskbuilder.geometry import NO_TURN, ORIGIN, Box, Pose

coordinates = st.floats(-100.0, 100.0)
vectors = st.tuples(coordinates, coordinates, coordinates)
angles = st.floats(-math.pi, math.pi)
rotations = st.builds(geometry.from_rpy, angles, angles, angles)
poses = st.builds(Pose, vectors, rotations)
sizes = st.floats(0.0, 10.0)
boxes = st.builds(Box, vectors, st.tuples(sizes, sizes, sizes))
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def close(value: object) -> object:
    return pytest.approx(value, rel=1e-9, abs=1e-9)


def matrix(q: geometry.Quat) -> np.ndarray:
    """(3, 3) rotation matrix of a unit quaternion, by the textbook's formula."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def turn_about(axis: int, angle: float) -> np.ndarray:
    """(3, 3) matrix of a turn about the x (0), y (1) or z (2) axis."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


@given(vectors, vectors)
def test_vector_arithmetic_agrees_with_numpy(a, b):
    assert geometry.add(a, b) == close(tuple(np.add(a, b)))
    assert geometry.subtract(a, b) == close(tuple(np.subtract(a, b)))
    assert geometry.dot(a, b) == close(np.dot(a, b))
    assert geometry.cross(a, b) == close(tuple(np.cross(a, b)))
    assert geometry.norm(a) == close(np.linalg.norm(a))


@given(vectors)
def test_a_unit_vector_has_length_one_and_the_same_direction(a):
    assume(geometry.norm(a) > 1e-6)
    direction = geometry.unit(a)
    assert geometry.norm(direction) == close(1.0)
    assert geometry.scale(direction, geometry.norm(a)) == close(a)


def test_nothing_has_no_direction():
    with pytest.raises(ValueError, match="no direction"):
        geometry.unit(ORIGIN)
    with pytest.raises(ValueError, match="no rotation"):
        geometry.normalized((0.0, 0.0, 0.0, 0.0))


@given(angles, angles, angles)
def test_rpy_turns_about_fixed_x_then_y_then_z_as_urdf_does(roll, pitch, yaw):
    expected = turn_about(2, yaw) @ turn_about(1, pitch) @ turn_about(0, roll)
    assert matrix(geometry.from_rpy(roll, pitch, yaw)) == close(expected)


def test_degrees_and_radians_agree():
    assert geometry.from_rpy_deg((10.0, 20.0, 30.0)) == close(
        geometry.from_rpy(*np.radians([10.0, 20.0, 30.0]))
    )
    assert Pose.from_rpy_deg((1.0, 2.0, 3.0), (0.0, 0.0, 90.0)).axis(0) == close((0.0, 1.0, 0.0))


@given(rotations, vectors)
def test_rotating_agrees_with_the_matrix_and_keeps_length(q, v):
    assert geometry.rotate(q, v) == close(tuple(matrix(q) @ np.array(v)))
    assert geometry.norm(geometry.rotate(q, v)) == close(geometry.norm(v))


@given(rotations, rotations)
def test_a_product_of_rotations_is_the_right_one_first(a, b):
    assert matrix(geometry.multiply(a, b)) == close(matrix(a) @ matrix(b))


@given(rotations)
def test_the_conjugate_undoes_a_rotation(q):
    assert geometry.multiply(q, geometry.conjugate(q)) == close(NO_TURN)


@given(rotations, st.floats(0.1, 10.0))
def test_normalizing_keeps_the_rotation(q, factor):
    scaled = (q[0] * factor, q[1] * factor, q[2] * factor, q[3] * factor)
    assert geometry.normalized(scaled) == close(q)


@given(rotations)
def test_a_rotation_is_found_again_from_its_axes(q):
    again = geometry.from_axes(*(geometry.rotate(q, axis) for axis in AXES))
    assert geometry.turn_between(q, again) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_are_found_from_their_axes(axis):
    half_turn = geometry.from_rpy(*(math.pi * part for part in AXES[axis]))
    again = geometry.from_axes(*(geometry.rotate(half_turn, direction) for direction in AXES))
    assert matrix(again) == close(turn_about(axis, math.pi))


@given(rotations, rotations)
def test_the_turn_between_two_rotations_is_the_same_both_ways(a, b):
    turn = geometry.turn_between(a, b)
    assert 0.0 <= turn <= math.pi
    assert turn == close(geometry.turn_between(b, a))
    opposite = (-b[0], -b[1], -b[2], -b[3])
    assert turn == close(geometry.turn_between(a, opposite))


@given(st.integers(0, 2), angles)
def test_the_turn_about_an_axis_is_its_angle(axis, angle):
    turned = geometry.from_rpy(*(angle * part for part in AXES[axis]))
    assert geometry.turn_between(NO_TURN, turned) == pytest.approx(abs(angle), abs=1e-7)


@given(poses, poses, vectors)
def test_composed_poses_apply_one_after_the_other(a, b, point):
    assert (a @ b).apply(point) == close(a.apply(b.apply(point)))


@given(poses, vectors)
def test_the_inverse_of_a_pose_leads_back(pose, point):
    assert pose.inverse().apply(pose.apply(point)) == close(point)
    assert (pose @ pose.inverse()).position == pytest.approx(ORIGIN, abs=1e-9)
    assert geometry.turn_between((pose @ pose.inverse()).quaternion, NO_TURN) == close(0.0)


@given(poses)
def test_the_axes_of_a_pose_are_the_columns_of_its_matrix(pose):
    for index in range(3):
        assert pose.axis(index) == close(tuple(matrix(pose.quaternion)[:, index]))


@given(poses, vectors)
def test_a_moved_pose_keeps_its_orientation(pose, offset):
    assert pose.moved(offset) == Pose(geometry.add(pose.position, offset), pose.quaternion)


def test_poses_are_values():
    assert Pose() == Pose(ORIGIN, NO_TURN)
    assert len({Pose(), Pose((0.0, 0.0, 0.0)), Pose((1.0, 0.0, 0.0))}) == 2
    with pytest.raises(AttributeError):
        Pose().position = ORIGIN


@given(boxes)
def test_a_box_contains_its_corners_and_centre(box):
    corners = list(box.corners())
    assert len(corners) == 8
    assert box.low in corners
    assert box.high in corners
    assert box.contains(box.center)
    assert all(box.contains(corner, margin=-1e-9) for corner in corners)
    assert geometry.bounding_box(corners).half == close(box.half)


@given(boxes, poses)
def test_a_box_seen_from_another_frame_contains_every_corner_and_no_more(box, frame_from_box):
    seen = box.seen_from(frame_from_box)
    corners = np.array([frame_from_box.apply(corner) for corner in box.corners()])
    assert all(seen.contains(tuple(corner), margin=-1e-9) for corner in corners)
    assert seen.low == close(tuple(corners.min(axis=0)))
    assert seen.high == close(tuple(corners.max(axis=0)))


def test_a_margin_shrinks_what_a_box_contains():
    box = Box.around((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0))
    assert box == Box((0.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    assert box.contains((0.95, 0.0, 1.0))
    assert not box.contains((0.95, 0.0, 1.0), margin=0.1)
    assert not box.contains((0.0, 0.0, 2.01))


def test_no_points_have_no_box():
    with pytest.raises(ValueError, match="no points"):
        geometry.bounding_box([])


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ((1, 0, 0), (0, 2, 0)),
        ((0.3, -0.2, 5), (0.3, -0.2, 5)),
        ((0, 0, 1), (1e-9, 0, 1)),
        ((0, 0, 3), (0, 0, -1)),
        ((1, 0, 0), (-1, 0, 0)),
        ((1, 2, 3), (-3, 0.5, 1)),
    ],
)
def test_the_shortest_turn_takes_one_direction_onto_another(a, b):
    turn = geometry.turn_onto(a, b)
    assert geometry.rotate(turn, geometry.unit(a)) == pytest.approx(geometry.unit(b), abs=1e-12)
    angle = math.atan2(
        geometry.norm(geometry.cross(geometry.unit(a), geometry.unit(b))),
        geometry.dot(geometry.unit(a), geometry.unit(b)),
    )
    assert geometry.turn_between(NO_TURN, turn) == pytest.approx(angle, abs=1e-7)


def test_the_shortest_turn_onto_the_same_direction_is_none():
    assert geometry.turn_onto((0.0, 0.6, 0.8), (0.0, 0.6, 0.8)) == NO_TURN
