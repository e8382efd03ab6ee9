"""Collision shapes for a mesh: a box or cylinder where one fits, the hull, or convex pieces.

Which of them is used is measured: points on the surface of a candidate may be only so far from the
surface of the mesh.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from taskbuilder.geometry import Pose, Vec3, from_axes
from taskbuilder.hulls import hull_triangles
from taskbuilder.importing.pieces import MOST_PIECES, decomposed
from taskbuilder.importing.surfaces import (
    Floats,
    Integers,
    Part,
    components,
    distances,
    is_closed,
    same_rows,
    sampled,
)

Choice = Literal["auto", "pieces", "hull", "boxes", "exact"]
CHOICES: tuple[Choice, ...] = ("auto", "pieces", "hull", "boxes", "exact")

_SAMPLES = 3000
_CANDIDATE_SAMPLES = 700
_SHARE = 0.95
"""The error of a candidate is the distance that so many of its points keep."""
FINE_M, FINE_SHARE = 0.002, 0.04
"""A box or cylinder may be so far off: metres, or a share of the diagonal if that is more."""
THINNEST_M = 1e-3
"""What is flat, such as a sheet of triangles, collides as if it were so thick."""
COARSE_M, COARSE_SHARE = 0.003, 0.04
"""A hull may be so far off before it is cut into pieces."""
_HULL_POINTS = 96
_FEW_PARTS = 4


@dataclass(frozen=True, eq=False)
class Fit:
    """A collision shape for a mesh.

    Attributes:
        kind: ``box``, ``cylinder``, ``sphere``, or ``mesh``.
        size: As in a URDF, in metres; for a mesh unused.
        pose: The shape in the frame of the mesh.
        parts: Convex parts, for a mesh.
        error_m: How far its surface is from that of the mesh.
        tried: Name -> error of all that was measured, in metres.
        uncut: Whether it should have been cut into pieces, and could not be.
    """

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    pose: Pose
    parts: tuple[Part, ...]
    error_m: float
    tried: dict[str, float]
    uncut: bool = False

    @property
    def words(self) -> str:
        """What it is, for a table."""
        if self.kind != "mesh":
            return self.kind
        if self.uncut:
            return "hull, a lid on what is hollow: it could not be cut into pieces"
        return "hull" if len(self.parts) == 1 else f"{len(self.parts)} convex pieces"


def fit(points: Floats, faces: Integers, choice: Choice = "auto", slack: float = 1.0) -> Fit:
    """The collision shape of a mesh.

    Args:
        points: (n, 3), in metres, each there once.
        faces: (m, 3).
        choice: ``auto`` measures; ``pieces`` and ``hull`` do not; ``boxes`` takes the better of
            box, cylinder and sphere; ``exact`` keeps the triangles.
        slack: A hull may be so many times as far off as usual before it is cut into pieces.

    Raises:
        UsageError: The extra is not installed.
    """
    surface = sampled(points, faces, _SAMPLES)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    noise = math.sqrt(_area(points, faces) / _SAMPLES) * 0.6
    if choice == "exact":
        return Fit("mesh", (), Pose(), ((points, faces),), 0.0, {})
    solids = [
        Fit(kind, size, pose, (), _error(samples, surface, noise), {})
        for kind, size, pose, samples in _primitives(points)
    ]
    hull = hull_of(points)
    tried: dict[str, float] = {}
    for one in solids:
        tried[one.kind] = min(one.error_m, tried.get(one.kind, math.inf))
    tried["hull"] = _error(sampled(*hull, _CANDIDATE_SAMPLES), surface, noise)
    hulled = Fit("mesh", (), Pose(), (hull,), tried["hull"], tried)
    best = min(solids, key=lambda one: one.error_m)
    best = Fit(best.kind, best.size, best.pose, (), best.error_m, tried)
    if choice == "boxes":
        return best
    if choice == "hull":
        return hulled
    if choice == "auto":
        if best.error_m <= max(FINE_M, FINE_SHARE * diagonal):
            return best
        if slack == math.inf or hulled.error_m <= slack * max(COARSE_M, COARSE_SHARE * diagonal):
            return hulled
    parts = convex_pieces(points, faces)
    if not parts:
        return replace(hulled, uncut=True)
    corners = [sampled(*part, max(60, 2 * _CANDIDATE_SAMPLES // len(parts))) for part in parts]
    error = _error(_outer(corners, parts), surface, noise)
    tried = {**tried, "pieces": error}
    if len(parts) == 1 or (choice == "auto" and error >= hulled.error_m):
        return Fit("mesh", (), Pose(), (hull,), hulled.error_m, tried)
    return Fit("mesh", (), Pose(), parts, error, tried)


def convex_pieces(points: Floats, faces: Integers) -> tuple[Part, ...]:
    """Convex pieces of a mesh: the hulls of its parts that touch nowhere, or what CoACD cuts."""
    labels = components(faces)
    count = int(labels.max()) + 1
    if 1 < count <= MOST_PIECES:
        groups = [points[np.unique(faces[labels == number])] for number in range(count)]
        hulls = [hull_of(group) for group in groups if len(group) > 3]
        noise = math.sqrt(_area(points, faces) / _SAMPLES) * 0.6
        surface = sampled(points, faces, _SAMPLES)
        error = max(
            (_error(sampled(*hull, 200), surface, noise) for hull in hulls), default=math.inf
        )
        if error <= COARSE_M:
            return tuple(hulls)
    parts: list[Part] = []
    if 1 < count <= _FEW_PARTS:  # such as a mug and the handle that is stuck into it
        parts = _cut_apart(points, faces, labels)
    if not parts:
        parts = [hull_of(corners) for corners in decomposed(points, faces)]
    return tuple(sorted(parts, key=lambda part: tuple(part[0].mean(axis=0).round(6).tolist())))


def _cut_apart(points: Floats, faces: Integers, labels: Integers) -> list[Part]:
    """Convex pieces of each part of a mesh; none if a part is open or cannot be cut.

    Parts that reach into each other are hard to cut together.
    """
    pieces: list[Part] = []
    for number in range(int(labels.max()) + 1):
        used, own = np.unique(faces[labels == number], return_inverse=True)
        part = points[used], np.asarray(own, np.int64).reshape(-1, 3)
        if not is_closed(part[1]):
            return []
        hull = hull_of(part[0])
        noise = math.sqrt(_area(*part) / _SAMPLES) * 0.6
        if _error(sampled(*hull, 200), sampled(*part, _SAMPLES), noise) <= COARSE_M:
            pieces.append(hull)
            continue
        cut = [hull_of(corners) for corners in decomposed(*part)]
        if not cut:
            return []
        pieces += cut
    return pieces if len(pieces) <= 2 * MOST_PIECES else []


def hull_of(points: Floats, most: int = _HULL_POINTS) -> Part:
    """The convex hull of points, with at most so many corners, facing outwards."""
    corners = _extreme(points, most)
    triangles = hull_triangles(corners)
    used = np.flatnonzero(np.bincount(triangles.reshape(-1)))
    number = np.zeros(len(corners), np.int64)
    number[used] = np.arange(len(used))
    return corners[used], number[triangles]


def _area(points: Floats, faces: Integers) -> float:
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def _error(samples: Floats, surface: Floats, noise: float) -> float:
    """How far points of a candidate are from a surface, without what sampling adds."""
    if not len(samples):
        return 0.0
    away = float(np.quantile(distances(samples, surface), _SHARE))
    return max(0.0, away - noise)


def _outer(samples: list[Floats], parts: tuple[Part, ...]) -> Floats:
    """The samples of parts that do not lie inside another part."""
    kept = []
    for number, points in enumerate(samples):
        inside = np.zeros(len(points), bool)
        for other, (corners, faces) in enumerate(parts):
            if other != number:
                a = corners[faces[:, 0]]
                normal = np.cross(corners[faces[:, 1]] - a, corners[faces[:, 2]] - a)
                normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
                depth = points @ normal.T - np.einsum("ij,ij->i", a, normal)
                inside |= (depth < 1e-4).all(axis=1)
        kept.append(points[~inside])
    return np.concatenate(kept)


def _primitives(
    points: Floats,
) -> Iterator[tuple[Literal["box", "cylinder", "sphere"], tuple[float, ...], Pose, Floats]]:
    """Box, cylinder and sphere around points, along the axes of the frame or the principal ones."""
    for axes in _frames(points):
        turned = points @ axes
        low, high = turned.min(axis=0), turned.max(axis=0)
        size, middle = np.maximum(high - low, THINNEST_M), axes @ ((low + high) / 2.0)
        pose = Pose(_vec(middle), from_axes(*(_vec(axes[:, n]) for n in range(3))))
        yield "box", tuple(size.tolist()), pose, _box_samples(size) @ axes.T + middle
        for axis in range(3):
            x, y = (axis + 1) % 3, (axis + 2) % 3
            around = turned[:, [x, y]] - (low + high)[[x, y]] / 2.0
            radius = float(np.linalg.norm(around, axis=1).max())
            if abs(size[x] - size[y]) > 0.1 * max(size[x], size[y]):
                continue
            frame = axes[:, [x, y, axis]]
            place = Pose(_vec(middle), from_axes(*(_vec(frame[:, n]) for n in range(3))))
            rim = _cylinder_samples(radius, float(size[axis]))
            yield "cylinder", (radius, float(size[axis])), place, rim @ frame.T + middle
        radius = float(np.linalg.norm(points - middle, axis=1).max())
        yield "sphere", (radius,), Pose(_vec(middle)), _ball_samples() * radius + middle


def _frames(points: Floats) -> Iterator[Floats]:
    yield np.eye(3)
    centered = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centered.T @ centered)
    for column in range(3):  # the same signs on every machine
        largest = int(np.argmax(np.abs(axes[:, column])))
        axes[:, column] *= np.sign(axes[largest, column]) or 1.0
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    if np.abs(axes).max(axis=0).min() < 0.999:
        yield axes


def _box_samples(size: Floats) -> Floats:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2.0
    return sampled(corners, hull_triangles(corners), _CANDIDATE_SAMPLES)


def _cylinder_samples(radius: float, length: float) -> Floats:
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(angles) * radius, np.sin(angles) * radius], axis=1)
    ends = [np.column_stack([ring, np.full(24, z)]) for z in (-length / 2.0, length / 2.0)]
    corners = np.concatenate(ends)
    return sampled(corners, hull_triangles(corners), _CANDIDATE_SAMPLES)


def _ball_samples() -> Floats:
    steps = np.arange(_CANDIDATE_SAMPLES) + 0.5
    polar, around = np.arccos(1 - 2 * steps / _CANDIDATE_SAMPLES), np.pi * (1 + 5**0.5) * steps
    return np.stack(
        [np.cos(around) * np.sin(polar), np.sin(around) * np.sin(polar), np.cos(polar)], axis=1
    )


def _extreme(points: Floats, most: int) -> Floats:
    """The points that are outermost in many directions, which nearly span the hull."""
    unique = np.round(points, 7)
    unique = unique[np.sort(same_rows(unique)[0])]
    if len(unique) <= most:
        return unique
    directions = np.concatenate([_ball_samples()[:: max(1, _CANDIDATE_SAMPLES // (most * 2))],
                                 np.eye(3), -np.eye(3)])  # fmt: skip
    outermost: dict[int, None] = {}
    for start in range(0, len(directions), 16):
        part = np.argmax(unique @ directions[start : start + 16].T, axis=0)
        outermost |= dict.fromkeys(part.tolist())
    return unique[sorted(outermost)]


def _vec(values: Floats) -> Vec3:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
