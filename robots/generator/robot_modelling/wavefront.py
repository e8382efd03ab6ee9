"""Meshes as Wavefront OBJ: joined, shaded and printed the same on every machine."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from robot_modelling.solids import Array, Mesh, Triangles

CREASE = math.cos(math.radians(40.0))


def merged(meshes: Iterable[Mesh]) -> Mesh:
    """Join meshes into one, equal points shared and triangles without an area left out."""
    vertices: list[Array] = []
    faces: list[Triangles] = []
    count = 0
    for part_vertices, part_faces in meshes:
        vertices.append(part_vertices)
        faces.append(part_faces + count)
        count += len(part_vertices)
    # To the nanometre first: the last bits of sines and products differ between machines, and a
    # value that lies on the edge between two printed digits must fall to the same side on all.
    points = np.round(np.concatenate(vertices), 9) + 0.0
    unique, number = np.unique(np.round(points, 5) + 0.0, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[np.concatenate(faces)]
    keep = (
        (triangles[:, 0] != triangles[:, 1])
        & (triangles[:, 1] != triangles[:, 2])
        & (triangles[:, 2] != triangles[:, 0])
    )
    return unique, triangles[keep]


def corner_normals(vertices: Array, faces: Triangles) -> Array:
    """Return the normals (m, 3, 3) of every triangle's corners.

    A corner takes the mean, weighted by area, of those faces around its vertex that bend less than
    the crease angle from its own: round parts look round and edges stay sharp.
    """
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    weighted = np.cross(b - a, c - a)
    unit = weighted / np.maximum(np.linalg.norm(weighted, axis=1), 1e-15)[:, None]
    around: list[list[int]] = [[] for _ in vertices]
    for f, face in enumerate(faces):
        for v in face:
            around[v].append(f)
    normals = np.empty((len(faces), 3, 3))
    for f, face in enumerate(faces):
        for corner, v in enumerate(face):
            near = [g for g in around[v] if float(unit[f] @ unit[g]) >= CREASE]
            total = weighted[near].sum(axis=0) if near else unit[f]
            normals[f, corner] = total / np.linalg.norm(total)
    return normals


def obj_text(mesh: Mesh, comment: str, digits: tuple[int, int] = (5, 3)) -> str:
    """Return a mesh as Wavefront OBJ with normals.

    Args:
        mesh: Vertices and triangles.
        comment: The first line.
        digits: Decimals of points and of normals.
    """
    vertices, faces = mesh
    point, normal = digits
    normals = np.round(np.round(corner_normals(vertices, faces), 9), normal) + 0.0
    unique, number = np.unique(normals.reshape(-1, 3), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    lines = [f"# {comment}; written by generate.py"]
    lines += [f"v {x:.{point}f} {y:.{point}f} {z:.{point}f}" for x, y, z in vertices]
    lines += [f"vn {x:.{normal}f} {y:.{normal}f} {z:.{normal}f}" for x, y, z in unique]
    lines += [
        "f " + " ".join(f"{v + 1}//{n + 1}" for v, n in zip(face, around, strict=True))
        for face, around in zip(faces, number, strict=True)
    ]
    return "\n".join(lines) + "\n"
