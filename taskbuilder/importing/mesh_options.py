"""How meshes are imported, as somebody asks for it."""

from __future__ import annotations

from dataclasses import dataclass

from taskbuilder.importing.fitting import Choice
from taskbuilder.importing.mesh_files import Up


@dataclass(frozen=True)
class MeshOptions:
    """How meshes are imported.

    Attributes:
        triangles: The most triangles of a mesh that is drawn.
        collision: How collision shapes are made of meshes.
        unit: Metres of one unit of meshes whose format states none; None to look at their size.
        up: Their up axis; None for what is found.
        upright: Whether stated up axes are turned to z, as for objects; in robots, only where
            the collision shape says so.
        slack: How far off a hull may be; see `fit`.
        scale: By how much meshes are made larger, after their unit.
    """

    triangles: int = 8000
    collision: Choice = "auto"
    unit: float | None = None
    up: Up | None = None
    upright: bool = False
    slack: float = 1.0
    scale: float = 1.0
