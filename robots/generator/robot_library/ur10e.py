"""The Universal Robots UR10e with a Robotiq 2F-85.

Frames follow the common UR description. With all joints at zero the arm lies stretched out along
+x of ``base_link``, its joints along y. Masses and centres of mass are published; the inertias are
those of the forms.
"""

from __future__ import annotations

import math

from robot_modelling.forms import Form, bar, dome, hidden
from robot_modelling.modules import Module, Piece, module, mounted
from robot_modelling.urdf import ORIGIN, Joint, Vec3, revolute

from robot_library.robotiq_2f85 import gripper

MAKER = "Universal Robots"

# The Denavit-Hartenberg table, in m.
D1, A2, A3, D4, D5, D6 = 0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655
UPPER, FORE = 0.1762, 0.0393  # how far the upper arm and the forearm lie beside the base
ELBOW, WRIST = -A2, -A2 - A3
PI, QUARTER = math.pi, math.pi / 2


def housing(back: Vec3, front: Vec3, radius: float, lid: float) -> tuple[Form, ...]:
    """Return a joint housing with its blue lid at the back and a dark ring before the front."""
    away = [b - f for b, f in zip(back, front, strict=True)]
    length = math.hypot(*away)
    x, y, z = (a / length for a in away)
    end = (back[0] + lid * x, back[1] + lid * y, back[2] + lid * z)
    seal = (front[0] - 0.008 * x, front[1] - 0.008 * y, front[2] - 0.008 * z)
    return (
        bar(back, front, radius, "gray", caps="end"),
        dome(back, end, radius * 0.995, "blue"),
        bar(front, seal, radius * 0.94, "dark", touches=False, caps="none"),
    )


def tube(start: Vec3, end: Vec3, radius: float, to: float | None = None) -> Form:
    """Return an arm's tube."""
    return bar(start, end, radius, "silver", to=to, caps="none")


def neck(start: Vec3, end: Vec3) -> Form:
    """Return the short tube from one wrist to the next."""
    return bar(start, end, 0.048, "gray", touches=False, caps="none")


def pieces() -> list[Piece]:
    """Return all links, base first."""
    w1, w2 = D4, D1 - D5
    return [
        Piece("base_link", 4.0, forms=(
            bar((0, 0, 0), (0, 0, 0.015), 0.095, "dark", touches=False),
            bar((0, 0, 0.013), (0, 0, 0.090), 0.088, "gray", to=0.080, touches=False, caps="end"),
            hidden(bar((0, 0, 0), (0, 0, 0.090), 0.088, "gray")),
        )),
        Piece("shoulder_link", 7.369, (0.021, -0.027, 0.0), forms=(
            bar((0, 0, 0.094), (0, 0, D1), 0.078, "gray", touches=False, caps="none"),
            *housing((0, -0.086, D1), (0, 0.083, D1), 0.080, 0.022),
        )),
        Piece("upper_arm_link", 13.051, (-0.2327, 0.0, 0.158), forms=(
            *housing((0, UPPER + 0.076, D1), (0, UPPER - 0.083, D1), 0.080, 0.022),
            tube((0.05, UPPER, D1), (ELBOW - 0.04, UPPER, D1), 0.064),
            *housing((ELBOW, UPPER + 0.066, D1), (ELBOW, UPPER - 0.066, D1), 0.068, 0.019),
        )),
        Piece("forearm_link", 3.989, (-0.33155, 0.0, 0.068), forms=(
            *housing((ELBOW, FORE - 0.058, D1), (ELBOW, FORE + 0.064, D1), 0.066, 0.019),
            tube((ELBOW + 0.04, FORE, D1), (WRIST - 0.03, FORE, D1), 0.054, 0.045),
            *housing((WRIST, FORE - 0.050, D1), (WRIST, FORE + 0.074, D1), 0.049, 0.016),
        )),
        Piece("wrist_1_link", 2.1, (0.0, -0.018, 0.007), forms=(
            neck((WRIST, w1 - 0.056, D1), (WRIST, w1, D1)),
            *housing((WRIST, w1, D1 + 0.050), (WRIST, w1, D1 - 0.062), 0.049, 0.016),
        )),
        Piece("wrist_2_link", 1.98, (0.0, 0.018, -0.007), forms=(
            neck((WRIST, w1, w2 + 0.056), (WRIST, w1, w2)),
            *housing((WRIST, w1 - 0.050, w2), (WRIST, w1 + 0.060, w2), 0.049, 0.016),
        )),
        Piece("wrist_3_link", 0.615, (0.0, 0.0, -0.026), forms=(
            bar((WRIST, w1 + D6 - 0.048, w2), (WRIST, w1 + D6, w2), 0.046, "silver"),
        )),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to flange, with their published limits."""

    def turning(
        name: str, parent: str, child: str, xyz: Vec3, rpy: Vec3, effort: float, deg_s: float,
        reach: float = 2 * PI,
    ) -> Joint:  # fmt: skip
        between = (f"{parent}_link", f"{child}_link")
        limits = (-reach, reach)
        return revolute(f"{name}_joint", between, xyz, rpy, limits, effort, math.radians(deg_s))

    return [
        turning("shoulder_pan", "base", "shoulder", (0, 0, D1), (0, 0, PI), 330, 120),
        turning("shoulder_lift", "shoulder", "upper_arm", ORIGIN, (QUARTER, 0, 0), 330, 120),
        turning("elbow", "upper_arm", "forearm", (A2, 0, 0), ORIGIN, 150, 180, PI),
        turning("wrist_1", "forearm", "wrist_1", (A3, 0, D4), ORIGIN, 56, 180),
        turning("wrist_2", "wrist_1", "wrist_2", (0, -D5, 0), (QUARTER, 0, 0), 56, 180),
        turning("wrist_3", "wrist_2", "wrist_3", (0, D6, 0), (-QUARTER, 0, 0), 56, 180),
    ]


def robot() -> Module:
    """Return the arm with its gripper, turned on the flange as on the UR5e."""
    arm = module(pieces(), joints())
    return mounted(arm, gripper(), "wrist_3_link", rpy=(0.0, 0.0, -QUARTER))
