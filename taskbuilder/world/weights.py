"""Masses and inertias that follow from shapes of uniform density."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import Urdf, UrdfLink, UrdfShape
from taskbuilder.geometry import Pose, total
from taskbuilder.schema.bodies import BodySpec
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.shapes import Part, solid
from taskbuilder.world.shapes import urdf_shape

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes of ``<inertia>``: the upper triangle of the tensor, row by row."""


@dataclass(frozen=True)
class Uniform:
    """Shapes of one rigid body, all of the same density.

    Attributes:
        volume: In m³; overlaps count twice.
        center: (3,) centre of mass in the frame of the body, m.
        tensor: (3, 3) inertia about it for a mass of 1 kg, along the axes of the body, m².
    """

    volume: float
    center: NDArray[np.float64]
    tensor: NDArray[np.float64]


def uniform(shapes: Sequence[UrdfShape]) -> Uniform:
    """The mass properties of the shapes of a link, in the frame of the link."""
    solids = [(shape.pose, solid(urdf_shape(shape))) for shape in shapes]
    volumes = np.array([piece.volume for _, piece in solids])
    frames = [pose @ piece.principal for pose, piece in solids]
    offsets = np.array([frame.position for frame in frames])
    center = volumes @ offsets / volumes.sum()
    offsets -= center
    tensor = np.zeros((3, 3))
    for (_, piece), frame, offset in zip(solids, frames, offsets, strict=True):
        own = turned(np.diag(piece.inertia), frame)
        steiner = offset @ offset * np.eye(3) - np.outer(offset, offset)
        tensor += piece.volume * (own + steiner)
    return Uniform(float(volumes.sum()), center, np.asarray(tensor / volumes.sum()))


def turned(tensor: NDArray[np.float64], frame: Pose) -> NDArray[np.float64]:
    """A tensor of a frame, along the axes of the frame that it is expressed in."""
    axes = np.array([frame.axis(index) for index in range(3)]).T
    result: NDArray[np.float64] = axes @ tensor @ axes.T
    return result


def mass_of(spec: ObjectSpec, parts: Mapping[str, Part]) -> float:
    """The mass of an object that is made of parts, in kg; 0 for one that is fixed."""
    if spec.fixed:
        return 0.0
    if spec.density is not None:
        return spec.density * total(solid(part.shape).volume for part in parts.values())
    return spec.mass or 0.0


def weighed(urdf: Urdf, spec: BodySpec, size: float) -> Urdf:
    """A URDF with the masses and inertias that the description of an object asks for.

    Args:
        urdf: What was read.
        spec: What is said of the object's ``mass``, ``density`` and ``inertia``.
        size: Factor of all lengths, by which the URDF will be loaded.
    """
    if spec.mass is None and spec.density is None and spec.inertia is None:
        return urdf
    shapes = {link.name: link.collisions or link.visuals for link in urdf.links}
    even = {name: uniform(found) for name, found in shapes.items() if found}
    masses = _masses(urdf, spec, {name: each.volume for name, each in even.items()}, size)
    own = {link.name: link for link in urdf.links}
    from_shape = {
        name: even[name]
        for name in masses
        if name in even and (spec.inertia or spec.density or not own[name].mass)
    }
    links = tuple(replace(link, mass=masses.get(link.name, link.mass)) for link in urdf.links)
    children = tuple(
        _reweighed(child, own[name], masses[name], from_shape.get(name))
        if child.tag == "link" and (name := child.attributes["name"]) in masses
        else child
        for child in urdf.tree.children
    )
    return replace(urdf, links=links, tree=urdf.tree.with_children(children))


def _masses(
    urdf: Urdf, spec: BodySpec, volumes: Mapping[str, float], size: float
) -> dict[str, float]:
    """The mass of each link as the URDF has it before it is scaled, kg."""
    if spec.density is not None:
        return {name: spec.density * volume for name, volume in volumes.items()}
    stated = {link.name: link.mass for link in urdf.links if link.mass}
    if spec.mass is None:
        return stated
    shares = stated if volumes.keys() <= stated.keys() else dict(volumes)
    unit = spec.mass / size**3 / total(shares.values())
    return {name: share * unit for name, share in shares.items()}


def _reweighed(link: Element, was: UrdfLink, mass: float, even: Uniform | None) -> Element:
    """A link's element with another mass, and with the inertia that goes with it."""
    inertial = link.first("inertial")
    if even is not None:
        attributes = _entries(even.tensor * mass)
        origin = {"xyz": " ".join(map(repr, map(float, even.center))), "rpy": "0 0 0"}
    elif inertial is not None and was.mass:
        told = inertial.first("inertia")
        given = told.attributes if told else {}
        ratio = mass / was.mass
        attributes = {key: repr(float(given.get(key) or 0.0) * ratio) for key in ENTRIES}
        found = inertial.first("origin")
        origin = dict(found.attributes) if found else {"xyz": "0 0 0"}
    else:
        return link
    at = (link.line, link.column)
    new = Element(
        "inertial",
        {},
        *at,
        (
            Element("origin", origin, *at),
            Element("mass", {"value": repr(mass)}, *at),
            Element("inertia", attributes, *at),
        ),
    )
    others = tuple(child for child in link.children if child.tag != "inertial")
    return link.with_children((new, *others))


def _entries(tensor: NDArray[np.float64]) -> dict[str, str]:
    rows, columns = np.triu_indices(3)
    values = tensor[rows, columns].tolist()
    return {key: repr(value) for key, value in zip(ENTRIES, values, strict=True)}
