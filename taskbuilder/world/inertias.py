"""Whether the inertias that URDFs of objects state fit their shapes and masses.

Published URDFs often have placeholders. PyBullet's Lego brick of 0.1 kg has 1 kg·m² about each
axis, 50,000 times what it should be: it stands on an edge on which no brick would stay.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets import codes
from taskbuilder.assets.links import read_pose
from taskbuilder.assets.markup import Element
from taskbuilder.assets.model import Urdf, UrdfLink
from taskbuilder.assets.paths import pybullet_data_folder
from taskbuilder.assets.schema import number
from taskbuilder.errors import Finding, Location
from taskbuilder.geometry import Box, Vec3, bounding_box, norm
from taskbuilder.schema.load import TaskFile
from taskbuilder.shapes import bounds, placed_bounds
from taskbuilder.world.shapes import urdf_shape
from taskbuilder.world.weights import ENTRIES, turned, uniform

FAR_FACTOR = 20.0
"""Factor from the moments of uniform density beyond which moments are implausible.

Those of the objects of the library differ by a factor of up to 1.9, and those of quadrupeds in
pybullet_data that were computed from CAD models by up to 13.
"""

_CENTER_M, _CENTER_SHARE = 0.005, 0.05  # of the diagonal: a centre that is so far off is doubtful


@dataclass(frozen=True)
class Inertia:
    """The stated inertia of a link beside that which follows from its shapes.

    Attributes:
        link: Name of the link.
        mass: In kg.
        stated: Principal moments as the URDF has them, in kg·m², ascending.
        uniform: Those of its shapes with uniform density and the same mass, ascending.
        tensor: The same as a matrix, along the axes of the ``<inertial>`` frame.
        most: The mass times the square of the largest distance of its shapes from the centre of
            mass, kg·m². No moment of a body can exceed it.
    """

    link: str
    mass: float
    stated: NDArray[np.float64]
    uniform: NDArray[np.float64]
    tensor: NDArray[np.float64]
    most: float

    @property
    def factor(self) -> float:
        """By what factor the moments differ at most; above 1 where those stated are too large."""
        factors: list[float] = (self.stated / self.uniform).tolist()
        return max(factors, key=lambda factor: abs(math.log(factor)))

    @property
    def possible(self) -> bool:
        """Whether a body of this mass and extent can have the stated moments."""
        return bool(self.stated[2] <= self.most)

    @property
    def plausible(self) -> bool:
        """Whether the moments are possible and near those of uniform density."""
        return self.possible and 1.0 / FAR_FACTOR <= self.factor <= FAR_FACTOR


def doubtful_inertias(task: TaskFile) -> tuple[Finding, ...]:
    """What is doubtful about the inertias and centres of mass of a task's objects.

    Assets of an installed package are not for the author of a task to mend, and are left out.
    """
    if task.entry.trusted:
        return ()
    findings: dict[Finding, None] = {}
    for name, asset in task.assets.items():
        spec = task.spec.scene.objects.get(name)
        if not isinstance(asset, Urdf) or spec is None or spec.density or spec.inertia:
            continue
        if name not in task.models or not task.models[name].entry.trusted:
            findings |= dict.fromkeys(check_inertias(asset, fixed=spec.fixed))
    return tuple(findings)


def check_inertias(urdf: Urdf, *, fixed: bool) -> Iterator[Finding]:
    """Implausible moments of inertia and centres of mass of an object.

    Args:
        urdf: The object.
        fixed: Whether its root is fixed to the world.
    """
    elements = {element.get("name"): element for element in urdf.tree.all("link")}
    for inertia in inertias(urdf, fixed=fixed):
        if not inertia.plausible:
            place = _inertial(elements[inertia.link]).first("inertia")
            yield _finding(codes.PLACEHOLDER, urdf, inertia.link, place, _complaint(inertia))
    for link in _moved(urdf, fixed=fixed):
        inertial = elements[link.name].first("inertial")
        box = _around(urdf, link)
        if not link.mass or inertial is None or box is None:
            continue
        center = read_pose(inertial).position
        if (outside := _outside(center, box)) > norm(box.half):
            message = (
                f"its centre of mass, {_spaced(center)}, is {outside:.3g} m outside its shapes, "
                f"which extend from {_spaced(box.low)} to {_spaced(box.high)}; "
                f'write <origin xyz="{_spaced(box.center)}"/> in <inertial>'
            )
            place = inertial.first("origin") or inertial
            yield _finding(codes.CENTER_OF_MASS, urdf, link.name, place, message)


def misplaced_centers(urdf: Urdf) -> Iterator[tuple[str, float]]:
    """Links whose stated centre of mass is far from that of their shapes, and how far, in metres.

    What is heavy at one end has its centre of mass there, so this is not wrong by itself.
    """
    elements = {element.get("name"): element for element in urdf.tree.all("link")}
    for link in urdf.links:
        inertial = elements[link.name].first("inertial")
        shapes = link.collisions or link.visuals
        box = _around(urdf, link)
        if not link.mass or inertial is None or not shapes or box is None:
            continue
        off = math.dist(read_pose(inertial).position, uniform(shapes).center.tolist())
        if off > max(_CENTER_M, _CENTER_SHARE * 2.0 * norm(box.half)):
            yield link.name, off


def inertias(urdf: Urdf, *, fixed: bool) -> Iterator[Inertia]:
    """The inertia of every link that has a mass and shapes, and that can turn.

    What only slides has no use for its moments of inertia.

    Args:
        urdf: The object.
        fixed: Whether its root is fixed to the world.
    """
    elements = {element.get("name"): element for element in urdf.tree.all("link")}
    for link in _moved(urdf, fixed=fixed):
        above = urdf.moving_joints_above(link.name)
        turns = not fixed or any(joint.type != "prismatic" for joint in above)
        inertial = elements[link.name].first("inertial")
        shapes = link.collisions or link.visuals
        if not (turns and link.mass and inertial and shapes):
            continue
        entries = [number(inertial.first("inertia"), entry) or 0.0 for entry in ENTRIES]
        stated = _principal(_matrix(entries))
        if stated[0] <= 0.0:
            continue  # which has been reported
        frame = read_pose(inertial)
        tensor = turned(uniform(shapes).tensor * link.mass, frame.inverse())
        seen = (*link.collisions, *link.visuals)
        corners = [s.pose.apply(c) for s in seen for c in bounds(urdf_shape(s)).corners()]
        most = link.mass * max(math.dist(frame.position, corner) for corner in corners) ** 2
        yield Inertia(link.name, link.mass, stated, _principal(tensor), tensor, most)


def _moved(urdf: Urdf, *, fixed: bool) -> list[UrdfLink]:
    """The links that can move."""
    return [link for link in urdf.links if not fixed or urdf.moving_joints_above(link.name)]


def _principal(tensor: NDArray[np.float64]) -> NDArray[np.float64]:
    """Principal moments, ascending."""
    return np.asarray(np.linalg.eigvalsh(tensor), dtype=np.float64)


def _matrix(entries: Sequence[float]) -> NDArray[np.float64]:
    xx, xy, xz, yy, yz, zz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _complaint(inertia: Inertia) -> str:
    factor = inertia.factor
    large = f"{factor:,.0f} times as large" if factor > 1.0 else f"{1 / factor:,.0f} times smaller"
    than = "as" if factor > 1.0 else "than"
    message = (
        f"a moment of inertia is {large} {than} that of its shape with {inertia.mass:g} kg of "
        "uniform density"
    )
    if not inertia.possible:
        message += (
            f", and {inertia.stated[2]:.3g} kg·m² is more than a body of its size can have "
            f"({inertia.most:.3g})"
        )
    entries = zip(*np.triu_indices(3), strict=True)
    values = (
        0.0 if abs(v := inertia.tensor[at]) < 1e-4 * inertia.uniform[0] else v for at in entries
    )
    line = " ".join(f'{name}="{value:.3g}"' for name, value in zip(ENTRIES, values, strict=True))
    return f"{message}; write <inertia {line}/>"


def _around(urdf: Urdf, link: UrdfLink) -> Box | None:
    """Box around the shapes of a link and of what is fixed to it, in its frame; None without."""
    corners: list[Vec3] = []
    for other, pose in urdf.fixed_to(link.name):
        held = urdf.link(other)
        for shape in (*held.collisions, *held.visuals):
            box = placed_bounds(urdf_shape(shape), pose @ shape.pose)
            corners += [box.low, box.high]
    return bounding_box(corners) if corners else None


def _outside(point: Vec3, box: Box) -> float:
    """How far a point is outside a box, in metres."""
    return math.hypot(*(max(abs(point[i] - box.center[i]) - box.half[i], 0.0) for i in range(3)))


def _inertial(link: Element) -> Element:
    return link.first("inertial") or link


def _finding(code: str, urdf: Urdf, link: str, place: Element | None, message: str) -> Finding:
    where = Location(urdf.path, place.line, place.column) if place else Location(urdf.path)
    packaged = pybullet_data_folder()
    if packaged is not None and urdf.path.is_relative_to(packaged):
        message += ", in a copy of the file in the folder of the task"
    return Finding(code, message, f"link {link}", where, "warning")


def _spaced(values: Vec3) -> str:
    return " ".join(f"{round(value, 4) + 0.0:g}" for value in values)
