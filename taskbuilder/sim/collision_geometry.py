"""The shapes by which bodies collide, as the physics engine has them.

The engine makes convex hulls of meshes, and says where their corners are. Of a mesh that a URDF
names, however, it only tells the corners of all hulls together. So the same file is loaded once
more, in a client of its own, which tells those of each hull.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose
from taskbuilder.hulls import hull_triangles
from taskbuilder.raster import TriangleMesh, mesh_of
from taskbuilder.shapes import MeshShape, mesh_groups
from taskbuilder.sim.body import BASE, inertial_frame
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.raster import primitive

Points = NDArray[np.float64]

UNNAMED = b"unknown_file"
"""What the engine calls the file of a mesh that a URDF does not name."""


class CollisionShape(NamedTuple):
    """A shape by which a link collides.

    Attributes:
        mesh: Its surface.
        pose: Where it is, in the frame of the link.
    """

    mesh: TriangleMesh
    pose: Pose


def collision_shapes(client: Client, body: int, link: int) -> tuple[CollisionShape, ...]:
    """The shapes by which a link collides: primitives, convex hulls, or the surface of a mesh.

    The engine lets hulls of meshes collide a millimetre farther out, which is left out.

    Args:
        client: The world.
        body: Bullet's number of the body.
        link: Index of the link.
    """
    surface = client.surfaces.get((body, link))
    if surface is not None and isinstance(surface.shape, MeshShape):
        return (CollisionShape(_surface(surface.shape), surface.pose),)
    return tuple(_shapes(client, body, link))


def _shapes(client: Client, body: int, link: int) -> Iterator[CollisionShape]:
    com = inertial_frame(client, body, link)
    found = client.bullet.getCollisionShapeData(body, link)
    for number, (_, _, kind, sizes, name, position, quaternion) in enumerate(found):
        if kind != p.GEOM_MESH:
            mesh = primitive(kind, tuple(sizes))
            if mesh is not None:
                yield CollisionShape(mesh, com @ Pose(position, quaternion))
        elif name == UNNAMED:
            yield CollisionShape(_hull(_corners(client.bullet, body, link, number)), com)
        else:
            pose = com @ Pose(position, quaternion)
            yield from (CollisionShape(hull, pose) for hull in _hulls(name.decode(), tuple(sizes)))


def _corners(bullet: Any, body: int, link: int, number: int) -> bytes:
    """The corners of a hull, in the frame of the link's centre of mass."""
    _, corners = bullet.getMeshData(body, link, collisionShapeIndex=number)
    return np.array(corners, np.float64).tobytes()


def _hulls(name: str, scale: tuple[float, ...]) -> tuple[TriangleMesh, ...]:
    """The hulls that the engine makes of a mesh file."""
    return _hulls_of(name, scale, Path(name).stat().st_mtime_ns)


@lru_cache(maxsize=256)
def _hulls_of(name: str, scale: tuple[float, ...], _changed: int) -> tuple[TriangleMesh, ...]:
    with Client(physics_hz=240) as alone:
        bullet = alone.bullet
        shape = bullet.createCollisionShape(p.GEOM_MESH, fileName=name, meshScale=scale)
        body = bullet.createMultiBody(baseMass=1.0, baseCollisionShapeIndex=shape)
        count = len(bullet.getCollisionShapeData(body, BASE))
        return tuple(_hull(_corners(bullet, body, BASE, number)) for number in range(count))


@lru_cache(maxsize=1024)
def _hull(corners: bytes) -> TriangleMesh:
    """The convex hull of (n, 3) float64 points."""
    points: Points = np.frombuffer(corners).reshape(-1, 3)
    return mesh_of(points, hull_triangles(points).astype(np.int32))


def _surface(shape: MeshShape) -> TriangleMesh:
    corners = np.concatenate(mesh_groups(shape)).reshape(-1, 3)
    return mesh_of(corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3))
