"""Triangle meshes: primitives are closed and smooth where they should be, and light."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskbuilder.raster import (
    TriangleMesh,
    box,
    capsule,
    cylinder,
    mesh_of,
    parts_of,
    simplified,
    sphere,
)
from taskbuilder.raster.geometry import nearest

SIZES = st.floats(0.01, 2.0)


def volume(mesh: TriangleMesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(float) for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def outward(mesh: TriangleMesh) -> bool:
    """Whether every corner's normal is on the outer side of its triangle."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(float) for corner in range(3))
    faces = np.cross(b - a, c - a)
    return all(
        (np.einsum("ij,ij->i", faces, mesh.normals[mesh.triangles[:, corner]]) > 0).all()
        for corner in range(3)
    )


@given(SIZES, SIZES)
@settings(max_examples=30)
def test_primitives_have_their_volume_from_within_and_normals_of_length_one(radius, length):
    ball = 4 / 3 * np.pi * radius**3
    for mesh, expected in (
        (box((radius, length, 0.3)), radius * length * 0.3),
        (cylinder(radius, length), np.pi * radius**2 * length),
        (sphere(radius), ball),
        (capsule(radius, length), np.pi * radius**2 * length + ball),
    ):
        assert 0.97 * expected < volume(mesh) <= 1.0001 * expected
        assert outward(mesh)
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)


def test_sharp_edges_stay_sharp_and_round_ones_are_smooth():
    assert len(np.unique(box((1, 1, 1)).normals, axis=0)) == 6
    rod = cylinder(0.1, 1.0)
    caps = np.abs(rod.normals[:, 2]) > 0.99
    assert caps.any()
    np.testing.assert_allclose(rod.normals[~caps][:, 2], 0.0, atol=1e-6)  # not rounded at the rim


def test_a_mesh_that_is_inside_out_is_turned():
    good = box((1, 1, 1))
    again = mesh_of(good.vertices.astype(float), good.triangles[:, ::-1])
    assert volume(again) == pytest.approx(1.0)
    assert outward(again)


def test_a_heavy_mesh_is_made_light_and_keeps_its_shape():
    turns = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    heights = np.linspace(-1.0, 1.0, 101)
    grid = np.array([(np.cos(t) * 0.2, np.sin(t) * 0.2, z) for z in heights for t in turns])
    cells = [
        (r * 200 + i, r * 200 + (i + 1) % 200, (r + 1) * 200 + (i + 1) % 200, (r + 1) * 200 + i)
        for r in range(100)
        for i in range(200)
    ]
    faces = np.array([f for a, b, c, d in cells for f in ((a, b, c), (a, c, d))], np.int32)
    points, fewer, origin = simplified(grid, faces, 1500)
    mesh = mesh_of(points, fewer)
    assert len(mesh.triangles) <= 1500
    middles, before = points[fewer].mean(axis=1), grid[faces].mean(axis=1)
    assert np.linalg.norm(middles - before[origin[:, 0]], axis=1).max() < 0.2
    radii = np.linalg.norm(mesh.vertices[:, :2], axis=1)
    assert radii.min() > 0.19
    assert radii.max() < 0.21
    assert np.abs(mesh.vertices[:, 2]).max() == pytest.approx(1.0, abs=0.01)


def test_a_mesh_of_many_loose_parts_keeps_its_surface():
    turns = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1) * 0.005
    tube = np.array([(x, y, z) for z in (0.0, 0.05) for x, y in ring])
    here, then = np.arange(16), (np.arange(16) + 1) % 16
    sides = np.concatenate(
        [np.stack([here, then, then + 16], 1), np.stack([here, then + 16, here + 16], 1)]
    )
    places = [(0.02 * (n % 20), 0.02 * (n // 20), 0.0) for n in range(200)]
    points = np.concatenate([tube + place for place in places])
    faces = np.concatenate([sides + 32 * n for n in range(200)]).astype(np.int32)
    fewer_points, fewer, _ = simplified(points, faces, 500)  # not even three for each tube
    assert surface(fewer_points, fewer) > 0.8 * surface(points, faces)


def surface(points, triangles):
    a, b, c = points[triangles[:, 0]], points[triangles[:, 1]], points[triangles[:, 2]]
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def test_parts_of_a_mesh_are_smooth_where_they_meet():
    ball = sphere(0.1)
    upper = ball.vertices[ball.triangles].mean(axis=1)[:, 2] > 0
    parts = parts_of(ball.vertices.astype(float), ball.triangles, upper.astype(np.intp))
    assert sum(len(part.triangles) for part in parts) == len(ball.triangles)
    for part in parts:
        outward_normals = part.vertices / np.linalg.norm(part.vertices, axis=1, keepdims=True)
        np.testing.assert_allclose(part.normals, outward_normals, atol=0.05)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(1, 60))
def test_the_nearest_point_is_the_first_of_those_that_are(seed, count, others):
    rng = np.random.default_rng(seed)
    points, places = (rng.integers(-4, 5, (n, 3)) / 4.0 for n in (count, others))
    distances = ((points[:, None] - places[None]) ** 2).sum(axis=2)
    assert nearest(points, places).tolist() == distances.argmin(axis=1).tolist()
