"""The Rethink Sawyer with its electric gripper, whose fingers sit in the third slot.

Frames are the maker's. With all joints at zero the arm lies stretched out along +x, to the left of
its base by 16 cm. The pedestal is left out, and the head does not turn. Masses of the arm are
published; what the gripper's description lacks follows from the forms.
"""

from __future__ import annotations

import math

from robot_modelling.forms import Form, bar, block, dome, hidden
from robot_modelling.modules import Module, Piece, module, mounted, with_tcp
from robot_modelling.urdf import ORIGIN, Joint, Vec3, prismatic, revolute

MAKER = "Rethink Robotics"

PI, QUARTER = math.pi, math.pi / 2
Z = 0.317  # of the arm at zero
SHELL, COVER, GAP = "red", "dark", "black"
TRAVEL = 0.020833  # of each finger, in m
CLOSED_FACE = 0.0095  # of each pad from the middle, in the third slot
FINGER_DRIVE = (20.0, 5.0)  # N and m/s
TCP_HEIGHT = 0.098


def along(x: float, to: float, y: float, radius: float, last: float | None = None) -> Form:
    """Return a shell along the arm whose ends lie inside others."""
    return bar((x, y, Z), (to, y, Z), radius, SHELL, to=last, caps="none", touches=False)


def across(x: float, low: float, high: float, radius: float) -> tuple[Form, ...]:
    """Return a joint across the arm with dark lids."""
    return (
        bar((x, low, Z), (x, high, Z), radius, SHELL, lip=0.010),
        dome((x, low, Z), (x, low - 0.006, Z), radius * 0.78, COVER),
        dome((x, high, Z), (x, high + 0.006, Z), radius * 0.78, COVER),
    )


def ring(x: float, y: float, radius: float) -> Form:
    """Return the gap between two links."""
    return bar((x - 0.004, y, Z), (x + 0.004, y, Z), radius, GAP, caps="none", touches=False)


def touching(x: float, to: float, y: float, radius: float) -> Form:
    """Return what a link touches with along the arm."""
    return hidden(bar((x, y, Z), (to, y, Z), radius, SHELL))


def pieces() -> list[Piece]:
    """Return all links of the arm, base first."""
    return [
        Piece("right_arm_base_link", 2.0687, (-0.0006241, -2.8025e-05, 0.065404),
              (0.0067599, -4.2024e-05, -6.1904e-07, 0.0067877, 1.5888e-05, 0.0074031), (
            bar((0, 0, 0), (0, 0, 0.016), 0.110, COVER, touches=False),
            bar((0, 0, 0.014), (0, 0, 0.076), 0.088, COVER, to=0.082, caps="none", touches=False),
            hidden(bar((0, 0, 0), (0, 0, 0.076), 0.088, COVER)),
        )),
        Piece("right_l0", 5.3213, (0.024366, 0.010969, 0.14363),
              (0.053314, 0.0047093, 0.011734, 0.057902, 0.0080179, 0.023659), (
            bar((0, 0, 0.076), (0, 0, 0.084), 0.080, GAP, caps="none", touches=False),
            bar((0, 0, 0.083), (0, 0, 0.350), 0.082, SHELL, to=0.070, caps="end"),
            *across(0.081, -0.055, 0.012, 0.070),
            bar((0, 0, 0.348), (0, 0, 0.380), 0.045, COVER, caps="none", touches=False),
        )),
        Piece("head", 1.5795, (0.0053207, -2.6549e-05, 0.1021),
              (0.011833, -4.4669e-06, 4.9425e-05, 0.0082709, 4.2124e-07, 0.0049661), (
            block((0.050, 0.060, 0.050), (-0.005, 0, 0.400), COVER, radius=0.01, touches=False),
            block((0.030, 0.260, 0.165), (0.012, 0, 0.490), COVER, radius=0.008, bevel=0.006),
            block((0.004, 0.225, 0.130), (0.028, 0, 0.490), "silver", touches=False),
        )),
        Piece("right_l1", 4.505, (-0.0030849, -0.026811, 0.092521),
              (0.022398, -0.00023986, -0.00029362, 0.014613, -0.0060875, 0.017295), (
            *across(0.081, 0.018, 0.255, 0.068),
            along(0.100, 0.146, 0.1925, 0.062),
        )),
        Piece("right_l2", 1.745, (-0.00016044, -0.014967, 0.13582),
              (0.025506, 4.4101e-06, 1.4955e-05, 0.0253, -0.0033204, 0.0034179), (
            ring(0.150, 0.1925, 0.058),
            along(0.154, 0.481, 0.1925, 0.060, 0.050),
            *across(0.481, 0.146, 0.232, 0.056),
            touching(0.154, 0.440, 0.1925, 0.058),
        )),
        Piece("right_l3", 2.5097, (-0.0048135, -0.0281, -0.084154),
              (0.01016, -9.7452e-06, 0.00026624, 0.0065685, 0.0030316, 0.0069078), (
            *across(0.481, -0.028, 0.140, 0.056),
            along(0.500, 0.556, 0.024, 0.050),
        )),
        Piece("right_l4", 1.1136, (-0.0018844, 0.0069001, 0.1341),
              (0.013557, 1.8109e-05, 0.00013523, 0.013555, 0.0010561, 0.0013658), (
            ring(0.560, 0.024, 0.047),
            along(0.564, 0.881, 0.024, 0.048, 0.040),
            *across(0.881, -0.018, 0.072, 0.046),
            touching(0.564, 0.850, 0.024, 0.046),
        )),
        Piece("right_l5", 1.5625, (0.0061133, -0.023697, 0.076416),
              (0.0047328, 0.00011526, 4.6269e-05, 0.0029676, -0.0011557, 0.0031762), (
            *across(0.881, 0.078, 0.205, 0.046),
            along(0.900, 0.960, 0.1603, 0.042),
        )),
        Piece("right_l6", 0.3292, (-8.0726e-06, 0.0085838, -0.0049566),
              (0.00031105, 1.4771e-06, -3.7074e-07, 0.00021549, -8.4533e-06, 0.00035976), (
            ring(0.964, 0.1603, 0.040),
            bar((0.968, 0.1603, Z), (1.0155, 0.1603, Z), 0.044, SHELL, lip=0.006),
        )),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints of the arm, base to flange, with their published limits."""
    below = {0: "right_arm_base_link"} | {number: f"right_l{number - 1}" for number in range(1, 7)}

    def turning(
        number: int, xyz: Vec3, rpy: Vec3, limits: tuple[float, float], effort: float, speed: float
    ) -> Joint:
        between = (below[number], f"right_l{number}")
        return revolute(f"right_j{number}", between, xyz, rpy, limits, effort, speed)

    def both(reach: float) -> tuple[float, float]:
        return -reach, reach

    up, down = (QUARTER, 0.0, 0.0), (-QUARTER, 0.0, 0.0)
    return [
        turning(0, (0, 0, 0.08), ORIGIN, both(3.0503), 80, 1.74),
        Joint("head_pan", "right_l0", "head", (0.0, 0.0, 0.2965)),
        turning(1, (0.081, 0.05, 0.237), (-QUARTER, QUARTER, 0), (-3.8095, 2.2736), 80, 1.328),
        turning(2, (0, -0.14, 0.1425), up, both(3.0426), 40, 1.957),
        turning(3, (0, -0.042, 0.26), down, both(3.0439), 40, 1.957),
        turning(4, (0, -0.125, -0.1265), up, both(2.9761), 9, 3.485),
        turning(5, (0, 0.031, 0.275), down, both(2.9761), 9, 3.485),
        turning(6, (0, -0.11, 0.1053), (-QUARTER, -0.17453, PI), both(4.7124), 9, 4.545),
    ]


def finger(side: float) -> tuple[Form, ...]:
    """Return a finger, closed: the pad is what is left between the slot and the middle."""
    face = side * CLOSED_FACE
    return (
        block((0.012, 0.050, 0.014), (0, face + side * 0.022, 0.029), COVER, touches=False),
        block((0.014, 0.012, 0.088), (0, face + side * 0.0085, 0.066), COVER, touches=False),
        block((0.020, 0.0035, 0.026), (0, face + side * 0.0018, 0.098), "pad", bevel=0.0008,
              touches=False),
        hidden(block((0.020, 0.0145, 0.080), (0, face + side * 0.00725, 0.070), COVER)),
    )  # fmt: skip


def gripper() -> Module:
    """Return the electric gripper, closed at zero."""
    palm = (
        bar((0, 0, -0.025), (0, 0, -0.004), 0.036, GAP, lip=0.002, touches=False),
        block((0.058, 0.120, 0.030), (0, 0, 0.009), COVER, radius=0.014),
        block((0.026, 0.112, 0.004), (0, 0, 0.0255), "metal", touches=False),
    )
    base = "right_gripper_base"
    pieces = [Piece(base, 0.3, forms=palm)]
    joints = []
    for letter, side in (("l", 1.0), ("r", -1.0)):
        name = f"r_gripper_{letter}_finger"
        pieces.append(Piece(name, 0.04, forms=finger(side), is_pad=True))
        limits = (0.0, TRAVEL) if side > 0 else (-TRAVEL, 0.0)
        joints.append(
            prismatic(f"{name}_joint", (base, name), ORIGIN, (0, 1, 0), limits, *FINGER_DRIVE)
        )
    return with_tcp(module(pieces, joints), base, (0.0, 0.0, TCP_HEIGHT))


def robot() -> Module:
    """Return the arm with its gripper, turned on the flange as the maker's hand frame is."""
    arm = module(pieces(), joints())
    return mounted(arm, gripper(), "right_l6", (0.0, 0.0, 0.0245 + 0.025), (0.0, 0.0, QUARTER))
