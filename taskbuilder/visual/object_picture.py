"""A picture of an object of the catalogue, alone: how it looks, and by what it collides."""

from __future__ import annotations

import tempfile
from pathlib import Path

from taskbuilder.cameras import STUDIO, CameraView
from taskbuilder.geometry import Box, add, norm, scale
from taskbuilder.quiet import captured
from taskbuilder.schema.object_files import ObjectModel
from taskbuilder.sim.client import Client
from taskbuilder.sim.engine_output import warnings
from taskbuilder.sim.pictures import capture
from taskbuilder.visual.still import Pixels
from taskbuilder.world.lone_object import lone_object

_FROM = (0.5, -0.75, 0.5)
_SIZE = (480, 480)


def take_object_picture(model: ObjectModel) -> tuple[Pixels, float, tuple[str, ...]]:
    """Load an object, and take its picture.

    Args:
        model: The object.

    Returns:
        The picture, (480, 480, 3) uint8 RGB; the mass of the object, kg; and what the engine warned
        of.

    Raises:
        AssetError: The engine dies of the asset, or refuses it.
        SimulationError: The asset cannot be loaded.
    """
    with (
        tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder,
        Client(physics_hz=120) as client,
    ):
        with captured() as printed:
            body = lone_object(client, model, Path(folder))
        picture = _take_picture(client, body.occupied())
        return picture, body.mass, warnings(printed.text)


def _take_picture(client: Client, extent: Box) -> Pixels:
    distance = max(2.9 * norm(extent.half), 0.05)
    eye = add(extent.center, scale(_FROM, distance))
    view = CameraView(
        eye, extent.center, fov_deg=42, width=_SIZE[0], height=_SIZE[1], far=20 + 2 * distance
    )
    return capture(client, view, supersample=2, shadow=True, backdrop=STUDIO).rgb
