"""A z-buffer rasteriser on the CPU: colour, depth and segmentation of triangle meshes in one pass.

It knows nothing of robots or physics. `Scene` holds shapes, which stay; `Scene.draw` takes their
poses and a camera, which change. The kernels are compiled by Numba when they are first used, and
kept on disk. The same input gives the same picture, bit for bit.
"""

from taskbuilder.raster.meshes import (
    TriangleMesh,
    box,
    capsule,
    cylinder,
    mesh_of,
    parts_of,
    simplified,
    sphere,
)
from taskbuilder.raster.patterns import Pattern
from taskbuilder.raster.scene import Drawing, Lamp, MeshInstance, PinholeCamera, Scene

__all__ = [
    "Drawing",
    "Lamp",
    "MeshInstance",
    "Pattern",
    "PinholeCamera",
    "Scene",
    "TriangleMesh",
    "box",
    "capsule",
    "cylinder",
    "mesh_of",
    "parts_of",
    "simplified",
    "sphere",
]
