"""What a world looks like, as meshes in named links, and where the links are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster import MeshInstance
from taskbuilder.sim.raster import RasterWorld, raster_world
from taskbuilder.world.world import World

Color = tuple[int, int, int]


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
