"""What a world looks like and collides by, as meshes in named links, and where the links are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster import MeshInstance, TriangleMesh
from taskbuilder.sim.collision_geometry import collision_shapes
from taskbuilder.sim.raster import RasterWorld, matrix, raster_world
from taskbuilder.world.segments import FLOOR
from taskbuilder.world.world import World

Color = tuple[int, int, int]

COLLISION_COLORS = ((0.05, 0.65, 0.91), (0.55, 0.36, 0.96), (0.06, 0.73, 0.51), (0.96, 0.62, 0.04))
"""The shapes by which a link collides have these in turn, so that they can be told apart."""

COLLISION_OPACITY = 0.4

APART_M = 1e-3
"""Collision shapes are drawn so much larger, or looks of the same size would flicker through them.

So much farther out the engine lets hulls of meshes collide, too."""


class VisibleMesh(NamedTuple):
    """Triangles of one colour in the frame of a link.

    Attributes:
        vertices: (v, 3) float32 positions in metres.
        triangles: (t, 3) numbers of vertices.
        color: Red, green and blue, 0 to 255.
        opacity: 0 to 1.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.int32]
    color: Color
    opacity: float


@dataclass(frozen=True)
class VisibleLink:
    """A link that can be seen.

    Attributes:
        name: Its dotted name, such as ``left.wrist_3_link`` or ``cube``.
        row: Its row in `LinkPoses.now`.
        meshes: What it looks like.
    """

    name: str
    row: int
    meshes: tuple[VisibleMesh, ...]


def visible_links(world: World) -> tuple[VisibleLink, ...]:
    """The links of a world that can be seen, in the order of the files.

    A texture shows as the mean of its two colours.
    """
    drawn = raster_world(world.client)
    numbers, names = world.segments.of(drawn.bodies, drawn.links), world.segments.names
    groups: dict[tuple[int, str], list[MeshInstance]] = {}
    for shape, number in zip(drawn.shapes, numbers, strict=False):
        name = names[number] if number else "distractors"
        if shape.color[3] > 0.0:
            groups.setdefault((shape.link, name), []).append(shape)
    return tuple(VisibleLink(name, row, _meshes(shapes)) for (row, name), shapes in groups.items())


def collision_links(world: World) -> tuple[VisibleLink, ...]:
    """The shapes by which the links of a world collide, each with the links that have any.

    They are those that the physics uses, a millimetre larger: primitives, the convex hulls of
    meshes, or the whole surface of a mesh that does not move. The floor is left out.
    """
    rows = raster_world(world.client).rows
    links = []
    for name, body, link in world.segments.parts:
        shapes = collision_shapes(world.client, body, link) if name != FLOOR else ()
        row = rows[body] + 1 + link
        instances = [
            MeshInstance(
                _enlarged(shape.mesh),
                row,
                matrix(shape.pose),
                (*COLLISION_COLORS[number % len(COLLISION_COLORS)], COLLISION_OPACITY),
            )
            for number, shape in enumerate(shapes)
        ]
        if instances:
            links.append(VisibleLink(name, row, _meshes(instances)))
    return tuple(links)


def _enlarged(mesh: TriangleMesh) -> TriangleMesh:
    """A mesh whose vertices are `APART_M` farther out; those at the same place stay together."""
    _, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    out = np.zeros((place.max() + 1, 3), np.float32)
    np.add.at(out, place.reshape(-1), mesh.normals)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-6)
    moved = mesh.vertices + APART_M * out[place.reshape(-1)]
    return replace(mesh, vertices=moved.astype(np.float32))


def _meshes(shapes: list[MeshInstance]) -> tuple[VisibleMesh, ...]:
    """Shapes of the same colour are one mesh."""
    by_color: dict[tuple[Color, float], list[MeshInstance]] = {}
    for shape in shapes:
        color = np.array(shape.color[:3])
        if shape.pattern is not None:
            color = (color + np.array(shape.pattern.color)) / 2.0
        red, green, blue = np.clip(np.rint(255.0 * color), 0, 255).astype(int).tolist()
        by_color.setdefault(((red, green, blue), shape.color[3]), []).append(shape)
    return tuple(_joined(own, color, opacity) for (color, opacity), own in by_color.items())


def _joined(shapes: list[MeshInstance], color: Color, opacity: float) -> VisibleMesh:
    vertices, triangles, count = [], [], 0
    for shape in shapes:
        turn, at = shape.pose[:, :3], shape.pose[:, 3]
        vertices.append(shape.mesh.vertices @ turn.T + at)
        triangles.append(shape.mesh.triangles + count)
        count += len(shape.mesh.vertices)
    points = np.concatenate(vertices).astype(np.float32)
    return VisibleMesh(points, np.concatenate(triangles).astype(np.int32), color, opacity)


class LinkPoses:
    """The poses of all links of a world."""

    def __init__(self, world: World) -> None:
        self._world = world

    def now(self) -> NDArray[np.float32]:
        """(l, 7) position in metres and quaternion (w, x, y, z) of each link in the world."""
        self._world.move_markers()
        drawn: RasterWorld = raster_world(self._world.client)
        poses = drawn.link_poses()
        return poses[:, [0, 1, 2, 6, 3, 4, 5]].astype(np.float32)
