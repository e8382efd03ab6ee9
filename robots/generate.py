"""Generate all robots of the library but the UR5e, which has a generator of its own.

Run it as ``python robots/generate.py``; it rewrites URDFs and meshes, byte for byte the same on
every run. The arms of other makers are written in ``generator/robot_library``, a module each.
``ur5e_pusher``, ``ur5e_suction``, ``gantry`` and ``mobile_ur5e`` are written here: they are built
from the UR5e's parts and from primitives. Their masses and inertias follow from the solids that a
link is made of; the UR5e's links are taken from its URDF as they are, and its meshes from its
folder.
"""

from __future__ import annotations

import importlib
import math
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

# The robot library is data and not imported, so the generator is found by its folder.
sys.path.insert(0, str(Path(__file__).resolve().parent / "generator"))

from robot_library.colors import COLORS
from robot_modelling.modules import robot_files

ROBOTS = Path(__file__).resolve().parent
LIBRARY = ("gen3", "iiwa14", "piper", "sawyer", "so101", "ur10e", "viperx300s", "xarm7")
UR5E = (ROBOTS / "ur5e" / "ur5e.urdf").read_text(encoding="utf-8")

Vec3 = tuple[float, float, float]
ORIGIN: Vec3 = (0.0, 0.0, 0.0)
HAND = ("gripper", "left_finger", "right_finger", "tcp")
EXTRA_COLORS = {
    "frame": (0.72, 0.74, 0.76),
    "shell": (0.93, 0.93, 0.92),
    "rubber": (0.10, 0.10, 0.11),
    "blade": (0.91, 0.49, 0.13),
    "cup": (0.16, 0.36, 0.72),
}


@dataclass(frozen=True)
class Solid:
    """A box or a cylinder of a link, even in density.

    Attributes:
        size: Edges of a box, or radius and length of a cylinder, in m.
        at: Its centre in the link's frame.
        color: Name of its material.
        mass: In kg; 0 for what is only seen.
        axis: Of a cylinder.
        seen: Whether it is drawn.
        solid: Whether it collides.
    """

    size: tuple[float, ...]
    at: Vec3
    color: str
    mass: float = 0.0
    axis: str = "z"
    seen: bool = True
    solid: bool = True

    @property
    def geometry(self) -> str:
        """The shape as URDF has it."""
        if len(self.size) == 3:
            return f'<box size="{numbers(self.size)}"/>'
        radius, length = self.size
        return f'<cylinder radius="{radius:g}" length="{length:g}"/>'

    @property
    def moments(self) -> Vec3:
        """Principal moments about its centre, along the link's axes, in kg m²."""
        if len(self.size) == 3:
            x, y, z = (edge * edge for edge in self.size)
            return (self.mass * (y + z) / 12, self.mass * (x + z) / 12, self.mass * (x + y) / 12)
        radius, length = self.size
        across = self.mass * (3 * radius**2 + length**2) / 12
        along = self.mass * radius**2 / 2
        x, y, z = (along if axis == self.axis else across for axis in "xyz")
        return (x, y, z)


def numbers(values: Iterable[float]) -> str:
    """Return numbers as URDF wants them."""
    return " ".join(f"{round(value, 9) + 0.0:.10g}" for value in values)


def placed(at: Vec3, rpy: Vec3 = ORIGIN) -> str:
    """Return an origin element."""
    return f'<origin xyz="{numbers(at)}" rpy="{numbers(rpy)}"/>'


def link(name: str, solids: Sequence[Solid]) -> str:
    """Return a link made of solids, with the mass and inertia that follow from them."""
    mass = sum(solid.mass for solid in solids)
    center = [sum(s.mass * s.at[i] for s in solids) / mass for i in range(3)]
    tensor = [[0.0] * 3 for _ in range(3)]
    for solid in solids:
        away = [solid.at[i] - center[i] for i in range(3)]
        square = sum(part * part for part in away)
        for i in range(3):
            tensor[i][i] += solid.moments[i] + solid.mass * square
            for j in range(3):
                tensor[i][j] -= solid.mass * away[i] * away[j]
    keys = {
        "ixx": (0, 0),
        "ixy": (0, 1),
        "ixz": (0, 2),
        "iyy": (1, 1),
        "iyz": (1, 2),
        "izz": (2, 2),
    }
    inertia = " ".join(f'{key}="{tensor[i][j] + 0.0:.9g}"' for key, (i, j) in keys.items())
    x, y, z = center
    lines = [
        f'  <link name="{name}">',
        f"    <inertial>{placed((x, y, z))}",
        f'      <mass value="{mass:.6g}"/><inertia {inertia}/></inertial>',
    ]
    turns = {"x": (0.0, math.pi / 2, 0.0), "y": (math.pi / 2, 0.0, 0.0), "z": ORIGIN}
    for solid in solids:
        shape = f"{placed(solid.at, turns[solid.axis])}<geometry>{solid.geometry}</geometry>"
        if solid.seen:
            lines.append(f'    <visual>{shape}<material name="{solid.color}"/></visual>')
        if solid.solid:
            lines.append(f"    <collision>{shape}</collision>")
    return "\n".join([*lines, "  </link>"])


def joint(
    name: str,
    parent: str,
    child: str,
    at: Vec3 = ORIGIN,
    rpy: Vec3 = ORIGIN,
    *,
    slides: Vec3 | None = None,
    turns: Vec3 | None = None,
    limits: tuple[float, float] = (0.0, 0.0),
    effort: float = 0.0,
    speed: float = 0.0,
) -> str:
    """Return a joint; fixed if it neither slides nor turns."""
    axis = slides or turns
    kind = "prismatic" if slides else "revolute" if turns else "fixed"
    lines = [
        f'  <joint name="{name}" type="{kind}">{placed(at, rpy)}',
        f'    <parent link="{parent}"/><child link="{child}"/>',
    ]
    if axis:
        low, high = limits
        lines += [
            f'    <axis xyz="{numbers(axis)}"/>',
            f'    <limit lower="{low:.10g}" upper="{high:.10g}" effort="{effort:g}"'
            f' velocity="{speed:.10g}"/>',
        ]
    return "\n".join([*lines, "  </joint>"])


def of_ur5e(*, arm: bool, hand: bool) -> list[str]:
    """Return links and joints of the UR5e, with its meshes where they are."""
    text = UR5E.replace("meshes/", "../ur5e/meshes/")
    found = []
    for kind in ("link", "joint"):
        for piece in re.findall(rf"  <{kind} .*?\n  </{kind}>", text, re.DOTALL):
            belongs = re.search(
                r'<child link="(.*?)"' if kind == "joint" else r'name="(.*?)"', piece
            )
            of_hand = belongs is not None and belongs.group(1) in HAND
            if hand if of_hand else arm:
                found.append(piece)
    return found


def robot(name: str, pieces: Iterable[str]) -> str:
    """Return a whole robot as URDF."""
    materials = re.findall(r"  <material name=.*</material>", UR5E)
    materials += [
        f'  <material name="{color}"><color rgba="{numbers(rgb)} 1"/></material>'
        for color, rgb in EXTRA_COLORS.items()
    ]
    note = "<!-- Written by generate.py; change it there. Metres, kilograms, radians. -->"
    head = ['<?xml version="1.0"?>', note, f'<robot name="{name}">']
    return "\n".join([*head, *materials, *pieces, "</robot>"]) + "\n"


def on_flange(child: str) -> str:
    """Return the joint that mounts a tool on the UR5e as its gripper is mounted."""
    return joint(f"{child}_joint", "wrist_3_link", child, rpy=(0.0, 0.0, -math.pi / 2))


def pusher() -> str:
    """A paddle across the x axis of the tcp, with its lower edge where fingertips would be."""
    stem = [
        Solid((0.037, 0.012), (0.0, 0.0, 0.006), "metal", 0.12),
        Solid((0.016, 0.09), (0.0, 0.0, 0.057), "body", 0.2),
        Solid((0.03, 0.06, 0.02), (0.0, 0.0, 0.1), "metal", 0.08),
    ]
    paddle = [
        Solid((0.014, 0.16, 0.066), (0.0, 0.0, 0.133), "blade", 0.18),
        Solid((0.018, 0.15, 0.012), (0.0, 0.0, 0.158), "rubber", 0.02, solid=False),
    ]
    tool = [link("stem", stem), link("paddle", paddle)]
    joints = [on_flange("stem"), joint("paddle_joint", "stem", "paddle")]
    return robot("ur5e_pusher", [*of_ur5e(arm=True, hand=False), *tool, *joints])


def suction() -> str:
    """A cup on a tube; its soft lip, as drawn, is 2 mm longer than its collision shape."""
    body = [
        Solid((0.037, 0.012), (0.0, 0.0, 0.006), "metal", 0.12),
        Solid((0.031, 0.055), (0.0, 0.0, 0.0395), "body", 0.4),
        Solid((0.011, 0.04), (0.0, 0.0, 0.087), "metal", 0.06),
    ]
    cup = [
        Solid((0.016, 0.034), (0.0, 0.0, 0.125), "cup", 0.1, seen=False),
        *(Solid((0.017, 0.007), (0.0, 0.0, z), "cup", solid=False) for z in (0.112, 0.124)),
        *(Solid((0.013, 0.006), (0.0, 0.0, z), "cup", solid=False) for z in (0.118, 0.13)),
        Solid((0.019, 0.011), (0.0, 0.0, 0.1385), "cup", solid=False),
    ]
    tool = [link("ejector", body), link("cup", cup)]
    joints = [on_flange("ejector"), joint("cup_joint", "ejector", "cup")]
    return robot("ur5e_suction", [*of_ur5e(arm=True, hand=False), *tool, *joints])


def gantry() -> str:
    """A portal of 1.66 m by 1.3 m, 1.3 m high; the bridge moves along x, the column along z."""
    post, rail, height = 0.06, 0.07, 1.2
    frame = [
        Solid((post, post, height), (x, y, height / 2), "frame", 4.0)
        for x in (-0.8, 0.8)
        for y in (-0.65, 0.65)
    ]
    frame += [Solid((1.66, rail, rail), (0.0, y, height), "metal", 6.0) for y in (-0.65, 0.65)]
    frame += [Solid((post, 1.23, post), (x, 0.0, height), "frame", 4.0) for x in (-0.8, 0.8)]
    bridge = [Solid((0.1, 1.34, 0.09), (0.0, 0.0, 0.1), "shell", 9.0)]
    bridge += [Solid((0.2, 0.1, 0.07), (0.0, y, 0.07), "body", 1.5) for y in (-0.65, 0.65)]
    carriage = [
        Solid((0.07, 0.16, 0.16), (0.09, 0.0, 0.1), "body", 3.0),
        Solid((0.01, 0.1, 0.1), (0.126, 0.0, 0.1), "cap", solid=False),
    ]
    column = [
        Solid((0.06, 0.06, 0.9), (0.17, 0.0, 0.35), "tube", 3.5),
        Solid((0.04, 0.05), (0.17, 0.0, -0.125), "body", 0.8),
    ]
    wrist = [Solid((0.036, 0.03), (0.0, 0.0, 0.015), "metal", 0.3)]
    down = (math.pi, 0.0, 0.0)
    links = [
        link(name, solids)
        for name, solids in (
            ("base_link", frame),
            ("bridge", bridge),
            ("carriage", carriage),
            ("column", column),
            ("wrist", wrist),
        )
    ]
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    top = (0.0, 0.0, height)
    flange = (0.17, 0.0, -0.15)
    joints = [
        joint(
            "x_joint",
            "base_link",
            "bridge",
            top,
            slides=x,
            limits=(-0.68, 0.62),
            effort=600,
            speed=1,
        ),
        joint("y_joint", "bridge", "carriage", slides=y, limits=(-0.5, 0.5), effort=400, speed=1),
        joint("z_joint", "carriage", "column", slides=z, limits=(-0.8, 0.0), effort=500, speed=1),
        joint(
            *("wrist_joint", "column", "wrist", flange, down),
            turns=z,
            limits=(-math.pi, math.pi),
            effort=28,
            speed=math.pi,
        ),
        joint("gripper_joint", "wrist", "gripper", (0.0, 0.0, 0.03)),
    ]
    hand = [piece for piece in of_ur5e(arm=False, hand=True) if '"wrist_3_link"' not in piece]
    return robot("gantry", [*links, *joints, *hand])


def mobile() -> str:
    """A UR5e on a platform that drives in all directions of the floor and turns."""
    wheels = [
        Solid((0.085, 0.05), (x, y, 0.085), "rubber", 1.5, axis="y", solid=False)
        for x in (-0.24, 0.24)
        for y in (-0.24, 0.24)
    ]
    platform = [
        Solid((0.74, 0.46, 0.2), (0.0, 0.0, 0.16), "shell", 45.0),
        Solid((0.7, 0.5, 0.03), (0.0, 0.0, 0.275), "body", 5.0),
        Solid((0.2, 0.2, 0.16), (0.16, 0.0, 0.37), "frame", 8.0),
        Solid((0.012, 0.3, 0.05), (0.37, 0.0, 0.17), "cap", solid=False),
        *wheels,
    ]
    root = [Solid((0.02, 0.02, 0.002), (0.0, 0.0, 0.001), "frame", 1.0, seen=False, solid=False)]
    links = [
        link("footprint", root),
        link("along", root),
        link("aside", root),
        link("platform", platform),
    ]
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    joints = [
        joint(
            "base_x_joint", "footprint", "along", slides=x, limits=(-3, 3), effort=1200, speed=0.8
        ),
        joint("base_y_joint", "along", "aside", slides=y, limits=(-3, 3), effort=1200, speed=0.8),
        joint(
            *("base_yaw_joint", "aside", "platform"),
            turns=z,
            limits=(-2 * math.pi, 2 * math.pi),
            effort=600,
            speed=1.5,
        ),
        joint("arm_joint", "platform", "base_link", (0.16, 0.0, 0.45)),
    ]
    return robot("mobile_ur5e", [*links, *joints, *of_ur5e(arm=True, hand=True)])


def generated_files() -> dict[str, str]:
    """Return every generated file's text by its path relative to this folder."""
    made = {"ur5e_pusher": pusher, "ur5e_suction": suction, "gantry": gantry, "mobile_ur5e": mobile}
    files = {f"{name}/{name}.urdf": make() for name, make in made.items()}
    for name in LIBRARY:
        source = importlib.import_module(f"robot_library.{name}")
        files |= robot_files(name, source.MAKER, COLORS, source.robot())
    return files


def write(files: dict[str, str]) -> None:
    """Write all files, and remove meshes that no robot has any more."""
    folders = {(ROBOTS / file).parent for file in files if file.endswith(".obj")}
    for stale in (mesh for folder in folders for mesh in folder.glob("*.obj")):
        if str(stale.relative_to(ROBOTS)) not in files:
            stale.unlink()
    for file, text in files.items():
        path = ROBOTS / file
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != text.encode():
            path.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    write(generated_files())
