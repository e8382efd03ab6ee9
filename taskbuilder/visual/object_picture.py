"""A picture of an object of the catalogue, alone: how it looks, and by what it collides."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from taskbuilder.assets.model import Urdf
from taskbuilder.assets.urdf import resolved_text
from taskbuilder.cameras import STUDIO, CameraView
from taskbuilder.geometry import Box, add, norm, scale
from taskbuilder.quiet import captured
from taskbuilder.schema.object_files import ObjectModel, as_placed
from taskbuilder.shapes import MeshShape, Part
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.engine_output import warnings
from taskbuilder.sim.pictures import capture
from taskbuilder.sim.probe import probe
from taskbuilder.visual.still import Pixels
from taskbuilder.world.shapes import parts_of
from taskbuilder.world.weights import mass_of, weighed

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
            body = built(client, model, Path(folder))
        picture = _take_picture(client, body.occupied())
        return picture, body.mass, warnings(printed.text)


def built(client: Client, model: ObjectModel, folder: Path) -> Body:
    """An object in the engine, with its frame at the origin.

    Args:
        client: The engine.
        model: The object. Files of others are loaded in a child process first.
        folder: A folder for a copy of its URDF.

    Raises:
        AssetError: The engine dies of the asset, or refuses it.
    """
    spec = as_placed(model.spec)
    asset = model.assets.main
    if isinstance(asset, Urdf):
        copy = folder / asset.path.name
        size = (spec.shape.scale if spec.shape else None) or 1.0
        copy.write_text(resolved_text(weighed(asset, spec, size)), encoding="utf-8")
        if not model.entry.trusted:
            probe(copy, kind="urdf")
        body = load_urdf(client, copy, name=spec.object, fixed_base=False, scale=size)
        for joint in asset.moving_joints:
            begin = spec.joint(joint.name, turns=joint.type != "prismatic").begin or 0.0
            body.put_joints({joint.name: begin})
        return body
    parts = parts_of(spec, asset, model.assets.collision)
    for path in () if model.entry.trusted else _meshes(parts):
        probe(path, kind="mesh")
    return create_body(client, parts, name=spec.object, mass=mass_of(spec, parts))


def _meshes(parts: Mapping[str, Part]) -> Iterator[Path]:
    for part in parts.values():
        for shape in (part.shape, part.look):
            if isinstance(shape, MeshShape):
                yield shape.path


def _take_picture(client: Client, extent: Box) -> Pixels:
    distance = max(2.9 * norm(extent.half), 0.05)
    eye = add(extent.center, scale(_FROM, distance))
    view = CameraView(
        eye, extent.center, fov_deg=42, width=_SIZE[0], height=_SIZE[1], far=20 + 2 * distance
    )
    return capture(client, view, supersample=2, shadow=True, backdrop=STUDIO).rgb
