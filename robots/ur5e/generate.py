"""Generate the UR5e: its URDF and its low-poly meshes, all own work.

Run it as ``python robots/ur5e/generate.py``; it rewrites ``ur5e.urdf`` and ``meshes/*.obj`` beside
itself, byte for byte the same on every run. Everything is drawn from the tables below: the
manufacturer's published kinematics, limits, masses and inertias, and outlines drawn by hand after
the look of the arm. No mesh of the manufacturer is used.

Frames follow the common UR description: every joint turns about the z axis of its link. With all
joints at zero the arm lies stretched out horizontally along +x of ``base_link``; positive
``shoulder_lift_joint`` lowers it. ``base_link`` is at the mounting surface, x forward, z up; the
Denavit-Hartenberg base frame of the published table is ``base_link`` turned by 180 degrees about z.

A mesh is a pair of arrays: vertices (n, 3) in metres and triangles (m, 3) of vertex numbers. Every
solid is a loft: a stack of rings of equally many points, joined ring to ring. A turned part is a
loft of circles, a milled one a loft of outlines.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triangles = NDArray[np.int64]
Mesh = tuple[Array, Triangles]
Corner = tuple[float, ...]  # (u, v) or (u, v, radius of the rounding)

# ---------------------------------------------------------------------------------------------
# Published figures: DH table, limits, masses, centres of mass and inertia tensors of the UR5e
# ---------------------------------------------------------------------------------------------
D1, A2, A3, D4, D5, D6 = 0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996  # m
MAX_SPEED = math.pi  # rad/s, 180 degrees a second in every joint

# How far the upper arm and the forearm lie beside the plane of the shoulder, along the joint axes.
# They cancel out in the kinematics (only d4 is left of them) and matter to shapes alone.
UPPER_ARM_SIDE, FOREARM_SIDE = 0.138, 0.007  # m

# The gripper: flange to pad centre, and half of the 85 mm stroke.
TCP_HEIGHT = 0.144  # m
FINGER_TRAVEL = 0.0425  # m
PAD_WIDTH, PAD_HEIGHT = 0.022, 0.044  # m
FINGER_DEPTH = 0.012  # m, thickness of a finger across the pad
PALM_HEIGHT = 0.100  # m
PAD_FRICTION = 1.2

COLORS = {
    "tube": (0.79, 0.80, 0.81),
    "housing": (0.66, 0.675, 0.69),
    "cap": (0.45, 0.64, 0.78),
    "ring": (0.12, 0.125, 0.13),
    "body": (0.185, 0.19, 0.20),
    "metal": (0.46, 0.47, 0.49),
    "pad": (0.80, 0.80, 0.77),
}

# ---------------------------------------------------------------------------------------------
# Outlines
# ---------------------------------------------------------------------------------------------
ROUND_STEPS = 2


def rounded(corners: Sequence[Corner], *, closed: bool) -> list[tuple[float, float]]:
    """Replace every corner that names a radius by an arc of ``ROUND_STEPS`` chords.

    Args:
        corners: Points (u, v) or (u, v, radius) of a polyline.
        closed: Whether the last point joins the first.

    Returns:
        The points of the rounded polyline.
    """
    points: list[tuple[float, float]] = []
    for i, (u, v, *radius) in enumerate(corners):
        here = np.array([u, v])
        is_end = not closed and i in (0, len(corners) - 1)
        if not radius or radius[0] == 0 or is_end:
            points.append((u, v))
            continue
        back = np.array(corners[i - 1][:2]) - here
        ahead = np.array(corners[(i + 1) % len(corners)][:2]) - here
        back /= np.linalg.norm(back)
        ahead /= np.linalg.norm(ahead)
        half = math.acos(max(-1.0, min(1.0, float(back @ ahead)))) / 2
        middle = (back + ahead) / np.linalg.norm(back + ahead)
        center = here + middle * radius[0] / math.sin(half)
        start = here + back * radius[0] / math.tan(half) - center
        turn = math.pi - 2 * half
        sign = 1.0 if back[0] * ahead[1] - back[1] * ahead[0] < 0 else -1.0
        for step in range(ROUND_STEPS + 1):
            a = sign * turn * step / ROUND_STEPS
            c, s = math.cos(a), math.sin(a)
            x, y = center + np.array([c * start[0] - s * start[1], s * start[0] + c * start[1]])
            points.append((float(x), float(y)))
    return points


# ---------------------------------------------------------------------------------------------
# Solids
# ---------------------------------------------------------------------------------------------
def loft(rings: Array, *, cap_start: bool, cap_end: bool) -> Mesh:
    """Join a stack of rings of points, counter-clockwise seen from its end.

    Args:
        rings: (k, n, 3) in metres; a ring may shrink to one repeated point.
        cap_start: Whether to close the first ring with a flat face. The ring must be convex.
        cap_end: The same for the last ring.

    Returns:
        The mesh, its faces turned outward.
    """
    k, n, _ = rings.shape
    faces: list[tuple[int, int, int]] = []
    for i in range(k - 1):
        for j in range(n):
            a, b = i * n + j, i * n + (j + 1) % n
            faces += [(a, b, b + n), (a, b + n, a + n)]
    if cap_start:
        faces += [(0, j + 1, j) for j in range(1, n - 1)]
    if cap_end:
        top = (k - 1) * n
        faces += [(top, top + j, top + j + 1) for j in range(1, n - 1)]
    return rings.reshape(-1, 3), np.array(faces, dtype=np.int64)


def turned(profile: Sequence[Corner], *, segments: int = 24, caps: str = "none") -> Mesh:
    """Turn a profile about the z axis, as on a lathe.

    Args:
        profile: Corners (radius, z) or (radius, z, rounding) from bottom to top.
        segments: Flat sides of the circle.
        caps: Which open ends to close: none, start, end or both. An end inside another part
            stays open and saves its triangles.
    """
    turn = 2 * math.pi / segments * np.arange(segments)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros(segments)], axis=1)
    rings = [circle * r + [0.0, 0.0, z] for r, z in rounded(profile, closed=False)]
    return loft(
        np.array(rings), cap_start=caps in ("start", "both"), cap_end=caps in ("end", "both")
    )


def inset(outline: Sequence[tuple[float, float]], distance: float) -> Array:
    """Move every side of a convex counter-clockwise outline inward."""
    points = np.array(outline)
    sides = np.roll(points, -1, axis=0) - points
    normals = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    before = np.roll(normals, 1, axis=0)
    mitre = (before + normals) / (1 + (before * normals).sum(axis=1))[:, None]
    moved_in: Array = points + distance * mitre
    return moved_in


def milled(
    outline: Sequence[Corner], bottom: float, top: float, *, bevel: float = 0.0, caps: str = "both"
) -> Mesh:
    """Raise a counter-clockwise outline (x, y) from z = bottom to top, its edges bevelled.

    The outline must lie open to view from its first corner, where the flat faces fan out.
    """
    points = rounded(outline, closed=True)
    stack = [(bevel, bottom), (0.0, bottom + bevel), (0.0, top - bevel), (bevel, top)]
    if bevel == 0:
        stack = [(0.0, bottom), (0.0, top)]
    if caps == "end":  # the bottom is hidden inside another part and stays sharp and open
        stack = [(0.0, bottom), *stack[-2:]] if bevel else stack
    rings = [
        np.column_stack([inset(points, distance), np.full(len(points), z)]) for distance, z in stack
    ]
    return loft(np.array(rings), cap_start=caps in ("start", "both"), cap_end=caps != "none")


def rectangle(x: tuple[float, float], y: tuple[float, float], radius: float = 0.0) -> list[Corner]:
    """Return the outline of a rectangle with rounded corners."""
    return [(x[0], y[0], radius), (x[1], y[0], radius), (x[1], y[1], radius), (x[0], y[1], radius)]


# Right-handed frames (columns) whose z axis is the named one: where a part's own z shall point.
FRAMES: dict[str, tuple[tuple[int, int, int], ...]] = {
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "+y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "+x": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "-x": ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
}


def placed(mesh: Mesh, axis: str, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """Turn a mesh so that its z axis points along ``axis``, then move it to ``at``."""
    vertices, faces = mesh
    return vertices @ np.array(FRAMES[axis], dtype=float).T + np.array(at), faces


def mirrored(mesh: Mesh) -> Mesh:
    """Mirror a mesh in y, its faces still turned outward."""
    vertices, faces = mesh
    return vertices * np.array([1.0, -1.0, 1.0]), faces[:, ::-1]


# ---------------------------------------------------------------------------------------------
# Writing
# ---------------------------------------------------------------------------------------------
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


def obj_text(mesh: Mesh, comment: str) -> str:
    """Return a mesh as Wavefront OBJ with normals."""
    vertices, faces = mesh
    normals = np.round(np.round(corner_normals(vertices, faces), 9), 3) + 0.0
    unique, number = np.unique(normals.reshape(-1, 3), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    lines = [f"# {comment}; written by generate.py"]
    lines += [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices]
    lines += [f"vn {x:.3f} {y:.3f} {z:.3f}" for x, y, z in unique]
    lines += [
        "f " + " ".join(f"{v + 1}//{n + 1}" for v, n in zip(face, around, strict=True))
        for face, around in zip(faces, number, strict=True)
    ]
    return "\n".join(lines) + "\n"


# ---------------------------------------------------------------------------------------------
# The links' looks, each in its own link frame
# ---------------------------------------------------------------------------------------------
Part = tuple[str, Mesh]  # (colour, mesh)


def end_cap(radius: float, height: float, *, segments: int = 24) -> Mesh:
    """Return the blue lid that closes a joint housing: a flat dome on a rounded rim."""
    return turned(
        [
            (radius, 0.0),
            (radius, height * 0.96, height * 0.75),
            (0.0, height * 1.10),
        ],
        segments=segments,
    )


def seal(radius: float, bottom: float, top: float, *, segments: int = 24) -> Mesh:
    """Return the dark ring between two links."""
    return turned([(radius, bottom), (radius, top)], segments=segments)


def joint_module(
    radius: float, back: float, front: float, *, cap: float, segments: int = 24
) -> list[Part]:
    """Return a joint housing along z: a turned shell from back to front with its lid at the back.

    Args:
        radius: Of the shell.
        back: z of the lid's seat, negative.
        front: z of the face that carries the next link.
        cap: Height of the lid.
        segments: Flat sides of the circle.
    """
    lip = radius * 0.93
    shell = turned(
        [
            (lip, back - 0.001),
            (radius, back + 0.005),
            (radius, front - 0.007, 0.004),
            (lip, front),
        ],
        segments=segments,
        caps="end",
    )
    lid = placed(end_cap(radius * 0.955, cap, segments=segments), "-z", (0.0, 0.0, back + 0.0005))
    return [("housing", shell), ("cap", lid)]


def moved(parts: Iterable[Part], axis: str, at: tuple[float, float, float]) -> list[Part]:
    """Place every part of a list."""
    return [(color, placed(mesh, axis, at)) for color, mesh in parts]


def base_parts() -> list[Part]:
    """Return the foot on its flange and the turned base above it."""
    foot = turned([(0.0745, 0.0), (0.0745, 0.010, 0.002), (0.0655, 0.014)], caps="end")
    body = turned([(0.066, 0.0135), (0.0625, 0.030, 0.02), (0.0600, 0.0915)])
    connector = placed(
        milled(
            rectangle((-0.019, 0.019), (-0.014, 0.014), 0.004), 0.05, 0.071, bevel=0.003, caps="end"
        ),
        "-x",
        (0.0, 0.0, 0.036),
    )
    return [
        ("ring", foot),
        ("housing", body),
        ("ring", seal(0.0585, 0.091, 0.0995)),
        ("ring", connector),
    ]


def shoulder_parts() -> list[Part]:
    """Return the shoulder: a neck up from the base and the housing of the lift joint across it."""
    neck = turned([(0.056, -0.0640), (0.0605, -0.0590), (0.0605, 0.0)], caps="start")
    across = moved(joint_module(0.0610, -0.062, 0.066, cap=0.019), "-y", (0.0, 0.0, 0.0))
    ring = placed(seal(0.0575, 0.064, 0.0715), "-y")
    return [("housing", neck), *across, ("ring", ring)]


def upper_arm_parts() -> list[Part]:
    """Return the upper arm: a tube between the shoulder's and the elbow's housings."""
    side = UPPER_ARM_SIDE
    near = moved(joint_module(0.0605, -0.055, 0.067, cap=0.018), "-z", (0.0, 0.0, side))
    far = moved(joint_module(0.0575, -0.052, 0.063, cap=0.017), "-z", (A2, 0.0, side))
    tube = turned(
        [
            (0.0555, 0.03),
            (0.0555, 0.078, 0.006),
            (0.0510, 0.088),
            (0.0510, -A2 - 0.088),
            (0.0550, -A2 - 0.078, 0.006),
            (0.0550, -A2 - 0.03),
        ]
    )
    ring = placed(seal(0.0545, 0.061, 0.068), "-z", (A2, 0.0, side))
    return [*near, *far, ("tube", placed(tube, "-x", (0.0, 0.0, side))), ("ring", ring)]


def forearm_parts() -> list[Part]:
    """Return the forearm: elbow shell, a tube that tapers, and the housing of wrist 1."""
    side = FOREARM_SIDE
    elbow = moved(joint_module(0.0570, -0.048, 0.0635, cap=0.017), "+z", (0.0, 0.0, side))
    tube = turned(
        [
            (0.0500, 0.03),
            (0.0500, 0.074, 0.01),
            (0.0395, 0.118, 0.03),
            (0.0375, -A3 - 0.066),
            (0.0395, -A3 - 0.058, 0.004),
            (0.0395, -A3 - 0.02),
        ]
    )
    wrist = moved(
        joint_module(0.0425, -0.040, 0.054, cap=0.014, segments=20), "+z", (A3, 0.0, side)
    )
    ring = placed(seal(0.0395, 0.052, 0.059, segments=20), "+z", (A3, 0.0, side))
    return [*elbow, ("tube", placed(tube, "-x", (0.0, 0.0, side))), *wrist, ("ring", ring)]


def wrist_module(neck_length: float, output: str) -> list[Part]:
    """Return a wrist: a neck down to the link before it, and a housing across along ``output``."""
    neck = turned(
        [(0.0390, -neck_length), (0.0415, 0.004 - neck_length), (0.0415, 0.0)],
        segments=20,
        caps="start",
    )
    housing = joint_module(0.0420, -0.041, 0.0445, cap=0.014, segments=20)
    ring = seal(0.0390, 0.0425, 0.0505, segments=20)
    return [
        ("housing", neck),
        *moved(housing, output, (0.0, 0.0, 0.0)),
        ("ring", placed(ring, output)),
    ]


def wrist_3_parts() -> list[Part]:
    """Return the tool flange, whose face is the origin of the link."""
    flange = turned(
        [
            (0.0385, -0.0500),
            (0.0395, -0.0470),
            (0.0395, -0.0110, 0.003),
            (0.0315, -0.0060),
            (0.0315, 0.0),
        ],
        segments=20,
        caps="both",
    )
    return [("tube", flange)]


def gripper_parts() -> list[Part]:
    """Return the gripper's palm: a coupling, a body that widens, and the rail of the fingers."""
    coupling = turned(
        [(0.0375, 0.0), (0.0375, 0.0125, 0.0015), (0.0345, 0.0135)], segments=20, caps="start"
    )
    # The body grows from a disc over the flange into a bar as wide as the fingers' way.
    sections = [
        (0.0130, 0.0335, 0.0345, 0.032),
        (0.0330, 0.0325, 0.0365, 0.026),
        (0.0430, 0.0315, 0.0410, 0.018),
        (0.0620, 0.0280, 0.0600, 0.012),
        (0.0700, 0.0260, 0.0670, 0.010),
        (0.0850, 0.0240, 0.0700, 0.008),
        (0.0890, 0.0215, 0.0680, 0.007),
    ]
    rings = [
        np.column_stack(
            [
                rounded(rectangle((-x, x), (-y, y), radius), closed=True),
                np.full(4 * (ROUND_STEPS + 1), z),
            ]
        )
        for z, x, y, radius in sections
    ]
    body = loft(np.array(rings), cap_start=False, cap_end=True)
    rail = milled(
        rectangle((-0.013, 0.013), (-0.0665, 0.0665)), 0.0885, 0.0945, bevel=0.001, caps="end"
    )
    # A round cover on either broad side, where such grippers carry their linkage.
    cover = turned([(0.0135, 0.0), (0.0135, 0.0060, 0.0012), (0.0, 0.0065)], segments=16)
    covers = [placed(cover, axis, (x, 0.0, 0.040)) for axis, x in (("+x", 0.0275), ("-x", -0.0275))]
    return [
        ("metal", coupling),
        ("body", body),
        ("metal", rail),
        *(("metal", cover) for cover in covers),
    ]


def finger_parts() -> list[Part]:
    """Return the left finger, closed: pad face in the plane y = 0, its body on the side of +y."""
    low, high = TCP_HEIGHT - PAD_HEIGHT / 2, TCP_HEIGHT + PAD_HEIGHT / 2
    carriage = milled(
        rectangle((-0.0175, 0.0175), (0.0010, 0.0330), 0.004), 0.0925, 0.1080, bevel=0.0015
    )
    # Seen along x the finger is a blade that narrows from its carriage to the tip.
    blade = placed(
        milled(
            [
                (0.0035, 0.1060),
                (0.0300, 0.1060),
                (0.0140, low + 0.006, 0.02),
                (0.0105, high, 0.004),
                (0.0035, high, 0.001),
            ],
            -PAD_WIDTH / 2 + 0.0005,
            PAD_WIDTH / 2 - 0.0005,
            bevel=0.0012,
        ),
        "+x",
    )
    pad = placed(
        milled(
            rectangle((-PAD_WIDTH / 2, PAD_WIDTH / 2), (low, high), 0.002),
            0.0,
            0.0040,
            bevel=0.0006,
        ),
        "-y",
        (0.0, 0.0040, 0.0),
    )
    pin = turned([(0.0045, 0.0), (0.0045, 0.0020)], segments=12, caps="end")
    pins = [
        placed(pin, axis, (side * 0.0170, y, 0.10025))
        for axis, side in (("+x", 1.0), ("-x", -1.0))
        for y in (0.0090, 0.0250)
    ]
    return [
        ("body", carriage),
        ("body", blade),
        *(("metal", pin) for pin in pins),
        ("pad", pad),
    ]


def mirrored_parts(parts: Iterable[Part]) -> list[Part]:
    """Mirror every part of a list in y."""
    return [(color, mirrored(mesh)) for color, mesh in parts]


# ---------------------------------------------------------------------------------------------
# The robot
# ---------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Shape:
    """A collision primitive: what it is in URDF, and where it lies in its link."""

    geometry: str
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Link:
    """A link: its mass and inertia about the centre of mass, its shapes and its look."""

    name: str
    mass: float  # kg
    inertia: tuple[float, float, float, float, float, float]  # kg m²: xx, xy, xz, yy, yz, zz
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the inertia's axes
    shapes: tuple[Shape, ...] = ()
    parts: list[Part] = field(default_factory=list)
    is_pad: bool = False


@dataclass(frozen=True)
class Joint:
    """A joint between two links; fixed where it has no axis."""

    name: str
    parent: str
    child: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    kind: str = "fixed"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    speed: float = 0.0


def capsule(radius: float, start: float, end: float) -> str:
    """Return a capsule whose round ends reach from ``start`` to ``end`` along its axis."""
    return f'<capsule radius="{radius:g}" length="{round(end - start - 2 * radius, 6):g}"/>'


def box(x: float, y: float, z: float) -> str:
    """Return a box by its edges."""
    return f'<box size="{x:g} {y:g} {z:g}"/>'


def box_inertia(
    mass: float, x: float, y: float, z: float
) -> tuple[float, float, float, float, float, float]:
    """Return the inertia of an even box about its centre."""
    k = mass / 12
    return (k * (y * y + z * z), 0.0, 0.0, k * (x * x + z * z), 0.0, k * (x * x + y * y))


QUARTER = math.pi / 2
FINGER_BOTTOM = PALM_HEIGHT
FINGER_TOP = TCP_HEIGHT + PAD_HEIGHT / 2
FINGER_MASS = 0.1  # kg; lighter ones take the solver longer to bring to rest
FINGER_CENTER = 0.128


def finger(name: str, side: float) -> Link:
    """Return a finger; ``side`` is +1 for the one at +y and -1 for its mirror image."""
    length = FINGER_TOP - FINGER_BOTTOM
    shape = Shape(
        box(PAD_WIDTH, FINGER_DEPTH, length),
        (0.0, side * FINGER_DEPTH / 2, FINGER_BOTTOM + length / 2),
    )
    return Link(
        name,
        FINGER_MASS,
        box_inertia(FINGER_MASS, 0.026, 0.020, 0.070),
        (0.0, side * 0.011, FINGER_CENTER),
        shapes=(shape,),
        parts=finger_parts() if side > 0 else mirrored_parts(finger_parts()),
        is_pad=True,
    )


def links() -> list[Link]:
    """Return all links, base first. One capsule a housing or tube: few contacts, cheap steps."""
    along_x = (0.0, QUARTER, 0.0)
    along_y = (QUARTER, 0.0, 0.0)
    return [
        Link(
            "base_link",
            4.0,
            (0.00443333156, 0.0, 0.0, 0.00443333156, 0.0, 0.0072),
            shapes=(Shape('<cylinder radius="0.0745" length="0.1"/>', (0.0, 0.0, 0.05)),),
            parts=base_parts(),
        ),
        Link(
            "shoulder_link",
            3.761,
            (0.00700210, 0.00000073, -0.00001053, 0.00648091, 0.00049994, 0.00657286),
            (0.0, -0.00193, -0.02561),
            (QUARTER, 0.0, 0.0),
            (Shape(capsule(0.062, -0.071, 0.081), (0.0, 0.005, 0.0), along_y),),
            shoulder_parts(),
        ),
        Link(
            "upper_arm_link",
            8.058,
            (0.01505885, -0.00005400, 0.00000563, 0.33388086, -0.00000181, 0.33247207),
            (-0.2125, 0.0, 0.11336),
            shapes=(
                Shape(
                    capsule(0.060, 0.0, 0.425 + 0.118),
                    (A2 / 2, 0.0, UPPER_ARM_SIDE - 0.004),
                    along_x,
                ),
            ),
            parts=upper_arm_parts(),
        ),
        Link(
            "forearm_link",
            2.846,
            (0.00399632, -0.00001365, 0.00137272, 0.07879254, -0.00000660, 0.07848510),
            (-0.2422, 0.0, 0.0265),
            shapes=(
                Shape(capsule(0.057, -0.058, 0.072), (0.0, 0.0, FOREARM_SIDE + 0.003)),
                Shape(
                    capsule(0.0425, 0.0, 0.3922 + 0.045),
                    (A3 / 2 - 0.022, 0.0, FOREARM_SIDE),
                    along_x,
                ),
            ),
            parts=forearm_parts(),
        ),
        Link(
            "wrist_1_link",
            1.37,
            (0.00165491, -0.00000282, -0.00000438, 0.00135962, 0.00010157, 0.00126279),
            (0.0, -0.01634, -0.0018),
            (QUARTER, 0.0, 0.0),
            (Shape(capsule(0.042, 0.0, 0.170), (0.0, 0.0, -0.043)),),
            wrist_module(0.0685, "-y"),
        ),
        Link(
            "wrist_2_link",
            1.3,
            (0.00135617, -0.00000274, 0.00000444, 0.00127827, -0.00005048, 0.00096614),
            (0.0, 0.01634, -0.0018),
            (-QUARTER, 0.0, 0.0),
            (Shape(capsule(0.042, 0.0, 0.1520), (0.0, 0.0, -0.034)),),
            wrist_module(0.0500, "+y"),
        ),
        Link(
            "wrist_3_link",
            0.365,
            (0.00018694, 0.00000006, -0.00000017, 0.00018908, -0.00000092, 0.00025756),
            (0.0, 0.0, -0.001159),
            shapes=(Shape(capsule(0.040, -0.155, 0.002), (0.0, 0.0, -0.0765)),),
            parts=wrist_3_parts(),
        ),
        Link(
            "gripper",
            0.75,
            box_inertia(0.75, 0.060, 0.090, 0.095),
            (0.0, 0.0, 0.046),
            shapes=(
                Shape(box(0.060, 0.136, PALM_HEIGHT - 0.010), (0.0, 0.0, PALM_HEIGHT / 2 - 0.005)),
            ),
            parts=gripper_parts(),
        ),
        finger("left_finger", 1.0),
        finger("right_finger", -1.0),
        # A frame without a body. PyBullet gives a link without an inertial a mass of 1 kg, so it
        # says that it weighs next to nothing.
        Link("tcp", 0.001, (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)),
    ]


def turning(
    name: str,
    parent: str,
    child: str,
    xyz: tuple[float, float, float],
    rpy: tuple[float, float, float],
    effort: float,
    reach: float = 2 * math.pi,
) -> Joint:
    """Return a joint of the arm."""
    return Joint(
        name, parent, child, xyz, rpy, "revolute", (0.0, 0.0, 1.0), -reach, reach, effort, MAX_SPEED
    )


def sliding(name: str, child: str, side: float) -> Joint:
    """Return a finger's joint: 0 is closed, and it opens outward along ``side`` times y."""
    return Joint(
        name,
        "gripper",
        child,
        (0.0, 0.0, 0.0),
        kind="prismatic",
        axis=(0.0, side, 0.0),
        lower=0.0,
        upper=FINGER_TRAVEL,
        effort=60.0,
        speed=0.15,
    )


def joints() -> list[Joint]:
    """Return all joints, base to tool."""
    pi = math.pi
    return [
        turning("shoulder_pan_joint", "base_link", "shoulder_link", (0, 0, D1), (0, 0, pi), 150),
        turning(
            "shoulder_lift_joint", "shoulder_link", "upper_arm_link", (0, 0, 0), (pi / 2, 0, 0), 150
        ),
        turning("elbow_joint", "upper_arm_link", "forearm_link", (A2, 0, 0), (0, 0, 0), 150, pi),
        turning("wrist_1_joint", "forearm_link", "wrist_1_link", (A3, 0, D4), (0, 0, 0), 28),
        turning("wrist_2_joint", "wrist_1_link", "wrist_2_link", (0, -D5, 0), (pi / 2, 0, 0), 28),
        turning("wrist_3_joint", "wrist_2_link", "wrist_3_link", (0, D6, 0), (-pi / 2, 0, 0), 28),
        # Turned on the flange so that with wrist 3 at zero and the tool down, the fingers close
        # sideways and the x axis of the tcp points forward.
        Joint("gripper_joint", "wrist_3_link", "gripper", (0, 0, 0), (0, 0, -pi / 2)),
        sliding("left_finger_joint", "left_finger", 1.0),
        sliding("right_finger_joint", "right_finger", -1.0),
        Joint("tcp_joint", "gripper", "tcp", (0, 0, TCP_HEIGHT)),
    ]


def numbers(values: Iterable[float]) -> str:
    """Return numbers as URDF wants them, ten significant digits and no minus zero."""
    return " ".join(f"{value + 0.0:.10g}" for value in values)


def origin(xyz: Iterable[float], rpy: Iterable[float]) -> str:
    """Return an origin element."""
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'


def mesh_name(link: Link, color: str) -> str:
    """Return the file name of a link's parts of one colour."""
    return f"{link.name.removesuffix('_link')}_{color}.obj"


def link_lines(link: Link) -> list[str]:
    """Return a link's URDF."""
    keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    inertia = " ".join(f'{k}="{v:.9g}"' for k, v in zip(keys, link.inertia, strict=True))
    lines = [
        f'  <link name="{link.name}">',
        "    <inertial>",
        f"      {origin(link.center, link.rpy)}",
        f'      <mass value="{link.mass:g}"/>',
        f"      <inertia {inertia}/>",
        "    </inertial>",
    ]
    for color in dict.fromkeys(color for color, _ in link.parts):
        lines += [
            "    <visual>",
            f'      <geometry><mesh filename="meshes/{mesh_name(link, color)}"/></geometry>',
            f'      <material name="{color}"/>',
            "    </visual>",
        ]
    if link.is_pad:
        # An anchored friction holds what it grips; without it a grasp creeps by a millimetre and
        # two degrees a second, because the solver stops short of convergence.
        lines += [
            "    <contact>",
            f'      <lateral_friction value="{PAD_FRICTION:g}"/>',
            "      <friction_anchor/>",
            "    </contact>",
        ]
    for shape in link.shapes:
        lines += [
            "    <collision>",
            f"      {origin(shape.xyz, shape.rpy)}",
            f"      <geometry>{shape.geometry}</geometry>",
            "    </collision>",
        ]
    return [*lines, "  </link>"]


def joint_lines(joint: Joint) -> list[str]:
    """Return a joint's URDF."""
    lines = [
        f'  <joint name="{joint.name}" type="{joint.kind}">',
        f"    {origin(joint.xyz, joint.rpy)}",
        f'    <parent link="{joint.parent}"/>',
        f'    <child link="{joint.child}"/>',
    ]
    if joint.kind != "fixed":
        lines += [
            f'    <axis xyz="{numbers(joint.axis)}"/>',
            f'    <limit lower="{joint.lower:.10g}" upper="{joint.upper:.10g}"'
            f' effort="{joint.effort:g}" velocity="{joint.speed:.10g}"/>',
        ]
    return [*lines, "  </joint>"]


def urdf_text() -> str:
    """Return the whole robot as URDF."""
    lines = [
        '<?xml version="1.0"?>',
        "<!-- Written by generate.py; change it there. Metres, kilograms, radians. -->",
        '<robot name="ur5e">',
    ]
    for name, rgb in COLORS.items():
        lines.append(f'  <material name="{name}"><color rgba="{numbers(rgb)} 1"/></material>')
    for link in links():
        lines += link_lines(link)
    for joint in joints():
        lines += joint_lines(joint)
    return "\n".join([*lines, "</robot>"]) + "\n"


def generated_files() -> dict[str, str]:
    """Return every generated file's text by its path relative to this folder."""
    files = {"ur5e.urdf": urdf_text()}
    for link in links():
        for color in dict.fromkeys(color for color, _ in link.parts):
            mesh = merged(mesh for c, mesh in link.parts if c == color)
            files[f"meshes/{mesh_name(link, color)}"] = obj_text(mesh, f"{link.name}, {color}")
    return files


def main() -> None:
    """Write all files into the folder given, by default this one."""
    parser = argparse.ArgumentParser(description="Generate the UR5e's URDF and meshes.")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent)
    output: Path = parser.parse_args().output
    files = generated_files()
    meshes = output / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    for stale in sorted(meshes.glob("*.obj")):
        if f"meshes/{stale.name}" not in files:
            stale.unlink()
    for name, text in files.items():
        (output / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
