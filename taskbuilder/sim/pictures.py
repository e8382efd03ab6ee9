"""Pictures of a client's world: colour, depth and segmentation, by any of its renderers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.cameras import (
    BACKGROUND,
    DAYLIGHT,
    Backdrop,
    CameraView,
    Image,
    Light,
    check_size,
    pinhole,
)
from taskbuilder.errors import SimulationError
from taskbuilder.extensions import RENDERERS, ForeignPart
from taskbuilder.geometry import scale, unit
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.renderers import Renderer

if TYPE_CHECKING:  # loads Numba
    from taskbuilder import raster
    from taskbuilder.sim.raster import RasterWorld

NO_BODY = -1

# Where in a pixel its ray passes, from the left and from the top. Bullet's own renderer takes
# the lower left corner; OpenGL the centre.
_RAY_IN_PIXEL = {"raster": (0.5, 0.5), "tiny": (0.0, 1.0), "egl": (0.5, 0.5)}


class Segments:
    """The numbers and names in segmentation masks; number 0 is the background.

    Args:
        parts: Name, Bullet's number of the body, and index of the link of all that has a name.
            What has none counts as background.

    Attributes:
        names: The name of each number.
        parts: As they were given.
    """

    def __init__(self, parts: Sequence[tuple[str, int, int]] = ()) -> None:
        self.parts = tuple(parts)
        self.names = (BACKGROUND, *(name for name, _, _ in parts))
        bodies = max((body for _, body, _ in parts), default=NO_BODY)
        links = max((link for _, _, link in parts), default=-1)
        # Row -1 is the last: that of the background.
        self._numbers = np.zeros((bodies + 2, links + 2), np.int16)
        for number, (_, body, link) in enumerate(parts, start=1):
            self._numbers[body, link + 1] = number

    def of(self, bodies: NDArray[np.int32], links: NDArray[np.int32]) -> NDArray[np.int16]:
        """The numbers of links, from Bullet's numbers of their bodies and their indices."""
        rows, columns = self._numbers.shape
        known = (bodies < rows - 1) & (links < columns - 1)
        numbers: NDArray[np.int16] = self._numbers[
            np.where(known, bodies, NO_BODY), np.where(known, links + 1, 0)
        ]
        return numbers


UNNAMED = Segments()
"""Everything counts as background."""


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


class RenderedShot(NamedTuple):
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

    def draw(self, shot: Shot) -> RenderedShot:
        """Draw a picture."""
        ...


def capture(
    client: Client,
    view: CameraView,
    segments: Segments = UNNAMED,
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
        segments: The numbers and names in the mask; without them, it is 0 everywhere.
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
    check_size(width, height)
    larger = replace(view, width=width, height=height)
    shot = Shot(client, larger, light, _behind(backdrop, height), shadow)
    rgb, depth, mask = _taken(shot, segments)
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
        mask=mask[chosen],
        names=segments.names,
        intrinsics=pinhole(view, (column + across) / supersample, (row + down) / supersample),
    )


def _taken(
    shot: Shot, segments: Segments
) -> tuple[NDArray[np.uint8], NDArray[np.float32], NDArray[np.int16]]:
    """Colours, depths in metres, and the mask."""
    if shot.client.renderer == "raster":  # names its shapes once, and not each pixel
        world, drawing = _raster_drawing(shot)
        numbers = segments.of(world.bodies, world.links)
        return drawing.rgb, drawing.depth, numbers.take(drawing.shapes, mode="wrap")
    rgb, depth, bodies, links = draw_with(shot.client.renderer, shot)
    return rgb, depth, segments.of(bodies, links)


def draw_with(renderer: str, shot: Shot) -> RenderedShot:
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
        drawing = RenderedShot(*foreign.draw(shot))
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


def _foreign(renderer: str) -> tuple[ForeignPart, ForeignRenderer]:
    """A renderer of another package.

    Raises:
        UnknownNameError: There is none of this name.
        ExtensionError: It cannot be used.
    """
    part = RENDERERS.part(renderer)
    if part is None:
        raise ValueError(f"{renderer} is no other package's")
    return part, load_renderer(part)


def load_renderer(part: ForeignPart) -> ForeignRenderer:
    """The renderer that another package adds.

    Raises:
        ExtensionError: It cannot be used.
    """
    renderer: ForeignRenderer = part.load(_no_renderer)
    return renderer


def _no_renderer(found: object) -> str | None:
    if isinstance(found, type) or not callable(getattr(found, "draw", None)):
        return "is no object with a method `draw`"
    ray = getattr(found, "ray_in_pixel", None)
    if not (isinstance(ray, tuple) and len(ray) == 2 and all(0.0 <= share <= 1.0 for share in ray)):
        return "has no `ray_in_pixel`, a pair of numbers from 0 to 1"
    return None


def _rasterised(shot: Shot) -> RenderedShot:
    world, drawing = _raster_drawing(shot)
    shapes = drawing.shapes
    bodies, links = (numbers.take(shapes, mode="wrap") for numbers in (world.bodies, world.links))
    return RenderedShot(drawing.rgb, drawing.depth, bodies, links)


def _raster_drawing(shot: Shot) -> tuple[RasterWorld, raster.Drawing]:
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
    return world, drawing


def _by_bullet(shot: Shot) -> RenderedShot:
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
    return RenderedShot(rgb, depth, *_decoded(mask))


def intrinsics(view: CameraView, renderer: Renderer) -> NDArray[np.float64]:
    """The (3, 3) matrix of the pictures that a renderer draws; see `Image`."""
    return pinhole(view, *_ray_in_pixel(renderer))


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
