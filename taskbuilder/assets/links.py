"""The links of a URDF: their mass, inertia and shapes."""

from __future__ import annotations

import math
from typing import cast, get_args

from taskbuilder.assets import codes
from taskbuilder.assets.files import Files
from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import ShapeKind, UrdfLink, UrdfShape
from taskbuilder.assets.report import Report
from taskbuilder.assets.schema import number, numbers
from taskbuilder.geometry import ORIGIN, Pose, Vec3, from_rpy

_LIGHTEST_KG = 1e-9
_HEAVIEST_KG = 1e3
_SMALLEST_M = 1e-6
_SIZES = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}
_KINDS: tuple[str, ...] = get_args(ShapeKind)
# Numbers in public URDFs are rounded to a few digits.
_TRIANGLE_TOLERANCE = 1e-3


def read_link(
    element: Element, *, movable: bool = True, jointed: bool, report: Report, files: Files
) -> UrdfLink:
    """A link; what is wrong with it goes into the report.

    Args:
        element: The ``<link>``.
        movable: Whether it can move at all, with its body or by a joint.
        jointed: Whether a joint with a degree of freedom moves this very link.
        report: Where findings go.
        files: Where meshes and textures are looked up.
    """
    name = element.get("name") or ""
    subject = f"link {name}"
    visuals = _shapes(element, "visual", subject, report, files)
    collisions = _shapes(element, "collision", subject, report, files)
    for visual in element.all("visual"):
        for material in visual.all("material"):
            read_material(material, subject, files)
    inertial = element.first("inertial")
    if inertial is None:
        if jointed or (movable and collisions):
            message = "has no <inertial>, so Bullet takes 1 kg; write its mass and inertia"
            report.warning(codes.MASS, element, subject, message)
        return UrdfLink(name, None, visuals, collisions)
    mass = _mass(inertial, jointed, subject, report)
    if mass:
        _check_inertia(inertial, jointed, subject, report)
    return UrdfLink(name, mass, visuals, collisions)


def read_pose(element: Element) -> Pose:
    """The pose of an ``<origin>`` child; none means the frame itself."""
    origin = element.first("origin")
    rpy = numbers(origin, "rpy") or ORIGIN
    return Pose(as_vec3(numbers(origin, "xyz") or ORIGIN), from_rpy(*rpy))


def as_vec3(values: tuple[float, ...]) -> Vec3:
    """Three numbers as a vector."""
    x, y, z = values
    return (x, y, z)


def read_material(material: Element, subject: str, files: Files) -> None:
    """Checks the texture of a material."""
    for texture in material.all("texture"):
        files.texture(texture, subject)


def _shapes(
    link: Element, tag: str, subject: str, report: Report, files: Files
) -> tuple[UrdfShape, ...]:
    shapes = [_shape(element, subject, report, files) for element in link.all(tag)]
    return tuple(shape for shape in shapes if shape)


def _shape(element: Element, subject: str, report: Report, files: Files) -> UrdfShape | None:
    """The shape of a ``<visual>`` or ``<collision>``; None if it was reported as wrong."""
    geometry = element.first("geometry")
    solids = geometry.children if geometry else ()
    if len(solids) != 1:
        message = f"<{element.tag}> needs one <geometry> with exactly one of {', '.join(_KINDS)}"
        report.error(codes.GEOMETRY, geometry or element, subject, message)
        return None
    solid = solids[0]
    if solid.tag not in _KINDS:
        return None  # which has been reported
    pose = read_pose(element)
    if solid.tag == "mesh":
        scale = _scale(solid, subject, report)
        path = files.mesh(solid, subject, scale)
        return UrdfShape("mesh", scale, pose, path) if path else None
    size = _size(solid, subject, report)
    return UrdfShape(cast(ShapeKind, solid.tag), size, pose) if size else None


def _scale(mesh: Element, subject: str, report: Report) -> Vec3:
    scale = as_vec3(numbers(mesh, "scale") or (1.0, 1.0, 1.0))
    if 0.0 in scale:
        message = "a mesh scale of 0 leaves nothing; write 1 1 1, or leave it out"
        report.error(codes.GEOMETRY, mesh, subject, message)
        return (1.0, 1.0, 1.0)
    return scale


def _size(solid: Element, subject: str, report: Report) -> tuple[float, ...]:
    """The sizes of a primitive shape; () if they were reported as wrong."""
    sizes: list[float] = []
    for attribute in _SIZES[solid.tag]:
        if solid.get(attribute) is None:
            message = f"<{solid.tag}> needs {attribute}=…, in metres"
            report.error(codes.GEOMETRY, solid, subject, message)
            return ()
        sizes += numbers(solid, attribute) or (math.nan,)
    if any(size < _SMALLEST_M for size in sizes):
        message = f"<{solid.tag}> has a size that is not above 0; sizes are in metres"
        report.error(codes.GEOMETRY, solid, subject, message)
        return ()
    return () if any(math.isnan(size) for size in sizes) else tuple(sizes)


def _mass(inertial: Element, jointed: bool, subject: str, report: Report) -> float | None:
    element = inertial.first("mass")
    if element is None or element.get("value") is None:
        report.error(codes.MASS, element or inertial, subject, 'needs <mass value="…"/>, in kg')
        return None
    mass = number(element, "value")
    if mass is None:
        return None
    # A massless link on a fixed joint or as a static base is a frame, and Bullet agrees.
    light_enough = mass == 0 and not jointed
    if not (light_enough or _LIGHTEST_KG <= mass <= _HEAVIEST_KG):
        message = f"a mass of {mass:g} kg is implausible; write one above 0, up to {_HEAVIEST_KG:g}"
        report.error(codes.MASS, element, subject, message)
        return None
    return mass


def _check_inertia(inertial: Element, jointed: bool, subject: str, report: Report) -> None:
    """Reports moments of inertia that no body can have."""
    element = inertial.first("inertia")
    if element is None:
        report.error(codes.INERTIA, inertial, subject, "needs <inertia ixx=… iyy=… izz=…/>")
        return
    missing = [name for name in ("ixx", "iyy", "izz") if element.get(name) is None]
    if missing:
        report.error(codes.INERTIA, element, subject, f"<inertia> needs {', '.join(missing)}")
        return
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    entries = [number(element, n) if element.get(n) is not None else 0.0 for n in names]
    known = [entry for entry in entries if entry is not None]
    if len(known) < len(names):
        return
    smallest, middle, largest = _principal_moments(known)
    if smallest <= 0:
        message = f"a principal moment of inertia is {smallest:.3g}; all three must be above 0"
        # Many public robots write 0 for small parts that are fixed, which does no harm.
        note = report.error if smallest < 0 or jointed else report.warning
        note(codes.INERTIA, element, subject, message)
    elif smallest + middle < largest * (1 - _TRIANGLE_TOLERANCE):
        message = (
            f"the principal moments {smallest:.3g}, {middle:.3g}, {largest:.3g} fit no body; "
            "none may exceed the sum of the others"
        )
        report.warning(codes.INERTIA, element, subject, message)


def _principal_moments(entries: list[float]) -> tuple[float, float, float]:
    """Eigenvalues of a symmetric 3×3 matrix in closed form, ascending (Smith, 1961)."""
    xx, xy, xz, yy, yz, zz = entries
    mean = (xx + yy + zz) / 3
    dx, dy, dz = xx - mean, yy - mean, zz - mean
    spread = math.sqrt((dx * dx + dy * dy + dz * dz + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    if spread <= abs(mean) * 1e-12:
        return (mean, mean, mean)
    a, b, c, d, e, f = (entry / spread for entry in (dx, xy, xz, dy, yz, dz))
    half_determinant = (a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c)) / 2
    angle = math.acos(max(-1.0, min(1.0, half_determinant))) / 3
    largest = mean + 2 * spread * math.cos(angle)
    smallest = mean + 2 * spread * math.cos(angle + 2 * math.pi / 3)
    return (smallest, 3 * mean - largest - smallest, largest)
