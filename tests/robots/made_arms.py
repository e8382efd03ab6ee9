"""A small arm with a gripper, as a robot file and a URDF, to be made wrong in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
LENGTHS = (0.15, 0.3, 0.3, 0.08, 0.08, 0.06)


@dataclass(frozen=True)
class MadeArm:
    """What is written.

    Attributes:
        effort: Of the joints of the arm, Nm.
        finger_kg: Mass of each finger.
        damping: Of the joints of the fingers, N s/m.
        touching: Whether the fingers have collision shapes.
        stroke: As the robot file declares it, in metres; the fingers open by 85 mm.
        force: Of the gripper, in N.
        tcp: Along z of the last link, in metres.
        closed: Position of the joints of the fingers when they are closed, in metres.
        fingers: How many, evenly around the tcp.
    """

    effort: float = 150.0
    finger_kg: float = 0.05
    damping: float = 0.0
    touching: bool = True
    stroke: float = 0.085
    force: float = 20.0
    tcp: float = 0.115
    closed: float = 0.0
    fingers: int = 2

    def write(self, folder: Path) -> Path:
        """Write the robot into a folder; the path of its robot file."""
        folder.mkdir(parents=True)
        (folder / "arm.urdf").write_text(
            f'<robot name="arm">{self._arm()}{self._fingers()}</robot>'
        )
        file = folder / "robot.yaml"
        file.write_text(self._robot(folder.name))
        return file

    def _robot(self, name: str) -> str:
        joints = ", ".join(f"j{number}" for number in range(1, 7))
        sides = "abc"[: self.fingers]
        ends = "\n".join(
            f"    slide_{side}: {{open: 0.0425, closed: {self.closed}}}" for side in sides
        )
        fingers = ", ".join(f"[finger_{side}]" for side in sides)
        return f"""\
robot: {name}
summary: An arm of six joints with two fingers
urdf: arm.urdf
arm: [{joints}]
tcp: {{link: l6, position: [0, 0, {self.tcp}], rpy_deg: [0, 0, 90]}}
home_deg: [0, -30, 120, 0, 90, 0]
gripper:
  joints:
{ends}
  fingers: [{fingers}]
  stroke: {self.stroke}
  force: {self.force}
"""

    def _arm(self) -> str:
        text = link("l0", 0.05, 0.15, 5.0)
        below = 0.05
        limit = f'<limit lower="-2.9" upper="2.9" effort="{self.effort}" velocity="3"/>'
        for number, (length, axis) in enumerate(zip(LENGTHS, AXES, strict=True), start=1):
            text += link(f"l{number}", length)
            text += joint(f"j{number}", f"l{number - 1}", f"l{number}", below, axis, limit)
            below = length
        return text

    def _fingers(self) -> str:
        text = ""
        limit = '<limit lower="0" upper="0.0425" effort="60" velocity="0.2"/>'
        limit += f'<dynamics damping="{self.damping}"/>'
        for number, side in enumerate("abc"[: self.fingers]):
            yaw = 2.0 * math.pi * number / self.fingers
            text += link(
                f"finger_{side}", 0.07, 0.012, self.finger_kg, 0.006, touching=self.touching
            )
            text += joint(
                f"slide_{side}", "l6", f"finger_{side}", 0.06, "1 0 0", limit, "prismatic", yaw
            )
        return text


def link(
    name: str,
    length: float,
    width: float = 0.06,
    mass: float = 1.0,
    aside: float = 0.0,
    *,
    touching: bool = True,
) -> str:
    """A box along z, from its joint on."""
    across, along = mass * (width**2 + length**2) / 12, mass * width**2 / 6
    shape = f'<origin xyz="{aside} 0 {length / 2}"/>'
    box = f'<geometry><box size="{width} {width} {length}"/></geometry>'
    roles = ("visual", "collision") if touching else ("visual",)
    shapes = "".join(f"<{role}>{shape}{box}</{role}>" for role in roles)
    return (
        f'<link name="{name}"><inertial>{shape}<mass value="{mass}"/>'
        f'<inertia ixx="{across}" iyy="{across}" izz="{along}" ixy="0" ixz="0" iyz="0"/>'
        f"</inertial>{shapes}</link>\n"
    )


def joint(
    name: str,
    parent: str,
    child: str,
    up: float,
    axis: str,
    limit: str,
    kind: str = "revolute",
    yaw: float = 0.0,
) -> str:
    """A joint at a height above the frame of its parent."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 {up}" rpy="0 0 {yaw}"/><axis xyz="{axis}"/>{limit}</joint>\n'
    )
