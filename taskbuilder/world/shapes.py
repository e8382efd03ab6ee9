"""From the shapes of task files and URDFs to those of the simulation."""

from __future__ import annotations

import math
from dataclasses import replace

from taskbuilder.assets.mesh import Mesh
from taskbuilder.assets.model import Urdf, UrdfShape
from taskbuilder.geometry import Box, Pose, Vec3, bounding_box, scale
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.shapes import PartSpec
from taskbuilder.schema.shapes import Shape as ShapeSpec
from taskbuilder.schema.sites import Marker
from taskbuilder.schema.values import rgb
from taskbuilder.shapes import (
    RGBA,
    BoxShape,
    CapsuleShape,
    CylinderShape,
    MeshShape,
    Part,
    Shape,
    SphereShape,
    bounds,
    placed_bounds,
)
from taskbuilder.sim.mesh_colors import WHITE, has_colors


def parts_of(
    spec: ObjectSpec, asset: Mesh | Urdf | None, collision: Mesh | None = None
) -> dict[str, Part]:
    """The named parts of an object that is not a URDF; a single shape is a part too.

    Args:
        spec: What is said of it.
        asset: Its mesh, if it has one.
        collision: The mesh by which it collides, if that is another one.
    """
    color: RGBA = (*rgb(spec.color), 1.0)
    if spec.parts is not None:
        return {
            name: Part(shape_of(part), part.pose, (*rgb(part.color), 1.0) if part.color else color)
            for name, part in spec.parts.items()
        }
    if isinstance(asset, Mesh):
        size = (spec.shape.scale if spec.shape else None) or 1.0
        if "color" not in spec.model_fields_set and has_colors(asset):
            color = (*WHITE, 1.0)  # it has colours of its own
        look = MeshShape(asset.path, (size, size, size))
        path = collision.path if collision else asset.path
        shape = replace(look, path=path, collide=spec.shape.collide if spec.shape else None)
        return {"mesh": Part(shape, Pose(), color, look if collision else None)}
    if spec.shape is None:
        raise ValueError("an object has a shape or parts")
    return {spec.shape.kind: Part(shape_of(spec.shape), Pose(), color)}


def shape_of(spec: ShapeSpec | PartSpec | Marker) -> Shape:
    """A primitive as the simulation knows it."""
    if spec.box is not None:
        return BoxShape(spec.box)
    if spec.sphere is not None:
        return SphereShape(spec.sphere)
    if spec.cylinder is not None:
        return CylinderShape(spec.cylinder.radius, spec.cylinder.length)
    if not isinstance(spec, Marker) and spec.capsule is not None:
        return CapsuleShape(spec.capsule.radius, spec.capsule.length)
    raise ValueError(f"{spec} is no primitive")


def link_box(shapes: tuple[UrdfShape, ...], size: float) -> Box:
    """Bounding box of a link's collision shapes in the link's frame."""
    corners: list[Vec3] = [(0.0, 0.0, 0.0)] if not shapes else []
    for shape in shapes:
        box = placed_bounds(urdf_shape(shape), shape.pose)
        corners += [box.low, box.high]
    box = bounding_box(corners)
    return Box(
        (box.center[0] * size, box.center[1] * size, box.center[2] * size),
        (box.half[0] * size, box.half[1] * size, box.half[2] * size),
    )


def distance_from(shapes: tuple[UrdfShape, ...], size: float, point: Vec3) -> float:
    """How far a point in a link's frame is from its collision shapes, taken for boxes, in metres.

    It is infinite where there are none.
    """
    unscaled = scale(point, 1.0 / size)
    gaps = []
    for shape in shapes:
        box = bounds(urdf_shape(shape))
        seen = shape.pose.inverse().apply(unscaled)
        out = [max(abs(seen[i] - box.center[i]) - box.half[i], 0.0) for i in range(3)]
        gaps.append(math.hypot(*out) * size)
    return min(gaps, default=math.inf)


def urdf_shape(shape: UrdfShape) -> Shape:
    """A shape of a URDF as the simulation knows it, without its pose in the link."""
    size = shape.size
    if shape.kind == "box":
        return BoxShape((size[0], size[1], size[2]))
    if shape.kind == "sphere":
        return SphereShape(size[0])
    if shape.kind == "cylinder":
        return CylinderShape(size[0], size[1])
    if shape.kind == "capsule":
        return CapsuleShape(size[0], size[1])
    if shape.mesh is None:
        raise ValueError(f"{shape} has no mesh")
    return MeshShape(shape.mesh, (size[0], size[1], size[2]))
