from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pybullet_data
import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose
from taskbuilder.shapes import (
    BoxShape,
    CapsuleShape,
    CylinderShape,
    MeshShape,
    SphereShape,
    bounds,
    check_shape,
    mesh_corners,
    placed_bounds,
    solid,
)

TILTED = Pose.from_rpy_deg((0.1, -0.2, 0.3), (30, 40, 50))
CUBE_FACES = ["1 3 2", "2 3 4", "5 6 7", "6 8 7", "1 2 5", "2 6 5"]
CUBE_FACES += ["3 7 4", "4 7 8", "1 5 3", "3 5 7", "2 4 6", "4 8 6"]


def write_box(path: Path, size: tuple[float, float, float], center=(0.0, 0.0, 0.0)) -> Path:
    low, high = np.array(center) - np.array(size) / 2, np.array(center) + np.array(size) / 2
    corners = [
        (x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in CUBE_FACES]
    path.write_text("\n".join(lines))
    return path


def sampled_moments(inside, extent: float) -> np.ndarray:
    """Moments of inertia of 1 kg by brute force, from points inside a shape."""
    axis = np.linspace(-extent, extent, 80)
    points = np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    x, y, z = points[inside(*points.T)].T
    return np.array([(y * y + z * z).mean(), (x * x + z * z).mean(), (x * x + y * y).mean()])


def test_moments_of_a_cylinder_and_a_capsule_agree_with_counting_points():
    def in_cylinder(x, y, z):
        return (np.hypot(x, y) <= 0.3) & (np.abs(z) <= 0.4)

    def in_capsule(x, y, z):
        return np.sqrt(x * x + y * y + np.maximum(np.abs(z) - 0.4, 0.0) ** 2) <= 0.3

    cylinder, capsule = CylinderShape(0.3, 0.8), CapsuleShape(0.3, 0.8)
    assert np.allclose(solid(cylinder).inertia, sampled_moments(in_cylinder, 0.8), rtol=0.03)
    assert np.allclose(solid(capsule).inertia, sampled_moments(in_capsule, 0.8), rtol=0.03)


def test_a_box_given_as_a_mesh_weighs_and_turns_like_the_box(tmp_path):
    path = write_box(tmp_path / "box.obj", (0.1, 0.2, 0.3), center=(1.0, 2.0, 3.0))
    as_mesh, as_box = solid(MeshShape(path)), solid(BoxShape((0.1, 0.2, 0.3)))
    assert as_mesh.volume == pytest.approx(as_box.volume)
    assert as_mesh.principal.position == pytest.approx((1.0, 2.0, 3.0))
    assert sorted(as_mesh.inertia) == pytest.approx(sorted(as_box.inertia))


def test_principal_axes_of_a_mesh_point_along_its_edges(tmp_path):
    principal = solid(MeshShape(write_box(tmp_path / "box.obj", (0.1, 0.2, 0.3)))).principal
    # Moments come in ascending order, so the first axis is the long one: z.
    assert abs(principal.axis(0)[2]) == pytest.approx(1.0)


def test_a_mesh_with_a_hole_is_weighed_as_its_bounding_box(tmp_path):
    path = write_box(tmp_path / "box.obj", (0.1, 0.2, 0.3))
    path.write_text(path.read_text().rsplit("\n", 1)[0])
    assert solid(MeshShape(path)).volume == pytest.approx(0.006)


def test_bounds_of_turned_shapes_are_exact():
    leaning = Pose.from_rpy_deg((0.0, 0.0, 0.0), (45, 0, 0))
    root = math.sqrt(0.5)
    assert placed_bounds(CapsuleShape(0.1, 0.4), leaning).half == pytest.approx(
        (0.1, 0.2 * root + 0.1, 0.2 * root + 0.1)
    )
    assert placed_bounds(CylinderShape(0.1, 0.4), leaning).half == pytest.approx(
        (0.1, 0.3 * root, 0.3 * root)
    )
    assert placed_bounds(SphereShape(0.1), TILTED).half == (0.1, 0.1, 0.1)


def test_bounds_of_a_scaled_mesh(tmp_path):
    path = write_box(tmp_path / "box.obj", (0.1, 0.2, 0.3))
    assert bounds(MeshShape(path, (2.0, 1.0, 1.0))).half == pytest.approx((0.1, 0.1, 0.15))


@pytest.mark.parametrize(
    "shape", [BoxShape((0.1, 0.0, 0.1)), SphereShape(-1.0), CylinderShape(0.1, math.nan)]
)
def test_a_shape_without_extent_is_refused(shape):
    with pytest.raises(SimulationError, match="above 0"):
        check_shape(shape)


def test_a_binary_stl_is_read():
    corners = mesh_corners(
        MeshShape(Path(pybullet_data.getDataPath()) / "kuka_iiwa/meshes/link_4.stl")
    )
    assert corners.shape[1:] == (3, 3)
    assert 0.1 < np.ptp(corners.reshape(-1, 3), axis=0).max() < 1.0


def test_a_mesh_that_cannot_be_read_says_why(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nf 1 2 3")
    with pytest.raises(SimulationError, match="refers to item 2 of 1"):
        solid(MeshShape(tmp_path / "a.obj"))
