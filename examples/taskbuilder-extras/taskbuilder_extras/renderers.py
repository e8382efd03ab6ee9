"""A renderer: every body in a flat colour of its own, on white."""

from __future__ import annotations

import numpy as np

from taskbuilder.sim.pictures import RenderedShot, Shot, draw_with

COLOURS = np.array(
    [[31, 119, 180], [255, 127, 14], [44, 160, 44], [214, 39, 40], [148, 103, 189], [140, 86, 75]],
    dtype=np.uint8,
)


class Silhouettes:
    """Lets PyBullet find what each pixel shows, and paints it by the number of the body.

    Attributes:
        ray_in_pixel: That of PyBullet's TinyRenderer: the lower left corner.
    """

    ray_in_pixel = (0.0, 1.0)

    def draw(self, shot: Shot) -> RenderedShot:
        """Draw a picture."""
        drawing = draw_with("tiny", shot)
        painted = COLOURS[drawing.bodies % len(COLOURS)]
        white = np.full_like(painted, 255)
        rgb = np.where(drawing.bodies[..., None] < 0, white, painted)
        return drawing._replace(rgb=rgb)


SILHOUETTES = Silhouettes()
