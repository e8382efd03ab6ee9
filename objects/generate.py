"""Generate the household shelf: the objects of this folder.

Run it as ``python objects/generate.py``; it writes the meshes, pictures and files of every object,
byte for byte the same on every run. Lengths are in metres; each object stands on z = 0.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from modelling import (
    Picture,
    Pieces,
    Point,
    Ring,
    Surface,
    Vec3,
    Weight,
    arc,
    circle,
    moved,
    rounded,
    shown,
    weight,
)

FOLDER = Path(__file__).resolve().parent

WHITE, CREAM, BLACK = "f4f3ee", "efe6cf", "26272b"
STEEL, DARK_STEEL = "b9bec4", "7d838b"


@dataclass
class Body:
    """A rigid body: what is seen of it, and what is touched.

    Attributes:
        look: Its faces.
        pieces: Its convex pieces.
        mass: In kg; of a link of an articulated object.
    """

    look: Surface = field(default_factory=Surface)
    pieces: Pieces = field(default_factory=Pieces)
    mass: float = 0.0


@dataclass
class Joint:
    """A joint of an articulated object.

    Attributes:
        name: Its name.
        kind: ``revolute`` or ``prismatic``.
        ends: Names of the links above and below it.
        at: Its place in the frame of the link above.
        axis: Unit vector.
        limits: Least and greatest position, rad or m.
        mimic: Joint that it follows, and by what factor.
    """

    name: str
    kind: str
    ends: tuple[str, str]
    at: Vec3
    axis: Vec3
    limits: tuple[float, float]
    mimic: tuple[str, float] | None = None


@dataclass
class Thing:
    """An object of the shelf.

    Attributes:
        name: Its name.
        summary: What it is.
        mass: In kg; of an object without joints.
        grasps: What the file says of each grasp point, by name.
        friction: Coefficient.
        picture: Its texture.
        bodies: Its links by name; one for an object without joints.
        joints: Its joints.
        extra: More lines of its file.
    """

    name: str
    summary: str
    mass: float
    grasps: Mapping[str, str]
    friction: float = 0.8
    picture: Picture = field(default_factory=Picture)
    bodies: dict[str, Body] = field(default_factory=dict)
    joints: list[Joint] = field(default_factory=list)
    extra: Sequence[str] = ()

    def body(self, name: str = "", mass: float = 0.0) -> Body:
        """A new body of it."""
        return self.bodies.setdefault(name, Body(mass=mass))

    def write(self) -> None:
        """Write its folder."""
        folder = FOLDER / self.name
        folder.mkdir(exist_ok=True)
        for part, body in self.bodies.items():
            stem = f"{self.name}_{part}" if part else self.name
            look = body.look.obj(stem, self.name, self.picture)
            (folder / f"{stem}.obj").write_text(look, encoding="utf-8")
            (folder / f"{stem}_pieces.obj").write_text(body.pieces.obj(), encoding="utf-8")
        (folder / f"{self.name}.png").write_bytes(self.picture.png())
        material = f"newmtl look\nKd 1 1 1\nmap_Kd {self.name}.png\n"
        (folder / f"{self.name}.mtl").write_text(material, encoding="utf-8")
        if self.joints:
            (folder / f"{self.name}.urdf").write_text(self._urdf(), encoding="utf-8")
        (folder / "object.yaml").write_text(self._yaml(), encoding="utf-8")

    def _yaml(self) -> str:
        pieces = f"{self.name}_pieces.obj"
        shape = (
            f"shape: {{urdf: {self.name}.urdf}}"
            if self.joints
            else f"shape: {{mesh: {self.name}.obj, collision: {pieces}, collide: pieces}}"
        )
        lines = [f"object: {self.name}", f"summary: {self.summary}", shape]
        lines += [] if self.joints else [f"mass: {self.mass:g}"]
        lines += [f"friction: {self.friction:g}", *self.extra]
        if self.grasps:
            lines += ["grasps:", *(f"  {name}: {{{how}}}" for name, how in self.grasps.items())]
        return "\n".join([*lines, ""])

    def _urdf(self) -> str:
        lines = ['<?xml version="1.0"?>', f'<robot name="{self.name}">']
        for name, body in self.bodies.items():
            lines += _link(f"{self.name}_{name}", name, weight(body.pieces, body.mass))
        for joint in self.joints:
            lines += _joint(joint)
        return "\n".join([*lines, "</robot>", ""])


def _link(stem: str, name: str, how: Weight) -> list[str]:
    entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2)}
    entries["izz"] = (2, 2)
    inertia = " ".join(f'{key}="{how.tensor[at] + 0.0:.4g}"' for key, at in entries.items())
    return [
        f'  <link name="{name}">',
        f'    <inertial><origin xyz="{shown(how.center)}"/><mass value="{how.mass:g}"/>'
        f"<inertia {inertia}/></inertial>",
        f'    <visual><geometry><mesh filename="{stem}.obj"/></geometry></visual>',
        f'    <collision><geometry><mesh filename="{stem}_pieces.obj"/></geometry></collision>',
        "  </link>",
    ]


def _joint(joint: Joint) -> list[str]:
    low, high = joint.limits
    mimic = ""
    if joint.mimic:
        mimic = f'<mimic joint="{joint.mimic[0]}" multiplier="{joint.mimic[1]:.6g}"/>'
    return [
        f'  <joint name="{joint.name}" type="{joint.kind}">',
        f'    <parent link="{joint.ends[0]}"/><child link="{joint.ends[1]}"/>',
        f'    <origin xyz="{shown(joint.at)}"/><axis xyz="{shown(joint.axis)}"/>',
        f'    <limit lower="{low:.5g}" upper="{high:.5g}" effort="50" velocity="10"/>{mimic}',
        "  </joint>",
    ]


# --- dishes


def mug() -> Thing:
    """A mug."""
    thing = Thing(
        "mug",
        "A mug with a handle, 90 mm high.",
        0.28,
        {
            "grasp": "at: [0, 0, 0.07], across: y",
            "rim": "at: [0, 0.034, 0.078], across: y",
            "handle": "at: [0.054, 0, 0.048], across: y",
            "inside": "at: [0, 0, 0.03], across: y",
        },
    )
    red, white = thing.picture.swatch("d2443a"), thing.picture.swatch(WHITE)
    body = thing.body()
    profile = [(0.0, 0.0), (0.028, 0.0), (0.033, 0.003), (0.036, 0.012), (0.036, 0.072)]
    profile += [(0.036, 0.088), (0.0345, 0.09), (0.033, 0.088), (0.032, 0.012), (0.026, 0.006)]
    profile += [(0.0, 0.006)]
    body.look.lathe(profile, lambda _, i: red if i <= 3 else white, 36)
    path = arc((0.034, 0.048), (0.027, 0.026), (80, -80), 13)
    body.look.tube(path, (0.0055, 0.004), red)
    body.pieces.round([(0.034, 0.0), (0.034, 0.007)])
    body.pieces.wall((0.036, 0.036), (0.032, 0.032), (0.006, 0.09))
    body.pieces.bar(path[::2], (0.0055, 0.004))
    return thing


def cup() -> Thing:
    """A cup."""
    thing = Thing(
        "cup",
        "A cup without a handle, 100 mm high, wider at the top.",
        0.12,
        {
            "grasp": "at: [0, 0, 0.08], across: y",
            "rim": "at: [0, 0.034, 0.088], across: y",
            "inside": "at: [0, 0, 0.03], across: y",
        },
    )
    draw = thing.picture.swatch
    teal, light, band = draw("1f9aa0"), draw("d9eeee"), draw("f3c04b")
    body = thing.body()
    profile = [(0.0, 0.0), (0.026, 0.0), (0.0275, 0.002), (0.0325, 0.068), (0.0335, 0.08)]
    profile += [(0.035, 0.1), (0.0335, 0.1), (0.026, 0.006), (0.0, 0.005)]
    body.look.lathe(profile, lambda _, i: band if i == 3 else teal if i <= 4 else light, 36)
    body.pieces.round([(0.026, 0.0), (0.027, 0.006)])
    body.pieces.wall((0.0275, 0.0355), (0.0235, 0.0315), (0.005, 0.1))
    return thing


def bowl() -> Thing:
    """A bowl."""
    thing = Thing(
        "bowl",
        "A bowl, 140 mm wide.",
        0.3,
        {
            "grasp": "at: [0, 0.067, 0.06], across: y",
            "rim": "at: [0.067, 0, 0.06], across: x",
            "left": "at: [-0.067, 0, 0.06], across: x",
            "inside": "at: [0, 0, 0.02], across: y",
        },
    )
    draw = thing.picture.swatch
    blue, white, foot = draw("2f5fa8"), draw(WHITE), draw("d8d6ce")
    body = thing.body()
    out = [(0.036, 0.006), (0.05, 0.014), (0.061, 0.028), (0.067, 0.044), (0.07, 0.06)]
    inner = [(0.066, 0.06), (0.063, 0.045), (0.057, 0.03), (0.046, 0.017), (0.03, 0.009)]
    profile = [(0.0, 0.0), (0.034, 0.0), *out, *inner, (0.0, 0.007)]
    body.look.lathe(profile, lambda _, i: foot if i <= 1 else blue if i <= 5 else white, 40)
    body.pieces.round([(0.036, 0.0), (0.036, 0.008)])
    body.pieces.wall((0.037, 0.052), (0.024, 0.046), (0.004, 0.018))
    body.pieces.wall((0.053, 0.064), (0.047, 0.059), (0.015, 0.036))
    body.pieces.wall((0.065, 0.0705), (0.06, 0.0655), (0.033, 0.06))
    return thing


def plate() -> Thing:
    """A plate."""
    thing = Thing(
        "plate",
        "A dinner plate, 220 mm wide.",
        0.4,
        {
            "grasp": "at: [0, -0.1, 0.017], approach: +y, across: z",
            "left": "at: [-0.1, 0, 0.017], approach: +x, across: z",
            "right": "at: [0.1, 0, 0.017], approach: -x, across: z",
            "middle": "at: [0, 0, 0.012], across: y",
        },
    )
    draw = thing.picture.swatch
    white, blue, foot = draw(WHITE), draw("35609c"), draw("e2dfd6")
    body = thing.body()
    profile = [(0.0, 0.001), (0.06, 0.0), (0.066, 0.003), (0.08, 0.009), (0.108, 0.016)]
    profile += [(0.11, 0.018), (0.108, 0.02), (0.1, 0.0183), (0.096, 0.0174), (0.08, 0.014)]
    profile += [(0.07, 0.009), (0.064, 0.007), (0.0, 0.006)]
    body.look.lathe(
        profile, lambda _, i: foot if i <= 2 else blue if i in (4, 5, 6, 8) else white, 48
    )
    body.pieces.round([(0.066, 0.0), (0.066, 0.007)], 16)
    body.pieces.wall((0.068, 0.082), (0.05, 0.07), (0.003, 0.014))
    body.pieces.wall((0.083, 0.11), (0.068, 0.1), (0.008, 0.02))
    return thing


# --- what food comes in


def _around(
    body: Body,
    radius: float,
    heights: tuple[float, float],
    drawing: Sequence[Sequence[tuple[int, int]]],
) -> None:
    """A drawing around a cylinder, from its lower to its upper height."""
    drawing = [[*row[-2:], *row[:-2]] for row in drawing]  # its middle towards -y
    rows, columns = len(drawing), len(drawing[0])
    rings = [
        circle(radius, heights[0] + (heights[1] - heights[0]) * i / rows, columns)
        for i in range(rows + 1)
    ]
    body.look.loft(rings, lambda j, i: drawing[rows - 1 - i][j])


def bottle() -> Thing:
    """A bottle."""
    thing = Thing(
        "bottle",
        "A full bottle with a label and a cap, 230 mm high.",
        0.5,
        {
            "grasp": "at: [0, 0, 0.212], across: y",
            "neck": "at: [0, 0, 0.212], across: x",
            "side": "at: [0, 0, 0.1], approach: +x, across: y",
            "cap": "at: [0, 0, 0.226], across: y",
        },
    )
    draw = thing.picture.swatch
    glass, cap = draw("3c7a4a"), draw("d8a93a")
    dark = draw("2f6340")
    rows = [
        "rrrrrrrrrrrrrrrrrrrrrrrrrrrrrrrr",
        "cccccccccccccccccccccccccccccccc",
        "cccccgggcccccccccccccgggcccccccc",
        "ccccgggggcccccccccccgggggccccccc",
        "ccccgggggcccccccccccgggggccccccc",
        "cccccgggcccccccccccccgggcccccccc",
        "cccccccccccccccccccccccccccccccc",
        "cckkkkkkkkkccccccckkkkkkkkkccccc",
        "cccccccccccccccccccccccccccccccc",
        "rrrrrrrrrrrrrrrrrrrrrrrrrrrrrrrr",
    ]
    colors = {"r": "b8322f", "c": CREAM, "g": "e0a63c", "k": "4a3b34"}
    label = thing.picture.drawing(rows, colors)
    body = thing.body()
    low = [(0.0, 0.0), (0.03, 0.0), (0.033, 0.004), (0.033, 0.04)]
    body.look.lathe(low, glass, 32)
    _around(body, 0.033, (0.04, 0.115), label)
    high = [(0.033, 0.115), (0.033, 0.135), (0.029, 0.152), (0.019, 0.168), (0.0135, 0.18)]
    high += [(0.013, 0.208), (0.0145, 0.21), (0.0145, 0.23), (0.0125, 0.232), (0.0, 0.232)]
    body.look.lathe(high, lambda _, i: cap if i >= 5 else dark if i == 4 else glass, 32)
    body.pieces.round([(0.033, 0.0), (0.033, 0.14)])
    body.pieces.round([(0.0325, 0.137), (0.0145, 0.18)])
    body.pieces.round([(0.0145, 0.175), (0.0145, 0.232)])
    return thing


def can() -> Thing:
    """A can."""
    thing = Thing(
        "can",
        "A full drinks can, 116 mm high.",
        0.36,
        {
            "grasp": "at: [0, 0, 0.095], across: y",
            "side": "at: [0, 0, 0.058], approach: +x, across: y",
            "top": "at: [0, 0, 0.116], across: y",
        },
    )
    draw = thing.picture.swatch
    steel, dark = draw("c6cace"), draw(DARK_STEEL)
    rows = [
        "rrrrrrrrrrrrrrrrrrrrrrrrrrrrrrrr",
        "rrrrrrrwwwrrrrrrrrrrrrrwwwrrrrrr",
        "rrrrrrwwwwwrrrrrrrrrrrwwwwwrrrrr",
        "rrrrrwwyyywwrrrrrrrrrwwyyywwrrrr",
        "rrrrrwwyyywwrrrrrrrrrwwyyywwrrrr",
        "rrrrrrwwwwwrrrrrrrrrrrwwwwwrrrrr",
        "rrrrrrrwwwrrrrrrrrrrrrrwwwrrrrrr",
        "wrrrrrrrrrrrwwwwwrrrrrrrrrrrwwww",
        "wwwrrrrrrrwwwwwwwwwrrrrrrrwwwwww",
        "rwwwwwwwwwwwwrrrwwwwwwwwwwwwwrrr",
        "rrrwwwwwwwwrrrrrrrwwwwwwwwrrrrrr",
    ]
    label = thing.picture.drawing(rows, {"r": "c7252b", "w": WHITE, "y": "f2b632"})
    body = thing.body()
    body.look.lathe(
        [(0.0, 0.004), (0.02, 0.004), (0.024, 0.0), (0.028, 0.002), (0.033, 0.011)], steel, 32
    )
    _around(body, 0.033, (0.011, 0.103), label)
    top = [(0.033, 0.103), (0.028, 0.113), (0.0275, 0.116), (0.0255, 0.116), (0.025, 0.112)]
    body.look.lathe([*top, (0.0, 0.112)], steel, 32)
    body.look.box((0.022, 0.012, 0.002), (-0.006, 0, 0.1135), dark)
    body.look.box((0.012, 0.014, 0.0012), (0.013, 0, 0.1125), draw("9aa0a6"))
    body.pieces.round([(0.029, 0.0), (0.033, 0.012)])
    body.pieces.round([(0.033, 0.01), (0.033, 0.105)])
    body.pieces.round([(0.033, 0.1), (0.0285, 0.116)])
    return thing


def jar() -> Thing:
    """A jar with a screw lid."""
    thing = Thing(
        "jar",
        "A jar, 110 mm high, whose lid rises by 8 mm in one and a half turns; joint screw.",
        0.0,
        {
            "grasp": "at: [0, 0, 0.05], across: y",
            "lid_grip": "at: [0, 0, 0.009], link: lid, across: y",
            "side": "at: [0, 0, 0.045], approach: +x, across: y",
            "inside": "at: [0, 0, 0.03], across: y",
        },
        extra=("joints: {screw: {friction: 0.02}, rise: {friction: 0}}",),
    )
    draw = thing.picture.swatch
    glass, jam, red, dark = draw("e9d9b4"), draw("c0692f"), draw("c23b34"), draw("8f2a26")
    rows = [
        "gggggggggggggggggggggggggggggggg",
        "ggcccccccccccgggggcccccccccccggg",
        "ggcccccoocccccgggccccccoocccccgg",
        "ggccccoooocccggggcccccoooocccggg",
        "ggccccoooocccggggcccccoooocccggg",
        "ggcccccooccccggggccccccooccccggg",
        "ggcckkkkkkkccggggccckkkkkkkccggg",
        "ggcccccccccccgggggcccccccccccggg",
        "gggggggggggggggggggggggggggggggg",
    ]
    colors = {"g": "c0692f", "c": CREAM, "o": "d98b2b", "k": "5b4636"}
    label = thing.picture.drawing(rows, colors)
    body = thing.body("glass", 0.35)
    outer = [(0.0, 0.0), (0.03, 0.0), (0.034, 0.004), (0.035, 0.012)]
    body.look.lathe(outer, glass, 32)
    _around(body, 0.035, (0.012, 0.07), label)
    inner = [(0.035, 0.07), (0.034, 0.08), (0.03, 0.088), (0.03, 0.098), (0.027, 0.098)]
    body.look.lathe(
        [*inner, (0.027, 0.085), (0.031, 0.074), (0.031, 0.006), (0, 0.005)],
        lambda _, i: jam if i >= 6 else glass,
        32,
    )
    body.pieces.round([(0.034, 0.0), (0.035, 0.006)])
    body.pieces.wall((0.035, 0.035), (0.031, 0.031), (0.005, 0.08))
    body.pieces.wall((0.0335, 0.031), (0.029, 0.027), (0.079, 0.098))
    carrier = thing.body("ring", 0.01)
    carrier.look.lathe(
        [(0.0335, 0.0), (0.0345, 0.0), (0.0345, 0.002), (0.0335, 0.002), (0.0335, 0.0)], dark, 32
    )
    carrier.pieces.round([(0.0335, 0.013), (0.0335, 0.016)])
    lid = thing.body("lid", 0.05)
    profile = [(0.0, 0.016), (0.032, 0.012), (0.032, 0.0), (0.0365, 0.001), (0.0365, 0.016)]
    profile += [(0.035, 0.018), (0.0, 0.0185)]
    lid.look.lathe(profile, lambda j, i: dark if i == 3 and j % 2 else red, 40)
    lid.pieces.round([(0.0365, 0.011), (0.0365, 0.0185)])
    lid.pieces.wall((0.0365, 0.0365), (0.0335, 0.0335), (0.001, 0.012))
    turns = 1.5 * 2 * math.pi
    thing.joints = [
        Joint(
            "rise",
            "prismatic",
            ("glass", "ring"),
            (0, 0, 0.088),
            (0, 0, 1),
            (0.0, 0.008),
            ("screw", 0.008 / turns),
        ),
        Joint("screw", "revolute", ("ring", "lid"), (0, 0, 0), (0, 0, 1), (0.0, turns)),
    ]
    return thing


# --- containers


def _open_box(
    body: Body,
    inner: Point,
    wall: float,
    *,
    floor: float | None = None,
    at: Point = (0, 0, 0),
) -> None:
    """Pieces of a box without a lid around a room of the given size, on z = 0."""
    x, y, z = inner
    base = wall if floor is None else floor
    body.pieces.box((x + 2 * wall, y + 2 * wall, base), moved((0, 0, base / 2), at))
    for side in (-1, 1):
        middle = base + z / 2
        body.pieces.box((wall, y + 2 * wall, z), moved((side * (x + wall) / 2, 0, middle), at))
        body.pieces.box((x, wall, z), moved((0, side * (y + wall) / 2, middle), at))


def box() -> Thing:
    """A box with a hinged lid."""
    thing = Thing(
        "box",
        "A wooden box with a hinged lid, 180 mm by 120 mm; joint hinge.",
        0.0,
        {
            "grasp": "at: [0, 0, 0.05], across: y",
            "lid_front": "at: [0, -0.122, 0.004], link: lid, across: y",
            "knob": "at: [0, -0.129, 0.004], link: lid, across: x",
            "inside": "at: [0, 0, 0.02], across: y",
        },
        extra=("joints: {hinge: {friction: 0.02}}",),
    )
    draw = thing.picture.swatch
    wood, dark, inside, brass = draw("b98550"), draw("8f6236"), draw("d9b98c"), draw("d8b04a")
    body = thing.body("case", 0.45)
    _hollow_box(body.look, (0.09, 0.06), (0.083, 0.053), (0.0, 0.08), 0.007, wood, dark, inside)
    for side in (-0.06, 0.06):
        body.look.box((0.012, 0.003, 0.03), (side, -0.0605, 0.04), dark)
    body.look.box((0.016, 0.003, 0.02), (0, -0.0612, 0.066), brass)
    _open_box(body, (0.166, 0.106, 0.072), 0.007, floor=0.008)
    lid = thing.body("lid", 0.18)
    lid.look.loft(
        [rounded(0.092, 0.062, z, 0.003, (0, -0.06), 1) for z in (0.0005, 0.012)], wood, caps=dark
    )
    lid.look.loft(
        [rounded(0.07, 0.042, z, 0.003, (0, -0.06), 1) for z in (0.012, 0.014)], wood, caps=wood
    )
    lid.look.box((0.02, 0.014, 0.008), (0, -0.129, 0.004), brass)
    for side in (-0.055, 0.055):
        lid.look.box((0.024, 0.012, 0.003), (side, -0.006, 0.0135), brass)
    lid.pieces.box((0.184, 0.124, 0.0115), (0, -0.06, 0.00675))
    lid.pieces.box((0.02, 0.016, 0.01), (0, -0.128, 0.005))
    thing.joints = [
        Joint("hinge", "revolute", ("case", "lid"), (0, 0.06, 0.08), (-1, 0, 0), (0.0, 1.92)),
    ]
    return thing


def _hollow_box(
    look: Surface,
    outer: tuple[float, float],
    inner: tuple[float, float],
    heights: tuple[float, float],
    floor: float,
    side: tuple[int, int],
    rim: tuple[int, int],
    inside: tuple[int, int],
    radius: float = 0.004,
) -> None:
    """A box without a lid, by its half edges outside and inside."""
    low, high = heights
    rings = [
        rounded(*outer, low, radius, n=2),
        rounded(*outer, high, radius, n=2),
        rounded(*inner, high, radius / 2, n=2),
        rounded(*inner, low + floor, radius / 2, n=2),
    ]
    look.loft(rings, lambda _, i: (side, rim, inside)[i])
    look.face(rings[0][::-1], side)
    look.face(rings[-1], inside)


def basket() -> Thing:
    """A basket."""
    thing = Thing(
        "basket",
        "A woven basket with a handle across it, 220 mm by 150 mm.",
        0.3,
        {
            "grasp": "at: [0, 0, 0.19], across: y",
            "rim": "at: [0, -0.0755, 0.104], across: y",
            "inside": "at: [0, 0, 0.04], across: y",
        },
        friction=0.7,
    )
    draw = thing.picture.swatch
    light, dark, rim, inside = draw("d3a660"), draw("b3833f"), draw("9a6c33"), draw("c2944f")
    body = thing.body()
    heights = [0.0, 0.016, 0.032, 0.048, 0.064, 0.08, 0.092]

    def ring(z: float, inset: float) -> Ring:
        grown = 0.09 + 0.02 * z / 0.1 - inset
        return _even(rounded(grown, grown - 0.034, z, 0.03, n=5), 44)

    outer = [ring(z, 0.0) for z in heights]
    body.look.loft(outer, lambda j, i: light if (i + j) % 2 else dark)
    body.look.face(outer[0][::-1], dark)
    edge = [ring(0.092, -0.003), ring(0.1, -0.003), ring(0.1, 0.007), ring(0.09, 0.007)]
    body.look.loft([outer[-1], *edge], rim)
    inner = [ring(0.09, 0.006), ring(0.05, 0.006), ring(0.008, 0.006)]
    body.look.loft(inner, inside)
    body.look.face(inner[-1], inside)
    path = arc((0, 0.09), (0.105, 0.11), (180, 0), 19)
    body.look.tube(path, (0.008, 0.005), lambda _, i: light if i % 2 else rim, count=8)
    body.pieces.box((0.18, 0.115, 0.009), (0, 0, 0.0045))
    for side in (-1, 1):
        _slab(body, [(side * 0.088, 0.0), (side * 0.112, 0.1)], 0.058, 0.078, axis=0)
        _slab(body, [(side * 0.054, 0.0), (side * 0.078, 0.1)], 0.086, 0.112, axis=1)
    body.pieces.bar(path[::3], (0.008, 0.006))
    return thing


def _slab(
    body: Body, line: Sequence[tuple[float, float]], low: float, high: float, *, axis: int
) -> None:
    """A leaning wall of 7 mm: its middle at the bottom and the top, and its half lengths there."""
    rings: list[Ring] = []
    for (out, z), half in zip(line, (low, high), strict=True):
        z += 0.002 if z == 0.0 else -0.001
        ring = []
        for a, b in ((-0.0025, -half), (0.0025, -half), (0.0025, half), (-0.0025, half)):
            point = (out + a, b, z) if axis == 0 else (-b, out + a, z)
            ring.append(point)
        rings.append(ring)
    body.pieces.loft(rings[0], rings[1])


def _even(ring: Ring, count: int) -> Ring:
    """A ring of evenly spaced points along another one."""
    ends = [*ring, ring[0]]
    steps = [math.dist(a, b) for a, b in itertools.pairwise(ends)]
    length, points = sum(steps), []
    for number in range(count):
        left, i = length * number / count, 0
        while left > steps[i]:
            left -= steps[i]
            i += 1
        share = left / steps[i] if steps[i] else 0.0
        a, b = ends[i], ends[i + 1]
        points.append(tuple(p + share * (q - p) for p, q in zip(a, b, strict=True)))
    return [(x, y, z) for x, y, z in points]


def tray() -> Thing:
    """A tray."""
    thing = Thing(
        "tray",
        "A serving tray with two handles, 380 mm by 250 mm.",
        0.6,
        {
            "left": "at: [-0.197, 0, 0.034], across: x",
            "right": "at: [0.197, 0, 0.034], across: x",
            "left_side": "at: [-0.197, 0, 0.036], approach: +x, across: z",
            "right_side": "at: [0.197, 0, 0.036], approach: -x, across: z",
            "middle": "at: [0, 0, 0.008], across: y",
        },
        friction=0.7,
    )
    draw = thing.picture.swatch
    wood, dark, handle = draw("c08a55"), draw("95653a"), draw("3a3f47")
    body = thing.body()
    colors = {"a": "d2a06c", "b": "c99460", "c": "d9a973"}
    planks = thing.picture.drawing(["a", "b", "c", "b", "a", "c", "b", "a"], colors)
    rings = [
        rounded(0.17, 0.105, 0.0, 0.02, n=4),
        rounded(0.19, 0.125, 0.03, 0.025, n=4),
        rounded(0.184, 0.119, 0.03, 0.02, n=4),
        rounded(0.166, 0.101, 0.008, 0.016, n=4),
    ]
    body.look.loft(rings, lambda _, i: (wood, dark, wood)[i])
    body.look.face(rings[0][::-1], dark)
    body.look.face(rings[-1], wood)
    body.look.sheet((-0.155, -0.09, 0.0084), (0.31, 0, 0), (0, 0.18, 0), planks)
    for side in (-1, 1):
        body.look.box((0.012, 0.11, 0.012), (side * 0.197, 0, 0.036), handle)
        for end in (-0.05, 0.05):
            body.look.box((0.026, 0.012, 0.012), (side * 0.187, end, 0.031), handle)
        body.pieces.box((0.013, 0.11, 0.013), (side * 0.197, 0, 0.036))
        for end in (-0.05, 0.05):
            body.pieces.box((0.026, 0.012, 0.012), (side * 0.187, end, 0.031))
        _slab(body, [(side * 0.168, 0.0), (side * 0.187, 0.03)], 0.1, 0.115, axis=0)
        _slab(body, [(side * 0.103, 0.0), (side * 0.122, 0.03)], 0.165, 0.18, axis=1)
    body.pieces.box((0.336, 0.206, 0.008), (0, 0, 0.004))
    return thing


# --- tools


def pan() -> Thing:
    """A frying pan."""
    thing = Thing(
        "pan",
        "A small frying pan, 180 mm wide, with a handle along x.",
        0.4,
        {
            "grasp": "at: [0.118, 0, 0.046], across: y",
            "handle": "at: [0.17, 0, 0.054], across: y",
            "rim": "at: [0, 0.087, 0.03], across: y",
            "inside": "at: [0, 0, 0.015], across: y",
        },
    )
    draw = thing.picture.swatch
    out, inside, rim, handle, bolt = (
        draw("43474d"),
        draw("2c2e32"),
        draw("9aa0a6"),
        draw("1f2023"),
        draw("c9cdd1"),
    )
    body = thing.body()
    profile = [(0.0, 0.0), (0.068, 0.0), (0.075, 0.004), (0.09, 0.038), (0.088, 0.04)]
    profile += [(0.086, 0.038), (0.072, 0.007), (0.066, 0.004), (0.0, 0.004)]
    body.look.lathe(profile, lambda _, i: out if i <= 2 else rim if i <= 4 else inside, 44)
    path = [(0.084, 0, 0.03), (0.098, 0, 0.037), (0.115, 0, 0.042), (0.15, 0, 0.048)]
    path += [(0.19, 0, 0.053), (0.222, 0, 0.054), (0.23, 0, 0.053)]
    body.look.tube(path[:3], (0.009, 0.004), bolt)
    body.look.tube(path[2:], (0.012, 0.0075), handle, count=12)
    body.pieces.round([(0.073, 0.0), (0.075, 0.006)])
    body.pieces.wall((0.076, 0.0905), (0.071, 0.085), (0.004, 0.04))
    body.pieces.bar([path[0], path[2]], (0.009, 0.005))
    body.pieces.bar([path[2], path[3], path[5]], (0.012, 0.0075))
    return thing


def spoon() -> Thing:
    """A spoon."""
    thing = Thing(
        "spoon",
        "A large serving spoon, 230 mm long along x.",
        0.09,
        {
            "grasp": "at: [0.005, 0, 0.026], across: y",
            "handle": "at: [0.045, 0, 0.025], across: y",
            "head": "at: [-0.08, 0, 0.008], across: y",
        },
    )
    draw = thing.picture.swatch
    steel, shade, dark = draw("cfd4d9"), draw("aab0b7"), draw("2b3038")
    body = thing.body()
    rings_out, rings_in = [], []
    for share, z in ((0.25, 0.0), (0.6, 0.002), (0.85, 0.007), (1.0, 0.015)):
        rings_out.append(_ellipse(0.034 * share, 0.024 * share, z, -0.08))
        rings_in.append(_ellipse(0.034 * share * 0.95, 0.024 * share * 0.95, z + 0.0016, -0.08))
    body.look.loft([*rings_out, *rings_in[::-1]], lambda _, i: steel if i <= 3 else shade)
    body.look.face(rings_out[0][::-1], steel)
    body.look.face(rings_in[0], shade)
    path = [(-0.05, 0, 0.0145), (-0.035, 0, 0.019), (-0.01, 0, 0.023), (0.02, 0, 0.0235)]
    path += [(0.06, 0, 0.0185), (0.1, 0, 0.0095), (0.115, 0, 0.0055)]
    body.look.tube(path[:4], (0.0055, 0.0028), steel)
    body.look.tube(path[3:], (0.0085, 0.005), dark)
    body.pieces.loft(
        _ellipse(0.018, 0.012, 0.001, -0.08, 10), _ellipse(0.026, 0.018, 0.003, -0.08, 10)
    )
    for number in range(10):
        a, b = (2 * math.pi * (number + end) / 10 for end in (0.0, 1.0))
        rings = []
        for share, z in ((0.6, 0.004), (0.98, 0.0145)):
            ring = []
            for near, turn in ((share - 0.1, a), (share, a), (share, b), (share - 0.1, b)):
                ring.append(
                    (-0.08 + 0.034 * near * math.cos(turn), 0.024 * near * math.sin(turn), z)
                )
            rings.append(ring)
        body.pieces.loft(rings[0], rings[1])
    body.pieces.bar([path[0], path[2], path[3]], (0.006, 0.004))
    body.pieces.bar([path[3], path[4], path[6]], (0.0085, 0.005))
    return thing


def _ellipse(x: float, y: float, z: float, at: float, count: int = 24) -> Ring:
    turns = [2 * math.pi * number / count for number in range(count)]
    return [(at + x * math.cos(turn), y * math.sin(turn), z) for turn in turns]


def sponge() -> Thing:
    """A sponge."""
    thing = Thing(
        "sponge",
        "A kitchen sponge with a green scouring side up, 110 mm by 70 mm.",
        0.03,
        {
            "grasp": "at: [0, 0, 0.024], across: y",
            "top": "at: [0, 0, 0.04], across: y",
        },
        friction=0.9,
    )
    draw = thing.picture.swatch
    yellow, deep, green = draw("f2c53d"), draw("e3b02e"), draw("3f8f4f")
    body = thing.body()
    heights = (0.0, 0.004, 0.012, 0.02, 0.028)
    insets = (0.004, 0.0, 0.0, 0.0, 0.0)
    rings = [
        _even(rounded(0.055 - inset, 0.034 - inset, z, 0.01, n=4), 48)
        for z, inset in zip(heights, insets, strict=True)
    ]
    body.look.loft(rings, lambda j, i: deep if (7 * j + 3 * i) % 5 == 0 else yellow)
    body.look.face(rings[0][::-1], yellow)
    top = [
        _even(rounded(0.0555 - inset, 0.0345 - inset, z, 0.01, n=4), 48)
        for z, inset in ((0.028, 0.0), (0.038, 0.0), (0.04, 0.002))
    ]
    body.look.loft(top, green)
    body.look.face(top[-1], green)
    rows = ["lgglgglglg", "gglgglgggl", "glgglgglgg", "lgglggglgg", "gglgglglgl"]
    weave = thing.picture.drawing(rows, {"l": "37804a", "g": "459a57"})
    body.look.sheet((-0.047, -0.028, 0.0403), (0.094, 0, 0), (0, 0.056, 0), weave)
    body.pieces.loft(
        rounded(0.0535, 0.0325, 0.001, 0.01, n=2), rounded(0.0535, 0.0325, 0.039, 0.01, n=2)
    )
    return thing


def hammer() -> Thing:
    """A hammer."""
    thing = Thing(
        "hammer",
        "A claw hammer lying on its side, 280 mm long along x.",
        0.5,
        {
            "grasp": "at: [-0.075, 0, 0.026], across: y",
            "handle": "at: [0.06, 0, 0.026], across: y",
            "head": "at: [-0.12, 0, 0.026], across: x",
        },
    )
    draw = thing.picture.swatch
    wood, grip, steel, face = draw("c58b4e"), draw("b0352f"), draw("8a9098"), draw("b9bec4")
    body = thing.body()
    rings = []
    for x, half in ((-0.12, 0.01), (-0.1, 0.011), (-0.02, 0.0115), (0.03, 0.013), (0.04, 0.015)):
        rings.append((x, half))
    for x, half in ((0.1, 0.0155), (0.15, 0.016), (0.158, 0.013)):
        rings.append((x, half))
    skins = [_upright(x, half, half * 0.85, 0.0155) for x, half in rings]
    body.look.loft(skins, lambda _, i: grip if i >= 3 else wood, caps=grip)
    head = [
        (-0.048, 0.0145),
        (-0.036, 0.0145),
        (-0.034, 0.0115),
        (-0.018, 0.0115),
        (-0.015, 0.0155),
    ]
    head += [(0.014, 0.0155), (0.018, 0.012)]
    body.look.loft(
        [_across(y, half, -0.12, 0.0155) for y, half in head],
        lambda _, i: face if i == 0 else steel,
        caps=face,
    )
    for side in (-1, 1):
        claw = []
        for y, drop, wide, tall in (
            (0.014, 0.0, 0.006, 0.0115),
            (0.03, 0.001, 0.006, 0.009),
            (0.048, 0.006, 0.005, 0.006),
            (0.062, 0.014, 0.004, 0.003),
        ):
            x, middle = -0.12 + drop, side * 0.0065
            claw.append(
                [
                    (x - tall, y, 0.0155 + middle - wide),
                    (x - tall, y, 0.0155 + middle + wide),
                    (x + tall, y, 0.0155 + middle + wide),
                    (x + tall, y, 0.0155 + middle - wide),
                ]
            )
        body.look.loft(claw, steel, caps=face)
    body.pieces.box((0.028, 0.064, 0.031), (-0.12, -0.017, 0.0155))
    body.pieces.box((0.016, 0.05, 0.022), (-0.116, 0.036, 0.0155))
    body.pieces.box((0.145, 0.023, 0.02), (-0.035, 0, 0.0155))
    body.pieces.box((0.125, 0.031, 0.031), (0.096, 0, 0.0155))
    return thing


def _upright(x: float, y: float, z: float, middle: float, count: int = 12) -> Ring:
    """A ring in a plane of constant x."""
    turns = [2 * math.pi * number / count for number in range(count)]
    return [(x, y * math.cos(turn), middle + z * math.sin(turn)) for turn in turns]


def _across(y: float, half: float, x: float, middle: float, count: int = 16) -> Ring:
    """A ring in a plane of constant y."""
    turns = [2 * math.pi * number / count for number in range(count)]
    return [(x - half * math.cos(turn), y, middle + half * math.sin(turn)) for turn in turns]


def dustpan() -> Thing:
    """A dustpan."""
    thing = Thing(
        "dustpan",
        "A dustpan that opens towards -x, 230 mm wide, with a handle along x.",
        0.22,
        {
            "grasp": "at: [0.125, 0, 0.036], across: y",
            "handle": "at: [0.18, 0, 0.036], across: y",
            "inside": "at: [-0.02, 0, 0.012], across: y",
            "lip": "at: [-0.1, 0, 0.004], across: y",
        },
        friction=0.6,
    )
    draw = thing.picture.swatch
    blue, deep, gray = draw("2f7fc1"), draw("225f93"), draw("3b4048")
    body = thing.body()
    look = body.look
    floor_low = [(-0.11, -0.115, 0), (0.09, -0.1, 0), (0.09, 0.1, 0), (-0.11, 0.115, 0)]
    floor_high = [moved(point, (0, 0, 0.001 if point[0] < 0 else 0.004)) for point in floor_low]
    look.loft([floor_low, floor_high], blue)
    look.face(floor_low[::-1], blue)
    look.face(floor_high, deep)
    back = [(0.086, -0.1), (0.092, -0.1), (0.092, 0.1), (0.086, 0.1)]
    look.loft([[(x, y, z) for x, y in back] for z in (0.0, 0.055)], blue, caps=blue)
    for side in (-1, 1):
        foot = [
            (-0.105, side * 0.1155),
            (0.092, side * 0.1),
            (0.092, side * 0.096),
            (-0.105, side * 0.111),
        ]
        foot = foot if side < 0 else foot[::-1]
        low = [(x, y, 0.0) for x, y in foot]
        high = [(x, y, 0.055 if x > 0 else 0.008) for x, y in foot]
        look.loft([low, high], blue, caps=blue)
        body.pieces.loft(
            [(x, y, 0.002) for x, y in foot], [(x, y, 0.054 if x > 0 else 0.007) for x, y in foot]
        )
    for edge in range(-3, 4):
        look.box((0.15, 0.004, 0.0016), (-0.005, 0.026 * edge, 0.0042), blue)
    path = [
        (0.088, 0, 0.03),
        (0.105, 0, 0.033),
        (0.14, 0, 0.034),
        (0.19, 0, 0.034),
        (0.22, 0, 0.032),
    ]
    look.tube(path, (0.013, 0.009), lambda _, i: blue if i == 0 else gray, count=12)
    body.pieces.loft(
        [moved(p, (0, 0, 0.001)) for p in floor_low],
        [moved(p, (0, 0, 0.0014 if p[0] < 0 else 0.003)) for p in floor_low],
    )
    body.pieces.box((0.007, 0.2, 0.055), (0.089, 0, 0.0275))
    body.pieces.bar([path[0], path[2], path[4]], (0.013, 0.009))
    return thing


# --- what lies about


def laptop() -> Thing:
    """A laptop."""
    thing = Thing(
        "laptop",
        "A laptop computer, 300 mm by 210 mm, open by 110°; joint hinge, 0 when closed.",
        0.0,
        {
            "screen_top": "at: [0, -0.2, 0.004], link: screen, across: z",
            "screen_edge": "at: [0.148, -0.12, 0.004], link: screen, across: x",
            "left": "at: [-0.15, 0, 0.008], approach: +x, across: z",
            "right": "at: [0.15, 0, 0.008], approach: -x, across: z",
        },
        extra=("joints: {hinge: {start_deg: 110, friction: 0.25}}",),
    )
    draw = thing.picture.swatch
    silver, dark, pad = draw("c3c7cc"), draw("8c9197"), draw("adb2b8")
    base = thing.body("base", 0.9)
    rings = [
        rounded(0.148, 0.103, 0.0, 0.008, n=3),
        rounded(0.15, 0.105, 0.004, 0.01, n=3),
        rounded(0.15, 0.105, 0.0135, 0.01, n=3),
        rounded(0.149, 0.104, 0.014, 0.009, n=3),
    ]
    base.look.loft(rings, silver)
    base.look.face(rings[0][::-1], dark)
    base.look.face(rings[-1], silver)
    keys = ["k" * 13, "k" * 13, "k" * 13, "k" * 13, "kkkk     kkkk"]
    board = thing.picture.swatch("54585e")
    base.look.box((0.264, 0.102, 0.0006), (0, 0.03, 0.0141), board)
    key = thing.picture.swatch("24262a")
    for i, row in enumerate(keys):
        for j, letter in enumerate(row):
            if letter == "k":
                base.look.box(
                    (0.0165, 0.0165, 0.001), (-0.1206 + 0.0201 * j, 0.07 - 0.0201 * i, 0.0149), key
                )
    base.look.box((0.094, 0.0165, 0.001), (0, -0.0104, 0.0149), key)
    base.look.box((0.1, 0.05, 0.0006), (0, -0.062, 0.0141), pad)
    base.pieces.box((0.3, 0.21, 0.0155), (0, 0, 0.00775))
    screen = thing.body("screen", 0.4)
    rows = [
        "ssssssssssssssssssssssss",
        "ssssssssssssssssssssssss",
        "sswwwwwwwwwwwwssssssssss",
        "sswggggggggggwsssyyyysss",
        "sswgbbbgrrrggwsssyyyysss",
        "sswgbbbgrrrggwsssyyyysss",
        "sswggggggggggwssssssssss",
        "sswgkkkkkkkggwssssssssss",
        "sswgkkkkkggggwssssllllss",
        "sswwwwwwwwwwwwssssllllss",
        "ssssssssssssssssssssssss",
        "dddddddddddddddddddddddd",
    ]
    colors = {"s": "2b6cb0", "w": "e8edf2", "g": "fbfcfd", "b": "4aa3df", "r": "e2725b"}
    colors |= {"k": "9aa5b1", "y": "f0c24b", "l": "6cbf84", "d": "1d2733"}
    shown_ = thing.picture.drawing(rows, colors)
    lid = [rounded(0.15, 0.105, z, 0.01, (0, -0.105), 3) for z in (0.0, 0.0075, 0.0085)]
    screen.look.loft(lid, silver)
    screen.look.face(lid[0][::-1], key)
    screen.look.face(lid[-1], silver)
    screen.look.sheet((-0.14, -0.012, -0.0003), (0.28, 0, 0), (0, -0.186, 0), shown_)
    mark = rounded(0.016, 0.016, 0.0088, 0.014, (0, -0.105), 5)
    screen.look.face(mark, dark)
    screen.pieces.box((0.3, 0.21, 0.0105), (0, -0.105, 0.00425))
    thing.joints = [
        Joint("hinge", "revolute", ("base", "screen"), (0, 0.105, 0.0163), (-1, 0, 0), (0.0, 2.4)),
    ]
    return thing


def book() -> Thing:
    """A book."""
    thing = Thing(
        "book",
        "A book of 140 mm by 200 mm, lying on its back cover; its spine is at -x.",
        0.4,
        {
            "grasp": "at: [0, 0.075, 0.0145], approach: -y, across: z",
            "spine": "at: [-0.055, 0, 0.0145], approach: +x, across: z",
            "top": "at: [0, 0, 0.029], across: y",
        },
        friction=0.6,
    )
    draw = thing.picture.swatch
    cover, pages, line = draw("243f6b"), draw("f3ecd8"), draw("d8cfb6")
    rows = [
        "nnnnnnnnnnnnnn",
        "nggggggggggggn",
        "ngnnnnnnnnnngn",
        "ngnwwwwwwwwngn",
        "ngnnnnnnnnnngn",
        "ngnwwwwwwnnngn",
        "ngnnnnnnnnnngn",
        "ngnnnnrrnnnngn",
        "ngnnnrrrrnnngn",
        "ngnnrrrrrrnngn",
        "ngnnrrrrrrnngn",
        "ngnnnrrrrnnngn",
        "ngnnnnrrnnnngn",
        "ngnnnnnnnnnngn",
        "ngnnngggggnngn",
        "ngnnnnnnnnnngn",
        "nggggggggggggn",
        "nnnnnnnnnnnnnn",
    ]
    front = thing.picture.drawing(
        rows, {"n": "243f6b", "g": "d9ae4f", "w": "f3ecd8", "r": "b8423a"}
    )
    side = thing.picture.drawing(
        ["nggnwwwwwwwwnngn"], {"n": "243f6b", "g": "d9ae4f", "w": "f3ecd8"}
    )
    body = thing.body()
    body.look.box((0.14, 0.2, 0.003), (0, 0, 0.0015), cover)
    body.look.box((0.14, 0.2, 0.0028), (0, 0, 0.0274), cover)
    body.look.sheet((-0.07, -0.1, 0.0289), (0.14, 0, 0), (0, 0.2, 0), front)
    body.look.box((0.004, 0.2, 0.0282), (-0.068, 0, 0.0144), cover)
    spine = [[(x, y) for x, y in side[0]][::-1]]
    body.look.sheet((-0.0702, 0.1, 0.003), (0, -0.2, 0), (0, 0, 0.023), spine)
    for i in range(6):
        z = 0.003 + i * 0.00385
        body.look.box((0.131, 0.192, 0.00385), (0.0005, 0, z + 0.0019), line if i % 2 else pages)
    body.pieces.box((0.14, 0.2, 0.029), (0, 0, 0.0145))
    return thing


def shoe() -> Thing:
    """A shoe."""
    thing = Thing(
        "shoe",
        "A trainer, 230 mm long along x, its toe at +x.",
        0.25,
        {
            "grasp": "at: [-0.03, 0, 0.055], across: y",
            "heel": "at: [-0.106, 0, 0.07], across: x",
            "opening": "at: [-0.05, 0, 0.06], across: y",
        },
        friction=0.9,
    )
    draw = thing.picture.swatch
    sole, upper, toe, lining, lace, stripe = (
        draw(WHITE),
        draw("2d6fb6"),
        draw("e9eef2"),
        draw("26466e"),
        draw("fafafa"),
        draw("f08c3a"),
    )
    body = thing.body()

    def outline(inset: float, z: float, rise: float = 0.0) -> Ring:
        ring = []
        for number in range(36):
            turn = 2 * math.pi * number / 36
            x, y = math.cos(turn), math.sin(turn)
            wide = 0.036 + 0.005 * max(x, 0.0) - 0.004 * max(-x, 0.0)
            waist = 1.0 - 0.12 * math.exp(-((x + 0.15) ** 2) / 0.08)
            point = (
                (0.115 - inset) * math.copysign(abs(x) ** 0.9, x),
                (wide - inset) * waist * math.copysign(abs(y) ** 0.75, y),
                z + rise * max(x - 0.55, 0.0) ** 2,
            )
            ring.append(point)
        return ring

    body.look.loft(
        [outline(0.003, 0.0, 0.03), outline(0.0, 0.006, 0.03), outline(0.0, 0.02, 0.02)], sole
    )
    body.look.face(outline(0.003, 0.0, 0.03)[::-1], sole)
    levels = [outline(0.003, 0.02, 0.02)]
    for share, inset in ((0.3, 0.004), (0.55, 0.007), (0.8, 0.012), (1.0, 0.017)):
        ring = []
        for x, y, _ in outline(inset, 0.0):
            high = _instep(x)
            squeeze = 1.0 - 0.25 * share * max(0.0, min(1.0, (x + 0.02) / 0.06))
            ring.append((x, y * squeeze, 0.02 + share * (high - 0.02)))
        levels.append(ring)

    def paint(j: int, i: int) -> tuple[int, int]:
        if j in (0, 1, 34, 35, 2, 33) and i <= 2:
            return toe
        if i in (1, 2) and j in (10, 12, 24, 26):
            return stripe
        return upper

    body.look.loft(levels, paint)
    top = levels[-1]
    count = len(top)
    # The tongue side is closed; the ankle is open.
    for j in range(count // 2):
        a, b = j, j + 1
        c, d = (count - 1 - j) % count, (count - j) % count
        if max(top[a][0], top[b][0]) > -0.012:
            body.look.face((top[a], top[b], top[c], top[d]), upper if top[a][0] > 0.05 else lining)
    inner = [(x * 0.93 - 0.003, y * 0.86, 0.03) for x, y, _ in top]
    ankle = [j for j in range(count) if top[j][0] <= 0.0]
    for j, k in itertools.pairwise(ankle):
        body.look.face((top[k], inner[k], inner[j], top[j])[::-1], lining)
    body.look.face([inner[j] for j in ankle], lining)
    for x in (0.0, 0.016, 0.032, 0.048):
        z = _instep(x) + 0.0015
        body.look.box((0.007, 0.034 - 0.1 * x, 0.004), (x + 0.003, 0, z), lace)
    low = [outline(0.004, z, 0.01)[::3] for z in (0.001, 0.021)]
    body.pieces.loft(low[0], low[1])
    front = [[p for p in outline(0.006, z)[::2] if p[0] > -0.015] for z in (0.019, 0.03)]
    body.pieces.loft(
        front[0],
        [(x * 0.98, y * 0.8, 0.05 if x < 0.03 else _instep(x) - 0.003) for x, y, _ in front[1]],
    )
    for side in (-1, 1):
        body.pieces.box((0.085, 0.005, 0.05), (-0.05, side * 0.0265, 0.045))
    body.pieces.box((0.008, 0.052, 0.055), (-0.1, 0, 0.0475))
    return thing


def _instep(x: float) -> float:
    """Height of the upper of the shoe along it."""
    known = [(-0.115, 0.085), (-0.08, 0.078), (-0.04, 0.07), (0.0, 0.078), (0.03, 0.066)]
    known += [(0.06, 0.05), (0.09, 0.042), (0.115, 0.03)]
    for (a, low), (b, high) in itertools.pairwise(known):
        if x <= b:
            return low + (high - low) * max(0.0, (x - a) / (b - a))
    return known[-1][1]


SHELF = (
    mug,
    cup,
    bowl,
    plate,
    bottle,
    can,
    jar,
    box,
    basket,
    pan,
    spoon,
    tray,
    laptop,
    book,
    shoe,
    sponge,
    hammer,
    dustpan,
)


def main() -> None:
    """Write all objects."""
    for make in SHELF:
        thing = make()
        thing.write()
        count = sum(body.look.triangles for body in thing.bodies.values())
        pieces = sum(len(body.pieces.pieces) for body in thing.bodies.values())
        print(f"{thing.name}: {count} triangles, {pieces} pieces")  # noqa: T201


if __name__ == "__main__":
    main()
