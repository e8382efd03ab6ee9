"""Cameras: colour, depth and segmentation images with the matrices that explain them.

The camera's frame is that of computer vision: x to the right, y down, z into the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import SimulationError
from taskbuilder.extensions import RENDERERS, Part
from taskbuilder.geometry import Pose, Vec3, cross, from_axes, norm, scale, subtract, unit
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.renderers import Renderer

LARGEST_SIDE = 4096  # Bullet ends the process when an image is too large
NO_BODY = -1
# Where in a pixel its ray passes, from the left and from the top. Bullet's own renderer takes
# the lower left corner; OpenGL the centre.
_RAY_IN_PIXEL = {"raster": (0.5, 0.5), "tiny": (0.0, 1.0), "egl": (0.5, 0.5)}


@dataclass(frozen=True)
class CameraView:
    """Where a camera is and what it takes in.

    Attributes:
        eye: Position in the world, m.
        target: The point in the middle of the picture.
        up: What points up in the picture; need not be at right angles to the line of sight.
        fov_deg: Vertical opening angle.
        width: In pixels.
        height: In pixels.
        near: Nothing nearer is drawn, m.
        far: Nothing further is drawn, m.

    Raises:
        SimulationError: The view has no direction, or a number makes no sense.
    """

    eye: Vec3
    target: Vec3
    up: Vec3 = (0.0, 0.0, 1.0)
    fov_deg: float = 50.0
    width: int = 640
    height: int = 480
    near: float = 0.02
    far: float = 10.0

    def __post_init__(self) -> None:
        numbers = (*self.eye, *self.target, *self.up, self.fov_deg, self.near, self.far)
        if not all(map(math.isfinite, numbers)):
            raise SimulationError("a camera's position and lens must be finite numbers")
        _check_size(self.width, self.height)
        if not 0.0 < self.fov_deg < 180.0:
            raise SimulationError(f"a camera's fov_deg must be between 0 and 180: {self.fov_deg}")
        if not 0.0 < self.near < self.far:
            raise SimulationError(f"a camera needs 0 < near < far, not {self.near}, {self.far}")
        sight = subtract(self.target, self.eye)
        if norm(sight) < 1e-6:
            raise SimulationError(f"a camera at {self.eye} cannot look at its own position")
        if norm(self.up) < 1e-6 or norm(cross(unit(sight), unit(self.up))) < 1e-6:
            raise SimulationError(
                f"the camera at {self.eye} looks along its up vector {self.up}, so which way is "
                "up in the picture is undecided; give another up, such as (0, 1, 0)"
            )

    @property
    def pose(self) -> Pose:
        """The camera's frame (x right, y down, z forward) in the world."""
        forward = unit(subtract(self.target, self.eye))
        right = unit(cross(forward, self.up))
        return Pose(self.eye, from_axes(right, cross(forward, right), forward))

    @property
    def extrinsics(self) -> NDArray[np.float64]:
        """(4, 4) matrix that takes world coordinates to the camera's."""
        camera_from_world = self.pose.inverse()
        matrix = np.eye(4)
        for column in range(3):
            matrix[:3, column] = camera_from_world.axis(column)
        matrix[:3, 3] = camera_from_world.position
        return matrix


@dataclass(frozen=True)
class Light:
    """How a picture is lit.

    Attributes:
        direction: From the scene towards the lamp, in the world.
        color: Red, green, blue, 0 to 1.
        ambient: Share of light that comes from everywhere.
        diffuse: Share that depends on how a surface faces the lamp.
        specular: Share that glares.
        distance: Of the lamp from the origin, m.
    """

    direction: Vec3 = (-0.35, -0.5, 2.0)
    color: Vec3 = (1.0, 1.0, 1.0)
    ambient: float = 0.55
    diffuse: float = 0.48
    specular: float = 0.02
    distance: float = 4.0


@dataclass(frozen=True)
class Backdrop:
    """What is behind everything: a soft vertical gradient. Colours are 0 to 255."""

    top: tuple[int, int, int] = (236, 239, 243)
    bottom: tuple[int, int, int] = (205, 211, 219)


DAYLIGHT = Light()
STUDIO = Backdrop()


@dataclass(frozen=True)
class Image:
    """What a camera saw.

    Attributes:
        rgb: (height, width, 3) uint8.
        depth: (height, width) float32, metres along the camera's z; the far plane where nothing
            is.
        bodies: (height, width) int32, Bullet's number of the body; -1 where nothing is.
        links: (height, width) int32, index of the link, -1 being a body's base; -1 where nothing
            is, too.
        intrinsics: (3, 3) matrix that takes camera coordinates (x right, y down, z forward) to
            pixel indices (column, row) times depth. It is that of depth, bodies and links; rgb
            averages over each pixel's area.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    bodies: NDArray[np.int32]
    links: NDArray[np.int32]
    intrinsics: NDArray[np.float64]


@dataclass(frozen=True)
class Shot:
    """A picture to be drawn.

    Attributes:
        client: The world.
        view: The camera; its size is the size to draw.
        light: The lamp.
        behind: (height, 3) uint8, the colour of each row where nothing is.
        shadow: Whether things cast shadows.
    """

    client: Client
    view: CameraView
    light: Light
    behind: NDArray[np.uint8]
    shadow: bool


class Drawing(NamedTuple):
    """What a renderer draws of a `Shot`.

    Attributes:
        rgb: (height, width, 3) uint8.
        depth: (height, width) float32, metres along the camera's z; the far plane where nothing is.
        bodies: (height, width) int32, Bullet's number of the body; -1 where nothing is.
        links: (height, width) int32, index of the link; -1 for a body's base, and where nothing is.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    bodies: NDArray[np.int32]
    links: NDArray[np.int32]


class ForeignRenderer(Protocol):
    """The interface of renderers that other packages add."""

    ray_in_pixel: tuple[float, float]
    """Where the ray of a pixel passes it, as fractions of its width and height from its upper left
    corner; (0.5, 0.5) is the centre."""

    def draw(self, shot: Shot) -> Drawing:
        """Draw a picture."""
        ...


def capture(
    client: Client,
    view: CameraView,
    *,
    light: Light = DAYLIGHT,
    shadow: bool = False,
    supersample: int = 1,
    backdrop: Backdrop | None = None,
) -> Image:
    """Take a picture.

    Args:
        client: The world.
        view: The camera.
        light: The lamp.
        shadow: Whether things cast shadows; about twice the time.
        supersample: Draw this many times larger and average: smooth edges, for stills.
        backdrop: Painted where nothing is; without it, that is white.

    Raises:
        SimulationError: The picture would be larger than 4096 pixels a side.
    """
    if supersample < 1:
        raise SimulationError(f"supersample must be 1 or more, not {supersample}")
    width, height = view.width * supersample, view.height * supersample
    _check_size(width, height)
    larger = replace(view, width=width, height=height)
    shot = Shot(client, larger, light, _behind(backdrop, height), shadow)
    rgb, depth, bodies, links = draw_with(client.renderer, shot)
    if supersample > 1:
        size = (view.width, view.height)
        rgb = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    # Of the pixels drawn for one, depth and masks take that whose ray the pixel itself would have.
    across, down = _ray_in_pixel(client.renderer)
    column, row = (min(int(share * supersample), supersample - 1) for share in (across, down))
    chosen = (slice(row, None, supersample), slice(column, None, supersample))
    return Image(
        rgb=np.ascontiguousarray(rgb),
        depth=np.minimum(depth[chosen], np.float32(view.far)),
        bodies=bodies[chosen],
        links=links[chosen],
        intrinsics=_pinhole(view, (column + across) / supersample, (row + down) / supersample),
    )


def draw_with(renderer: str, shot: Shot) -> Drawing:
    """Draw by one of the library's own renderers, or by one that another package adds.

    Args:
        renderer: Its name.
        shot: What is drawn.

    Raises:
        ExtensionError: It is of another package, and cannot be used.
    """
    if renderer in _RAY_IN_PIXEL:
        return _rasterised(shot) if renderer == "raster" else _by_bullet(shot)
    part, foreign = _foreign(renderer)
    with part.at_work():
        drawing = Drawing(*foreign.draw(shot))
    size = (shot.view.height, shot.view.width)
    kinds = {"rgb": ((*size, 3), "uint8"), "depth": (size, "float32")}
    kinds |= dict.fromkeys(("bodies", "links"), (size, "int32"))
    for name, (shape, kind) in kinds.items():
        array = np.asarray(getattr(drawing, name))
        if array.shape != shape or array.dtype != kind:
            given = f"{array.shape} {array.dtype}"
            raise part.error(f"draws {name} of {given}, where {shape} {kind} is needed")
    return drawing


def _ray_in_pixel(renderer: str) -> tuple[float, float]:
    return _RAY_IN_PIXEL.get(renderer) or _foreign(renderer)[1].ray_in_pixel


def _foreign(renderer: str) -> tuple[Part, ForeignRenderer]:
    """A renderer of another package.

    Raises:
        UnknownNameError: There is none of this name.
        ExtensionError: It cannot be used.
    """
    part = RENDERERS.part(renderer)
    if part is None:
        raise ValueError(f"{renderer} is no other package's")
    return part, part.load(_no_renderer)


def _no_renderer(found: object) -> str | None:
    if isinstance(found, type) or not callable(getattr(found, "draw", None)):
        return "is no object with a method `draw`"
    ray = getattr(found, "ray_in_pixel", None)
    if not (isinstance(ray, tuple) and len(ray) == 2 and all(0.0 <= share <= 1.0 for share in ray)):
        return "has no `ray_in_pixel`, a pair of numbers from 0 to 1"
    return None


def _rasterised(shot: Shot) -> Drawing:
    from taskbuilder.raster import Lamp, PinholeCamera  # loads Numba
    from taskbuilder.sim.raster import raster_world

    view, light = shot.view, shot.light
    width, height = view.width, view.height
    focal = height / 2 / math.tan(math.radians(view.fov_deg) / 2)
    world = raster_world(shot.client)
    world.refresh()
    drawing = world.scene.draw(
        PinholeCamera(view.extrinsics[:3], focal, width, height, view.near, view.far),
        Lamp(light.direction, light.color, light.ambient, light.diffuse),
        backdrop=shot.behind,
        shadow=shot.shadow,
    )
    shapes = drawing.shapes
    bodies, links = (numbers.take(shapes, mode="wrap") for numbers in (world.bodies, world.links))
    return Drawing(drawing.rgb, drawing.depth, bodies, links)


def _by_bullet(shot: Shot) -> Drawing:
    bullet, view, light = shot.client.bullet, shot.view, shot.light
    width, height = view.width, view.height
    _, _, colors, buffer, mask = bullet.getCameraImage(
        width,
        height,
        viewMatrix=bullet.computeViewMatrix(view.eye, view.target, view.up),
        projectionMatrix=bullet.computeProjectionMatrixFOV(
            view.fov_deg, width / height, view.near, view.far
        ),
        flags=p.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
        shadow=int(shot.shadow),
        lightDirection=scale(unit(light.direction), light.distance),
        lightColor=light.color,
        lightDistance=light.distance,
        lightAmbientCoeff=light.ambient,
        lightDiffuseCoeff=light.diffuse,
        lightSpecularCoeff=light.specular,
    )
    # A pybullet built without numpy answers with flat lists.
    rgb = np.asarray(colors, dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
    mask = np.asarray(mask, dtype=np.int32).reshape(height, width)
    buffer = np.asarray(buffer, dtype=np.float32).reshape(height, width)
    nothing = mask < 0
    rgb = np.where(nothing[:, :, None], shot.behind[:, None], rgb)
    depth = np.where(nothing, np.float32(view.far), _metres(buffer, view))
    return Drawing(rgb, depth, *_decoded(mask))


def intrinsics(view: CameraView, renderer: Renderer) -> NDArray[np.float64]:
    """The (3, 3) matrix of the pictures that a renderer draws; see `Image`."""
    return _pinhole(view, *_ray_in_pixel(renderer))


def seen_points(
    depth: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    extrinsics: NDArray[np.float64],
    far: float,
) -> NDArray[np.float64]:
    """The world points of the pixels that show something, row by row: (n, 3), in metres.

    Args:
        depth: (height, width) metres along the camera's z; the far plane where nothing is.
        intrinsics: (3, 3) from the camera to pixels, times depth.
        extrinsics: (4, 4) from the world to the camera.
        far: The far plane, m.
    """
    rows, columns = np.nonzero(depth < np.float32(far))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    rays = pixels @ np.linalg.inv(intrinsics).T
    in_camera = rays * depth[rows, columns, None].astype(np.float64)
    found: NDArray[np.float64] = (in_camera - extrinsics[:3, 3]) @ extrinsics[:3, :3]
    return found


def point_cloud(image: Image, view: CameraView) -> NDArray[np.float32]:
    """A world point for every pixel, row by row: (height * width, 3) float32, in metres.

    A pixel that shows nothing has the point of the last pixel before it that shows something, or
    of the first one that does: all points lie on something. If there is none, all are the camera's
    position.

    Args:
        image: What a camera saw.
        view: The camera.
    """
    there = (image.depth < np.float32(view.far)).reshape(-1)
    if not there.any():
        return np.tile(np.array(view.eye, np.float32), (there.size, 1))
    points = seen_points(image.depth, image.intrinsics, view.extrinsics, view.far)
    last: NDArray[np.float32] = points.astype(np.float32)[np.maximum(np.cumsum(there) - 1, 0)]
    return last


def _check_size(width: int, height: int) -> None:
    if not (0 < width <= LARGEST_SIDE and 0 < height <= LARGEST_SIDE):
        raise SimulationError(
            f"a picture of {width} x {height} pixels cannot be drawn; each side must be from 1 "
            f"to {LARGEST_SIDE}, supersampling included"
        )


def _behind(backdrop: Backdrop | None, height: int) -> NDArray[np.uint8]:
    """(height, 3) colours from top to bottom; white without a backdrop."""
    if backdrop is None:
        return np.full((height, 3), 255, np.uint8)
    share = np.linspace(0.0, 1.0, height)[:, None]
    mixed = (1.0 - share) * np.array(backdrop.top) + share * np.array(backdrop.bottom)
    colors: NDArray[np.uint8] = mixed.astype(np.uint8)
    return colors


def _decoded(mask: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Body numbers and link indices from Bullet's mask, which packs both."""
    nothing = mask < 0
    bodies = np.where(nothing, NO_BODY, mask & 0xFFFFFF)
    links = np.where(nothing, NO_BODY, (mask >> 24) - 1)
    return bodies.astype(np.int32), links.astype(np.int32)


def _metres(buffer: NDArray[np.float32], view: CameraView) -> NDArray[np.float32]:
    """Distances along the camera's z from OpenGL's depth buffer, which holds their inverses."""
    near, far = view.near, view.far
    return (far * near / (far - (far - near) * buffer)).astype(np.float32)


def _pinhole(view: CameraView, across: float, down: float) -> NDArray[np.float64]:
    """The (3, 3) matrix for rays that pass pixels this far from their upper left corners."""
    focal = view.height / 2 / math.tan(math.radians(view.fov_deg) / 2)
    return np.array(
        [
            [focal, 0.0, view.width / 2 - across],
            [0.0, focal, view.height / 2 - down],
            [0.0, 0.0, 1.0],
        ]
    )
