"""Shapes that stay, drawn at poses that change."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.raster import filling, finishing, patterns
from taskbuilder.raster.meshes import TriangleMesh
from taskbuilder.raster.patterns import Pattern

Array = NDArray[np.float64]

_PLAIN = Pattern("checks", (0.0, 0.0, 0.0), 1.0, 0.0)
"""In the place of a shape that has no pattern."""

SHADOW_SIDE = 1024
"""Width and height of the depth map in which shadows are looked up."""

SHADOW_DEPTH = 0.42
"""Share of the diffuse light that a shadow takes away."""

SHADOW_BIAS_M = 0.006
"""A surface does not shade what is nearer to it than this."""


@dataclass(frozen=True)
class MeshInstance:
    """A mesh in a link.

    Attributes:
        mesh: The triangles.
        link: Number of the link, a row of the poses that `Scene.draw` takes.
        pose: (3, 4) rotation and position in the link's frame.
        color: Red, green, blue and opacity, 0 to 1. What is translucent is drawn over the rest; it
            has no depth and is not in the segmentation.
        casts_shadow: Whether it is between the lamp and others.
        pattern: Alternates with the colour, on what is opaque; None for one colour.
    """

    mesh: TriangleMesh
    link: int
    pose: Array
    color: tuple[float, float, float, float]
    casts_shadow: bool = True
    pattern: Pattern | None = None


@dataclass(frozen=True)
class PinholeCamera:
    """A pinhole camera with square pixels.

    Attributes:
        view: (3, 4) rotation and position of the world in the camera's frame: x right, y down,
            z forward.
        focal: Focal length in pixels.
        width: In pixels.
        height: In pixels.
        near: Nothing nearer is drawn, m.
        far: Nothing further is drawn, m.
    """

    view: Array
    focal: float
    width: int
    height: int
    near: float
    far: float


@dataclass(frozen=True)
class Lamp:
    """A distant lamp, and light from everywhere.

    Attributes:
        direction: Towards the lamp, in the world; need not be a unit vector.
        color: Red, green, blue, 0 to 1.
        ambient: Share of light from everywhere.
        diffuse: Share of light that depends on how a surface faces the lamp.
    """

    direction: tuple[float, float, float]
    color: tuple[float, float, float]
    ambient: float
    diffuse: float


@dataclass(frozen=True)
class Drawing:
    """What a camera sees.

    Attributes:
        rgb: (h, w, 3) uint8.
        depth: (h, w) float32, metres along the camera's z; the far plane where nothing is.
        shapes: (h, w) int32, number of the opaque shape; -1 where there is none.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    shapes: NDArray[np.int32]


class _Buffer(NamedTuple):
    """A z-buffer; see `filling`.

    Attributes:
        keys: (h, w) key of the nearest shape.
        ids: (h, w) its number; -1 where there is none.
        shades: (h, w) the share of light that it reflects.
    """

    keys: NDArray[np.float32]
    ids: NDArray[np.int32]
    shades: NDArray[np.float32]

    @classmethod
    def empty(cls, size: tuple[int, int], furthest: float) -> _Buffer:
        """A buffer with nothing in it but the key of what is too far."""
        ids = np.full(size, -1, np.int32)
        return cls(np.full(size, furthest, np.float32), ids, np.empty(size, np.float32))


class Scene:
    """Shapes, packed for drawing.

    Args:
        shapes: In any order; their places are their numbers.
    """

    def __init__(self, shapes: Sequence[MeshInstance]) -> None:
        meshes = list(dict.fromkeys(shape.mesh for shape in shapes))
        starts, vertex, triangle = {}, 0, 0
        for mesh in meshes:
            after = (vertex + len(mesh.vertices), triangle + len(mesh.triangles))
            starts[mesh] = (vertex, after[0], triangle, after[1])
            vertex, triangle = after
        self._vertices = _stacked([mesh.vertices for mesh in meshes], np.float32)
        self._normals = _stacked([mesh.normals for mesh in meshes], np.float32)
        numbered = [mesh.triangles + starts[mesh][0] for mesh in meshes]
        self._triangles = _stacked(numbered, np.uint32)
        self._spans = np.array([starts[s.mesh] for s in shapes], np.uint64).reshape(-1, 4)
        self._balls = np.array([_ball(s.mesh) for s in shapes]).reshape(-1, 4)
        self._link_of = np.array([s.link for s in shapes], np.int64)
        self._local = np.array([s.pose for s in shapes], np.float64).reshape(-1, 3, 4)
        self._scratch = np.empty((vertex, 5), np.float32)
        colors = np.array([s.color for s in shapes]).reshape(-1, 4)
        self._colors = (255.0 * colors[:, :3]).astype(np.float32)
        self._opacity = colors[:, 3]
        everything = np.arange(len(shapes))
        self._solid = everything[self._opacity >= 1.0]
        self._glass = everything[(self._opacity > 0.0) & (self._opacity < 1.0)]
        self._casting = self._solid[[shapes[s].casts_shadow for s in self._solid]]
        found = [shape.pattern or _PLAIN for shape in shapes]
        self._patterns = np.array([pattern.numbers for pattern in found]).reshape(-1, 4)
        self._patterns[[shape.pattern is None for shape in shapes], 0] = -1.0
        self._seconds = np.array([pattern.color for pattern in found], np.float32).reshape(-1, 3)
        self._seconds *= 255.0
        self._patterned = any(shape.pattern for shape in shapes)
        self._poses = np.empty((0, 3, 4))

    def place(self, links: Array) -> None:
        """Put all shapes where their links are.

        Args:
            links: (l, 7) position and quaternion (x, y, z, w) of each link in the world.
        """
        self._poses = filling.place(links, self._link_of, self._local)

    def draw(
        self,
        camera: PinholeCamera,
        lamp: Lamp,
        *,
        backdrop: NDArray[np.uint8],
        shadow: bool = False,
    ) -> Drawing:
        """Draw the shapes where they were placed.

        Args:
            camera: The camera.
            lamp: The light.
            backdrop: (h, 3) colours of what is behind everything, by row.
            shadow: Whether shapes shade one another.
        """
        size = (camera.height, camera.width)
        lens = np.array(
            (camera.focal, camera.width / 2.0, camera.height / 2.0, camera.near, camera.far)
        )
        direction = np.array(lamp.direction) / np.linalg.norm(lamp.direction)
        light = np.array((*direction, lamp.ambient, lamp.diffuse))
        view = np.ascontiguousarray(camera.view)
        buffer = _Buffer.empty(size, 1.0 / camera.far)
        self._fill(self._solid, view, lens, light, buffer)
        if shadow and len(self._casting):
            self._shade(view, lens, direction, lamp.ambient, buffer)
        rgb, depth = np.empty((*size, 3), np.uint8), np.empty(size, np.float32)
        colors = self._colors * np.array(lamp.color, np.float32)
        finishing.resolve(*buffer, colors, backdrop, camera.far, rgb, depth)
        if self._patterned:
            seconds = self._seconds * np.array(lamp.color, np.float32)
            about = (_inverse(view), lens, self._poses, self._patterns, colors, seconds)
            patterns.paint(*buffer, *about, rgb)
        if len(self._glass):
            self._glaze(view, lens, light, buffer, colors, rgb)
        return Drawing(rgb, depth, buffer.ids)

    def _fill(
        self,
        shapes: NDArray[np.int64],
        view: Array,
        lens: Array,
        light: Array,
        buffer: _Buffer,
        *,
        flat: bool = False,
    ) -> None:
        filling.draw(
            shapes,
            self._spans,
            self._balls,
            self._poses,
            self._vertices,
            self._normals,
            self._triangles,
            view,
            lens,
            light,
            flat,
            self._scratch,
            *buffer,
        )

    def _glaze(
        self,
        view: Array,
        lens: Array,
        light: Array,
        buffer: _Buffer,
        colors: NDArray[np.float32],
        rgb: NDArray[np.uint8],
    ) -> None:
        """Paint translucent shapes over the picture, the furthest first."""
        depths = self._poses[self._glass, :, 3] @ view[2, :3]
        for shape in self._glass[np.argsort(-depths, kind="stable")]:
            over = _Buffer.empty(rgb.shape[:2], 1.0 / lens[4])
            self._fill(np.array([shape]), view, lens, light, over)
            opacity = float(self._opacity[shape])
            finishing.blend(buffer.keys, over.keys, over.shades, colors[shape], opacity, rgb)

    def _shade(
        self,
        view: Array,
        lens: Array,
        direction: Array,
        ambient: float,
        buffer: _Buffer,
    ) -> None:
        """Take light from what the lamp does not reach."""
        lamp_view, lamp_lens = self._seen_by_lamp(direction)
        lamp = _Buffer.empty((SHADOW_SIDE, SHADOW_SIDE), -math.inf)
        light = np.array((*direction, 1.0, 0.0))
        self._fill(self._casting, lamp_view, lamp_lens, light, lamp, flat=True)
        finishing.darken(
            *(*buffer, _inverse(view), lens, lamp_view, lamp_lens, lamp.keys),
            *(ambient, SHADOW_BIAS_M, SHADOW_DEPTH),
        )

    def _seen_by_lamp(self, direction: Array) -> tuple[Array, Array]:
        """An orthographic camera above everything that casts a shadow."""
        balls = self._balls[self._casting]
        poses = self._poses[self._casting]
        centers = np.einsum("sij,sj->si", poses[:, :, :3], balls[:, :3]) + poses[:, :, 3]
        low = (centers - balls[:, 3:]).min(axis=0)
        high = (centers + balls[:, 3:]).max(axis=0)
        middle, radius = (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0
        forward = -direction
        across = np.cross(forward, (0.0, 0.0, 1.0) if abs(forward[2]) < 0.99 else (0.0, 1.0, 0.0))
        across /= np.linalg.norm(across)
        turn = np.stack([across, np.cross(forward, across), forward])
        view = np.concatenate([turn, -(turn @ middle)[:, None]], axis=1)
        half = SHADOW_SIDE / 2.0
        return view, np.array((half / radius, half, half, 0.0, math.inf))


def _inverse(view: Array) -> Array:
    """(3, 4) rotation and position of the camera in the world."""
    return np.concatenate([view[:, :3].T, -(view[:, :3].T @ view[:, 3:])], axis=1)


def _stacked(arrays: Sequence[NDArray[np.generic]], kind: type) -> NDArray[np.generic]:
    return np.concatenate(arrays).astype(kind) if arrays else np.empty((0, 3), kind)


def _ball(mesh: TriangleMesh) -> tuple[float, float, float, float]:
    """Centre and radius of a ball around a mesh."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    center = (low + high) / 2.0
    radius = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    return (float(center[0]), float(center[1]), float(center[2]), radius)
