"""Meshes whose hollow is filled where they collide: a mug as if it had a lid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets import codes
from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.errors import Finding
from taskbuilder.schema.load import TaskFile

MOST_INSIDE = 0.3
"""Share of a surface that may lie inside the convex hull before it is said.

About half of the surface of a mug does.
"""

_DEEP = 0.25  # of the longest edge of the bounding box: what lies so deep inside counts
_FACES, _POINTS = 600, 1500  # that are looked at, at most


def filled_hollows(task: TaskFile) -> tuple[Finding, ...]:
    """Objects that move and collide by the hull of a hollow mesh, without being told to.

    Assets of an installed package are not for the author of a task to mend, and are left out.
    """
    if task.entry.trusted:
        return ()
    findings, installed = [], pybullet_data_folder()
    for name, asset in task.assets.items():
        spec = task.spec.scene.objects.get(name)
        if not isinstance(asset, Mesh) or spec is None or spec.fixed or spec.shape is None:
            continue
        plain = spec.shape.collide is None and spec.shape.collision is None
        if not plain or len(asset.groups) > 1:
            continue
        if installed is not None and asset.path.is_relative_to(installed):
            continue
        inside = share_inside(asset)
        if inside > MOST_INSIDE:
            file = asset.path.name
            message = (
                f"{file} is hollow: {inside * 100:.0f} % of its surface lies inside its convex "
                "hull, by which it collides, as if it had a lid; cut it into convex pieces with "
                f"taskbuilder objects import {file} (pip install 'taskbuilder[import]'), or write "
                "collide: hull if that is meant"
            )
            path = ("scene", "objects", name, "shape")
            findings.append(
                Finding(codes.FILLED, message, ".".join(path), task.source.locate(path), "warning")
            )
    return tuple(findings)


def share_inside(mesh: Mesh) -> float:
    """Share of the surface of a mesh, from 0 to 1, that lies deep inside its convex hull.

    A triangle does if much of the mesh lies beyond its plane, on its outer side: beyond the inner
    wall of a mug is the opposite wall.
    """
    points = np.asarray(mesh.points, np.float64).reshape(-1, 3)
    corners: NDArray[np.float64] = points[np.asarray(mesh.corners, np.intp).reshape(-1, 3)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    wanted = np.flatnonzero(areas > 0.0)
    if not len(wanted):
        return 0.0
    wanted = wanted[:: max(1, len(wanted) // _FACES)]
    seen = points[:: max(1, len(points) // _POINTS)]
    units = normals[wanted] / areas[wanted, None]
    heights = seen @ units.T - np.einsum("ij,ij->i", corners[wanted, 0], units)
    deep = heights.max(axis=0) > _DEEP * float(np.ptp(points, axis=0).max())
    return float(areas[wanted][deep].sum() / areas[wanted].sum())
