"""The KUKA LBR iiwa 14 R820 with a Robotiq 2F-85.

With all joints at zero the arm stands up, and all frames are parallel to that of the base.
"""

from __future__ import annotations

import math

from robot_modelling.forms import Form, bar, block, dome, hidden
from robot_modelling.modules import Module, Piece, module, mounted
from robot_modelling.urdf import ORIGIN, Joint, Vec3, revolute

from robot_library.robotiq_2f85 import gripper

MAKER = "KUKA"

Z1, Z2, Z3, Z4, Z5, Z6, Z7, FLANGE = 0.1475, 0.36, 0.588, 0.78, 0.9875, 1.18, 1.271, 1.306
SHELL, BAND, LID = "white", "orange", "silver"
EFFORT = 200.0  # N m, as the descriptions of this arm have it for all joints


def tube(low: float, high: float, radius: float, to: float | None = None) -> Form:
    """Return an upright shell whose ends lie inside others."""
    return bar((0, 0, low), (0, 0, high), radius, SHELL, to=to, caps="none", touches=False)


def band(z: float, radius: float) -> Form:
    """Return the orange ring at a joint."""
    return bar((0, 0, z - 0.006), (0, 0, z + 0.006), radius, BAND, lip=0.002, touches=False)


def knuckle(z: float, radius: float, side: float, depth: float) -> tuple[Form, ...]:
    """Return the half of a bent joint that belongs to one link, on one side."""
    end = side * depth
    return (
        bar((0, -side * depth * 0.35, z), (0, end, z), radius, SHELL, lip=0.014, touches=False),
        dome((0, end, z), (0, end + side * 0.007, z), radius * 0.72, LID),
    )


def touching(low: float, high: float, radius: float) -> Form:
    """Return what a link touches with."""
    return hidden(bar((0, 0, low), (0, 0, high), radius, SHELL))


def pieces() -> list[Piece]:
    """Return all links, base first."""
    return [
        Piece("link_0", 7.050378, (-0.012822, 0.0, 0.071507),
              (0.031226, 0.0, 0.000871, 0.039697, 0.0, 0.043102), (
            bar((0, 0, 0), (0, 0, 0.045), 0.105, LID, to=0.100, touches=False),
            bar((0, 0, 0.043), (0, 0, 0.142), 0.092, LID, to=0.084, caps="none", touches=False),
            block((0.080, 0.090, 0.060), (-0.095, 0, 0.032), "dark", radius=0.01, touches=False),
            touching(0, 0.142, 0.100),
        )),
        Piece("link_1", 5.289529, (0.0, -0.033795, 0.132404),
              (0.042462, 0.0, 0.0, 0.042838, 0.006341, 0.01587), (
            band(Z1, 0.085),
            tube(Z1 + 0.005, Z2, 0.082, 0.076),
            *knuckle(Z2, 0.078, -1.0, 0.086),
            touching(Z1, Z2 + 0.075, 0.080),
        )),
        Piece("link_2", 5.688888, (0.000136, 0.047548, 0.076322),
              (0.055182, -3.3e-05, 5.6e-05, 0.053983, 0.010034, 0.016523), (
            *knuckle(Z2, 0.078, 1.0, 0.086),
            tube(Z2, Z3 - 0.005, 0.076),
            touching(Z2 - 0.03, Z3, 0.078),
        )),
        Piece("link_3", 3.461245, (0.0, 0.034913, 0.123108),
              (0.02172, 0.0, 0.0, 0.02073, -0.003845, 0.007701), (
            band(Z3, 0.078),
            tube(Z3 + 0.005, Z4, 0.074, 0.068),
            *knuckle(Z4, 0.070, 1.0, 0.078),
            touching(Z3, Z4 + 0.068, 0.072),
        )),
        Piece("link_4", 4.122995, (0.0, -0.039793, 0.086944),
              (0.03241, 0.0, 0.0, 0.030758, -0.006022, 0.009883), (
            *knuckle(Z4, 0.070, -1.0, 0.078),
            tube(Z4, Z5 - 0.005, 0.068, 0.064),
            touching(Z4 - 0.03, Z5, 0.070),
        )),
        Piece("link_5", 1.563756, (0.0, -0.029824, 0.076267),
              (0.008677, 0.0, 0.0, 0.007297, 0.002869, 0.003935), (
            band(Z5, 0.066),
            tube(Z5 + 0.005, Z6 - 0.060, 0.062, 0.050),
            bar((0, -0.010, Z6 - 0.080), (0, -0.052, Z6), 0.040, SHELL, caps="none",
                touches=False),
            *knuckle(Z6, 0.048, -1.0, 0.084),
            touching(Z5, Z6 + 0.020, 0.060),
        )),
        Piece("link_6", 2.457878, (0.0, 0.07102, 0.00495),
              (0.007227, 0.0, 0.0, 0.006958, 0.000318, 0.004734), (
            bar((0, -0.035, Z6), (0, 0.074, Z6), 0.062, SHELL, lip=0.016),
            dome((0, 0.074, Z6), (0, 0.081, Z6), 0.044, LID),
            tube(Z6, Z7 - 0.004, 0.050),
        )),
        Piece("link_7", 0.265331, (3e-06, -2e-06, 0.013782),
              (0.000175, 0.0, 0.0, 0.000175, 0.0, 0.000306), (
            bar((0, 0, Z7 - 0.004), (0, 0, Z7 + 0.008), 0.052, BAND, lip=0.002, touches=False),
            bar((0, 0, Z7 + 0.006), (0, 0, FLANGE), 0.042, LID, lip=0.002),
        )),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to flange, with their published limits."""
    z, y, back = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)

    def turning(number: int, xyz: Vec3, axis: Vec3, reach_deg: float, speed_deg_s: float) -> Joint:
        reach, speed = math.radians(reach_deg), math.radians(speed_deg_s)
        between = (f"link_{number - 1}", f"link_{number}")
        limits = (-reach, reach)
        return revolute(f"A{number}", between, xyz, ORIGIN, limits, EFFORT, speed, axis)

    return [
        turning(1, (0, 0, 0.1475), z, 170, 85),
        turning(2, (0, -0.01, 0.2125), y, 120, 85),
        turning(3, (0, 0.01, 0.228), z, 170, 100),
        turning(4, (0, 0.0105, 0.192), back, 120, 75),
        turning(5, (0, -0.0105, 0.2075), z, 170, 130),
        turning(6, (0, -0.0707, 0.1925), y, 120, 135),
        turning(7, (0, 0.0707, 0.091), z, 175, 135),
    ]


def robot() -> Module:
    """Return the arm with its gripper, whose x axis points forward when the tool points down."""
    arm = module(pieces(), joints())
    return mounted(arm, gripper(), "link_7", (0.0, 0.0, 0.035), (0.0, 0.0, math.pi))
