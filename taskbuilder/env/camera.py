"""What explains the images of a camera: its matrices and planes, and the names in its masks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskbuilder.cameras import Image, seen_points
from taskbuilder.sim.pictures import intrinsics
from taskbuilder.world.world import World


@dataclass(frozen=True)
class Camera:
    """A camera of the scene as it is now, with the camera randomisation of the episode.

    The camera's frame is that of OpenCV: x to the right in the image, y down, and z along the
    optical axis into the scene. The pixel in column u and row v shows a world point X if
    ``intrinsics @ (extrinsics @ [X, 1])[:3]`` is proportional to ``[u, v, 1]``.

    Attributes:
        name: Its name in the scene.
        width: Width of its images in pixels.
        height: Height of its images in pixels.
        intrinsics: (3, 3) float64: from camera coordinates in metres to pixels times depth.
        extrinsics: (4, 4) float64: from world coordinates to camera coordinates, in metres.
        near: Distance of the near plane in metres.
        far: Distance of the far plane in metres, which is also the depth where nothing is.
    """

    name: str
    width: int
    height: int
    intrinsics: NDArray[np.float64]
    extrinsics: NDArray[np.float64]
    near: float
    far: float

    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """The world points that a depth image of this camera shows, without the background.

        Args:
            depth: (height, width), in metres along the optical axis.

        Returns:
            (n, 3), in metres: one point for each pixel that shows something, row by row.
        """
        return seen_points(depth, self.intrinsics, self.extrinsics, self.far)


def camera_of(world: World, name: str, size: tuple[int, int]) -> Camera:
    """A camera of a world as it stands.

    Args:
        world: The world.
        name: The camera's name.
        size: Width and height of its images in pixels.
    """
    view = world.camera(name, size)
    lens = intrinsics(view, world.client.renderer)
    return Camera(name, *size, lens, view.extrinsics, view.near, view.far)


def with_noise(image: Image, std: float, rng: np.random.Generator) -> Image:
    """An image with Gaussian noise on every value of its colours.

    Args:
        image: The image.
        std: Standard deviation, as a fraction of the full range.
        rng: Random numbers.
    """
    noise = rng.normal(0.0, 255.0 * std, image.rgb.shape)
    noisy = np.clip(np.rint(image.rgb + noise), 0, 255).astype(np.uint8)
    return replace(image, rgb=noisy)
