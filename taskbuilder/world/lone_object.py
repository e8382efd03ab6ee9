"""An object of the catalogue, alone in the engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from taskbuilder.assets.model import Urdf
from taskbuilder.assets.urdf import resolved_text
from taskbuilder.schema.object_files import ObjectModel, as_placed
from taskbuilder.shapes import MeshShape, Part
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.probe import probe
from taskbuilder.world.shapes import parts_of
from taskbuilder.world.weights import mass_of, weighed


def lone_object(client: Client, model: ObjectModel, folder: Path) -> Body:
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
