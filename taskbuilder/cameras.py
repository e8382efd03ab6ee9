"""Camera models: where a camera is, what its pictures hold, and which points these show.

The camera's frame is that of computer vision: x to the right, y down, z into the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Pose, Vec3, cross, from_axes, norm, subtract, unit

BACKGROUND = "background"
"""The name of number 0 in masks: where nothing is."""

LARGEST_SIDE = 4096
"""Most pixels of a picture's side: some renderers end the process when it is too large."""


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
        check_size(self.width, self.height)
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
        mask: (height, width) int16, the number of what each pixel shows; 0 where nothing is.
        names: The name of each number in the mask, such as ``left.wrist_3_link`` or ``tray.rim``.
        intrinsics: (3, 3) matrix that takes camera coordinates (x right, y down, z forward) to
            pixel indices (column, row) times depth. It is that of depth and mask; rgb averages
            over each pixel's area.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    mask: NDArray[np.int16]
    names: tuple[str, ...]
    intrinsics: NDArray[np.float64]

    def shows(self, *things: str) -> NDArray[np.bool_]:
        """(height, width) where any of these is seen: robots, objects, sites, or links of them."""
        wanted = [{name, name.partition(".")[0]} & {*things} for name in self.names]
        seen: NDArray[np.bool_] = np.array([bool(one) for one in wanted])[self.mask]
        return seen


def pinhole(view: CameraView, across: float, down: float) -> NDArray[np.float64]:
    """The (3, 3) matrix for rays that pass pixels this far from their upper left corners."""
    focal = view.height / 2 / math.tan(math.radians(view.fov_deg) / 2)
    return np.array(
        [
            [focal, 0.0, view.width / 2 - across],
            [0.0, focal, view.height / 2 - down],
            [0.0, 0.0, 1.0],
        ]
    )


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


def check_size(width: int, height: int) -> None:
    """Refuse a picture that cannot be drawn.

    Raises:
        SimulationError: A side has no pixels, or too many.
    """
    if not (0 < width <= LARGEST_SIDE and 0 < height <= LARGEST_SIDE):
        raise SimulationError(
            f"a picture of {width} x {height} pixels cannot be drawn; each side must be from 1 "
            f"to {LARGEST_SIDE}, supersampling included"
        )
