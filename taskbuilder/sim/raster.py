"""Drawing a client's world by the rasteriser: what its shapes look like, and where they are."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.mesh import read_mesh
from taskbuilder.geometry import Pose
from taskbuilder.raster import (
    MeshInstance,
    Pattern,
    Scene,
    TriangleMesh,
    box,
    capsule,
    cylinder,
    parts_of,
    simplified,
    sphere,
)
from taskbuilder.shapes import BoxShape, CylinderShape, SphereShape
from taskbuilder.sim.body import BASE, inertial_frame
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.mesh_colors import WHITE, Color, face_colors
from taskbuilder.sim.scenery import Distractor, Texture

FLOOR_REACH_M = 1.5
"""What is wider than this, from its middle, casts no shadow that anybody would see."""

TEXTURE_SHARE = 0.55
"""Of a texture's colour, where it alternates with that of a shape, so that parts stay apart."""

_WORLD = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
"""The pose of the world's frame, for what belongs to no body."""

MOST_TRIANGLES = 2_400
"""Meshes with more are simplified."""


def raster_world(client: Client) -> RasterWorld:
    """The look of a client's bodies, which is kept until bodies or their colours change."""
    known = client.drawn
    state = (client.bullet.getNumBodies(), client.looks)
    if not isinstance(known, RasterWorld) or known.state != state:
        known = client.drawn = RasterWorld(client, state)
    return known


class RasterWorld:
    """The look of a client's bodies.

    Args:
        client: The world.
        state: Number of bodies, and of changes of their look.

    Attributes:
        state: As it was given.
        scene: The shapes, packed for drawing.
        shapes: The shapes, each in its link.
        bodies: Bullet's number of the body of each shape, -1 for a distractor, and -1.
        links: Index of the link of each shape, -1 for a distractor, and -1.
        rows: Row of the base of each body in `link_poses`, by Bullet's number of the body; its
            links follow.
    """

    def __init__(self, client: Client, state: tuple[int, int]) -> None:
        self.state = state
        self._bullet = client.bullet
        self._bodies: list[tuple[int, Pose | None, list[int]]] = []
        shapes: list[MeshInstance] = []
        owners: list[tuple[int, int]] = []
        self.rows: dict[int, int] = {}
        rows = 0
        for number in range(self._bullet.getNumBodies()):
            body = self._bullet.getBodyUniqueId(number)
            count = self._bullet.getNumJoints(body)
            inertial = inertial_frame(client, body, BASE)
            base = None if inertial == Pose() else inertial.inverse()
            self._bodies.append((body, base, list(range(count))))
            self.rows[body] = rows
            texture = client.scenery.textures.get(body)
            for data in self._bullet.getVisualShapeData(body):
                link, kind, sizes, name, position, quaternion, color = data[1:8]
                file = client.meshes.get(name.decode(), Path(name.decode()))
                pose = Pose(position, quaternion)
                made = _shapes(rows + 1 + link, texture, kind, tuple(sizes), file, pose, color)
                shapes += made
                owners += [(body, link)] * len(made)
            rows += 1 + count
        shapes += [_drawn_only(rows, thing) for thing in client.scenery.distractors]
        owners += [(-1, -1)] * len(client.scenery.distractors)
        self.shapes = tuple(shapes)
        self.scene = Scene(shapes)
        self.bodies = np.array([*(body for body, _ in owners), -1], np.int32)
        self.links = np.array([*(link for _, link in owners), -1], np.int32)

    def refresh(self) -> None:
        """Put the shapes where their bodies are."""
        self.scene.place(self.link_poses())

    def link_poses(self) -> NDArray[np.float64]:
        """(l, 7) position in metres and quaternion (x, y, z, w) of every link in the world.

        The rows are those that `MeshInstance.link` numbers; the last is the frame of the world.
        """
        rows: list[tuple[float, ...]] = []
        bullet = self._bullet
        for body, com_from_base, links in self._bodies:
            position, quaternion = bullet.getBasePositionAndOrientation(body)
            if com_from_base is not None:
                pose = Pose(position, quaternion) @ com_from_base
                position, quaternion = pose.position, pose.quaternion
            rows.append(position + quaternion)
            if links:
                states = bullet.getLinkStates(body, links, computeForwardKinematics=1)
                rows += [state[4] + state[5] for state in states]
        rows.append(_WORLD)
        return np.array(rows)


def _pattern(texture: Texture | None, own: Color) -> Pattern | None:
    """The rasteriser's form of a texture on a shape of a colour."""
    if texture is None:
        return None
    red, green, blue = (
        TEXTURE_SHARE * new + (1.0 - TEXTURE_SHARE) * old
        for new, old in zip(texture.color, own, strict=True)
    )
    return Pattern(texture.kind, (red, green, blue), texture.period, texture.angle)


@lru_cache(maxsize=512)
def primitive(kind: int, sizes: tuple[float, ...]) -> TriangleMesh | None:
    """The mesh of a shape that has no file, as Bullet accounts for it; None for other kinds.

    Args:
        kind: Bullet's kind of shape.
        sizes: Its lengths.
    """
    if kind == p.GEOM_BOX:
        return box((sizes[0], sizes[1], sizes[2]))
    if kind == p.GEOM_SPHERE:
        return sphere(sizes[0])
    if kind == p.GEOM_CYLINDER:
        return cylinder(sizes[1], sizes[0])
    if kind == p.GEOM_CAPSULE:
        return capsule(sizes[1], sizes[0])
    return None


def matrix(pose: Pose) -> NDArray[np.float64]:
    """(3, 4) rotation and position."""
    columns = [pose.axis(0), pose.axis(1), pose.axis(2), pose.position]
    return np.ascontiguousarray(np.array(columns).T)


def _drawn_only(row: int, thing: Distractor) -> MeshInstance:
    """The rasteriser's form of a distractor, in the row of the world's frame."""
    match thing.shape:
        case BoxShape(size):
            mesh = box(size)
        case CylinderShape(radius, length):
            mesh = cylinder(radius, length)
        case SphereShape(radius):
            mesh = sphere(radius)
    return MeshInstance(mesh, row, matrix(thing.pose), (*thing.color, 1.0))


def _shapes(
    row: int,
    texture: Texture | None,
    kind: int,
    sizes: tuple[float, ...],
    file: Path,
    pose: Pose,
    color: tuple[float, float, float, float],
) -> list[MeshInstance]:
    """What Bullet's account of a shape looks like; nothing for one that cannot be drawn."""
    placed = matrix(pose)
    red, green, blue, opacity = color
    shapes = []
    # A colour that a URDF or a task file gives is that of the whole mesh. White stands for none.
    unpainted = color[:3] == WHITE
    for mesh, (r, g, b) in _meshes(kind, sizes, file, unpainted):
        wide = float(np.abs(mesh.vertices).max()) > FLOOR_REACH_M
        own = (red * r, green * g, blue * b)
        pattern = _pattern(texture, own)
        shapes.append(MeshInstance(mesh, row, placed, (*own, opacity), not wide, pattern))
    return shapes


@lru_cache(maxsize=512)
def _meshes(
    kind: int, sizes: tuple[float, ...], file: Path, diffuse: bool
) -> tuple[tuple[TriangleMesh, Color], ...]:
    """The meshes of a shape, each with its tint.

    Args:
        kind: Bullet's kind of shape.
        sizes: Its lengths, or the scale of a mesh.
        file: The file of a mesh.
        diffuse: Whether the diffuse colours in a mesh's materials count.
    """
    if kind == p.GEOM_MESH:
        return tuple(_from_file(file, sizes, diffuse=diffuse))
    mesh = primitive(kind, sizes)
    return () if mesh is None else ((mesh, WHITE),)


def _from_file(
    path: Path, scale: tuple[float, ...], *, diffuse: bool
) -> Iterator[tuple[TriangleMesh, Color]]:
    """The parts of a mesh file that have one colour each."""
    mesh = read_mesh(path)
    points = np.asarray(mesh.points, np.float64).reshape(-1, 3) * np.asarray(scale)
    triangles: NDArray[np.int32] = np.asarray(mesh.corners, np.int32).reshape(-1, 3)
    if np.prod(scale) < 0.0:  # a mirror image, in which triangles run the other way round
        triangles = np.ascontiguousarray(triangles[:, ::-1])
    colors, color_of = face_colors(mesh, diffuse=diffuse)
    points, triangles, origin = simplified(points, triangles, MOST_TRIANGLES)
    most = np.median(color_of[origin], axis=1).astype(np.intp)  # what two of three corners have
    left, part = np.unique(most, return_inverse=True)
    yield from zip(parts_of(points, triangles, part), (colors[n] for n in left), strict=True)
