"""The Kinova Gen3 of seven joints, without its camera, with a Robotiq 2F-85.

Frames are the maker's. With all joints at zero the arm stands up. Joints 1, 3, 5 and 7 turn without
end; a limit of two turns stands for that.
"""

from __future__ import annotations

import math

from robot_modelling.forms import Form, bar, dome, hidden
from robot_modelling.modules import Module, Piece, module, mounted
from robot_modelling.urdf import Joint, Vec3, revolute

from robot_library.robotiq_2f85 import gripper

MAKER = "Kinova"

PI, QUARTER = math.pi, math.pi / 2
LARGE, SMALL = (39.0, 1.3963), (9.0, 1.2218)  # N m and rad/s
ENDLESS = 2 * PI
Y2, Y4, Y6, Y8 = -0.0054, -0.0181, -0.0247, -0.0249  # how far the joints lie beside the base
Z1, Z2, Z3, Z4 = 0.15643, 0.28481, 0.49519, 0.70557
Z5, Z6, Z7, Z8 = 0.9140, 1.01993, 1.12586, 1.18738
SHELL, GAP = "silver", "dark"


def elbow(y: float, z: float, radius: float, back: float, front: float) -> tuple[Form, ...]:
    """Return a joint across the arm with a dark lid on its front side."""
    return (
        bar((0, y - back, z), (0, y + front, z), radius, SHELL, lip=0.008, touches=False),
        dome((0, y - back, z), (0, y - back - 0.006, z), radius * 0.84, GAP),
    )


def shell(y: float, low: float, high: float, radius: float, to: float | None = None) -> Form:
    """Return an upright tube whose ends lie inside others."""
    return bar((0, y, low), (0, y, high), radius, SHELL, to=to, caps="none", touches=False)


def ring(y: float, z: float, radius: float) -> Form:
    """Return the band between two links."""
    return bar((0, y, z - 0.005), (0, y, z + 0.005), radius, GAP, caps="none", touches=False)


def touching(y: float, low: float, high: float, radius: float) -> Form:
    """Return what a link touches with."""
    return hidden(bar((0, y, low), (0, y, high), radius, SHELL))


def pieces() -> list[Piece]:
    """Return all links, base first."""
    return [
        Piece("base_link", 1.697, (-0.000648, -0.000166, 0.084487),
              (0.004622, 9e-06, 6e-05, 0.004495, 9e-06, 0.002079), (
            bar((0, 0, 0), (0, 0, 0.012), 0.062, GAP, touches=False),
            shell(0, 0.010, 0.151, 0.050, 0.046),
            touching(0, 0, 0.150, 0.050),
        )),
        Piece("shoulder_link", 1.3773, (-2.3e-05, -0.010364, -0.07336),
              (0.00457, 1e-06, 2e-06, 0.004831, 0.000448, 0.001409), (
            ring(0, Z1, 0.046),
            shell(0, Z1 + 0.005, Z2, 0.046),
            *elbow(Y2, Z2, 0.046, 0.045, 0.020),
            touching(0, Z1, Z2 + 0.046, 0.046),
        )),
        Piece("half_arm_1_link", 1.1636, (-4.4e-05, -0.09958, -0.013278),
              (0.011088, 5e-06, 0.0, 0.001072, -0.000691, 0.011255), (
            bar((0, 0.012, Z2), (0, 0.046, Z2), 0.046, SHELL, lip=0.010, touches=False),
            bar((0, 0.016, Z2), (0, -0.0117, Z3 - 0.05), 0.046, SHELL, to=0.045, caps="none",
                touches=False),
            shell(-0.0117, Z3 - 0.060, Z3 - 0.005, 0.045),
            touching(0, Z2 - 0.02, Z3, 0.048),
        )),
        Piece("half_arm_2_link", 1.1636, (-4.4e-05, -0.006641, -0.117892),
              (0.010932, 0.0, -7e-06, 0.011127, 0.000606, 0.001043), (
            ring(-0.0117, Z3, 0.044),
            shell(-0.0117, Z3 + 0.005, Z4, 0.045),
            *elbow(Y4, Z4, 0.046, 0.042, 0.018),
            touching(-0.0117, Z3, Z4 + 0.040, 0.046),
        )),
        Piece("forearm_link", 0.9302, (-1.8e-05, -0.075478, -0.015006),
              (0.008147, -1e-06, 0.0, 0.000631, -0.0005, 0.008316), (
            bar((0, -0.002, Z4), (0, 0.032, Z4), 0.044, SHELL, lip=0.010, touches=False),
            bar((0, 0.004, Z4), (0, Y6, Z5 - 0.05), 0.043, SHELL, to=0.037, caps="none",
                touches=False),
            shell(Y6, Z5 - 0.060, Z5 - 0.005, 0.037),
            touching(-0.010, Z4 - 0.02, Z5, 0.042),
        )),
        Piece("spherical_wrist_1_link", 0.6781, (1e-06, -0.009432, -0.063883),
              (0.001596, 0.0, 0.0, 0.001607, 0.000256, 0.000399), (
            ring(Y6, Z5, 0.036),
            shell(Y6, Z5 + 0.005, Z6, 0.036),
            *elbow(Y6, Z6, 0.036, 0.034, 0.014),
            touching(Y6, Z5, Z6 + 0.034, 0.037),
        )),
        Piece("spherical_wrist_2_link", 0.6781, (1e-06, -0.045483, -0.00965),
              (0.001641, 0.0, 0.0, 0.00041, -0.000278, 0.001641), (
            bar((0, Y6 + 0.010, Z6), (0, Y6 + 0.034, Z6), 0.036, SHELL, lip=0.008,
                touches=False),
            shell(Y6 + 0.004, Z6, Z7 - 0.005, 0.0355),
            touching(Y6, Z6 - 0.02, Z7, 0.037),
        )),
        Piece("bracelet_link", 0.364, (-9.3e-05, 0.000132, -0.022905),
              (0.000214, 0.0, 1e-06, 0.000223, -2e-06, 0.00024), (
            ring(Y8, Z7, 0.036),
            bar((0, Y8, Z7 + 0.005), (0, Y8, Z8), 0.039, SHELL, lip=0.006),
        )),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to flange, with their published limits."""
    links = [piece.name for piece in pieces()]

    def turning(
        number: int, xyz: Vec3, roll: float, reach: float, drive: tuple[float, float]
    ) -> Joint:
        between = (links[number - 1], links[number])
        return revolute(f"joint_{number}", between, xyz, (roll, 0, 0), (-reach, reach), *drive)

    return [
        turning(1, (0, 0, 0.15643), PI, ENDLESS, LARGE),
        turning(2, (0, 0.005375, -0.12838), QUARTER, 2.41, LARGE),
        turning(3, (0, -0.21038, -0.006375), -QUARTER, ENDLESS, LARGE),
        turning(4, (0, 0.006375, -0.21038), QUARTER, 2.66, LARGE),
        turning(5, (0, -0.20843, -0.006375), -QUARTER, ENDLESS, SMALL),
        turning(6, (0, 0.00017505, -0.10593), QUARTER, 2.23, SMALL),
        turning(7, (0, -0.10593, -0.00017505), -QUARTER, ENDLESS, SMALL),
    ]


def robot() -> Module:
    """Return the arm with its gripper, whose x axis points forward when the tool points down."""
    arm = module(pieces(), joints())
    return mounted(arm, gripper(), "bracelet_link", (0.0, 0.0, -0.061525), (PI, 0.0, PI))
