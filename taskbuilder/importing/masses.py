"""Masses and inertias that a source leaves out, or that are placeholders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from taskbuilder.geometry import Pose
from taskbuilder.importing.changes import Changes
from taskbuilder.importing.description import ImportedBody, Inertial, Link
from taskbuilder.importing.fitting import hull_of
from taskbuilder.importing.geometry import Geometry, link_parts
from taskbuilder.importing.surfaces import Floats, Part, is_closed, volume

DENSITY = 1000.0
"""Of links without a mass, in kg/m³; between plastic and a geared motor."""
FAR_FACTOR = 20.0
"""As `world.inertias` has it: moments that are off by more are placeholders."""
_LIGHTEST_KG, _LEAST_MOMENT = 1e-3, 1e-9
_SHARED_TRIANGLE = 1e-3


def with_masses(
    description: ImportedBody,
    geometry: Geometry,
    changes: Changes,
    *,
    mass: float | None = None,
    density: float | None = None,
) -> ImportedBody:
    """The description with a mass and possible moments for every link that needs them.

    Args:
        description: With its meshes converted.
        geometry: What its links look like.
        changes: Where changes are noted.
        mass: Of all links together, in kg, in place of what the source says.
        density: In kg/m³, in place of what the source says.
    """
    moved = {joint.child for joint in description.joints if joint.moves}
    links: dict[str, Link] = {}
    parts = {link.name: link_parts(geometry, link.name) for link in description.links}
    whole = sum(_solid(each)[0] for each in parts.values())
    if mass is not None and whole > 0.0:
        density = mass / whole
    for link in description.links:
        needed = link.name in moved or bool(link.collisions)
        found = _inertial(link, parts[link.name], changes, density, needed=needed)
        links[link.name] = replace(link, inertial=found)
    return description.with_links(links)


def _inertial(
    link: Link, parts: Sequence[Part], changes: Changes, density: float | None, *, needed: bool
) -> Inertial | None:
    subject, stated = f"link {link.name}", link.inertial
    size, center, tensor = _solid(parts)
    if density is not None and size > 0.0 and (needed or stated):
        mass = max(density * size, _LIGHTEST_KG)
        changes.note(
            subject, "mass", _kg(stated), f"{mass:.4g} kg", f"{density:.4g} kg/m³ as asked"
        )
        return _uniform(mass, center, tensor)
    if stated is None or stated.mass <= 0.0:
        if not needed:
            return None
        mass = max(DENSITY * size, _LIGHTEST_KG)
        changes.note(
            subject, "mass", _kg(stated), f"{mass:.4g} kg",
            f"from its shape with {DENSITY:g} kg/m³" if size else "it has no shape",
        )  # fmt: skip
        return _uniform(mass, center, tensor)
    moments = stated.moments
    wrong = _wrong(moments, tensor * stated.mass, size > 0.0)
    if not wrong:
        return stated
    made = _uniform(stated.mass, center if size > 0.0 else np.array(stated.pose.position), tensor)
    changes.note(
        subject, "inertia", _shown(moments), _shown(made.moments), f"{wrong}; from its shape"
    )
    return made


def _wrong(moments: tuple[float, ...] | None, uniform: Floats, known: bool) -> str:
    """What is wrong with stated moments, or ""."""
    if moments is None:
        return "none are given"
    stated = np.linalg.eigvalsh(_matrix(moments))
    if stated[0] <= 0.0:
        return "a principal moment is not above 0"
    if stated[0] + stated[1] < stated[2] * (1.0 - _SHARED_TRIANGLE):
        return "no body has them: one exceeds the sum of the others"
    if not known:
        return ""
    factors = stated / np.maximum(np.linalg.eigvalsh(uniform), 1e-15)
    far = max(float(factors.max()), 1.0 / max(float(factors.min()), 1e-15))
    alike = float(np.ptp(stated)) <= 1e-9 * float(stated[2])
    if far > FAR_FACTOR * (1.0 if alike else 5.0):
        return f"{far:.0f} times off"
    return ""


def _uniform(mass: float, center: Floats, tensor: Floats) -> Inertial:
    """A mass spread evenly; a small ball where nothing is known of the shape."""
    matrix = tensor * mass if tensor.any() else np.eye(3) * mass * 0.02**2 * 0.4
    floor = max(_LEAST_MOMENT, 1e-6 * mass)
    values, axes = np.linalg.eigh(matrix)
    matrix = (axes * np.maximum(values, floor)) @ axes.T
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix.tolist()
    moments = tuple(_rounded(value) for value in (xx, xy, xz, yy, yz, zz))
    x, y, z = (_rounded(value) for value in center.tolist())
    return Inertial(_rounded(mass), Pose((x, y, z)), moments)


def _rounded(value: float) -> float:
    return float(f"{value:.6g}") if abs(value) > 1e-12 else 0.0


def _solid(parts: Sequence[Part]) -> tuple[float, Floats, Floats]:
    """Volume, centre, and moments about it per kg, of parts that do not overlap."""
    sizes, centers, seconds = [], [], []
    for points, faces in parts:
        if not (is_closed(faces) and volume(points, faces) > 0.0):
            points, faces = hull_of(points)
        a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
        sixths = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
        size = float(sixths.sum())
        if size <= 0.0:
            continue
        corners = np.stack([a, b, c], axis=1)
        total = corners.sum(axis=1)
        centers.append((sixths[:, None] * total).sum(axis=0) / 4.0 / size)
        second = np.einsum("n,nki,nkj->ij", sixths, corners, corners) / 20.0
        second += np.einsum("n,ni,nj->ij", sixths, total, total) / 20.0
        sizes.append(size)
        seconds.append(second)
    whole = sum(sizes)
    if whole <= 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    center = (
        sum((size * middle for size, middle in zip(sizes, centers, strict=True)), np.zeros(3))
        / whole
    )
    second = sum(seconds, np.zeros((3, 3))) / whole - np.outer(center, center)
    return whole, center, np.trace(second) * np.eye(3) - second


def _matrix(moments: tuple[float, ...]) -> Floats:
    xx, xy, xz, yy, yz, zz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _kg(inertial: Inertial | None) -> str:
    return "none" if inertial is None else f"{inertial.mass:.4g} kg"


def _shown(moments: tuple[float, ...] | None) -> str:
    if moments is None:
        return "none"
    return " ".join(f"{moments[n]:.3g}" for n in (0, 3, 5))
