"""The AgileX Piper: six joints and two fingers that slide.

Frames are the maker's. With all joints at zero the upper arm points back, the forearm lies over it,
and the gripper points forward. Masses and centres of mass are published; the inertias are those of
the forms, because the published ones belong to other points.
"""

from __future__ import annotations

import math

from robot_modelling.forms import Form, bar, block, dome, hidden, plate, transform
from robot_modelling.modules import Module, Piece, module, with_tcp
from robot_modelling.urdf import ORIGIN, Joint, Vec3, prismatic, revolute

MAKER = "AgileX"

PI, QUARTER = math.pi, math.pi / 2
ARM_DRIVE = (100.0, 5.0)  # N m and rad/s
SHOULDER: Vec3 = (0.0, 0.0, 0.123)
ELBOW: Vec3 = (-0.28240, 0.0, 0.16161)
WRIST: Vec3 = (-0.03446, 0.0, 0.20541)
PITCH = -0.0871  # of the forearm and the gripper, at zero
TRAVEL = 0.035  # of each finger, in m
SHELL, BAND = "silver", "dark"


def on_axis(distance: float, side: float = 0.0, up: float = 0.0) -> Vec3:
    """Return a point at a distance along the gripper's axis from the wrist, at zero."""
    c, s = math.cos(-PITCH), math.sin(-PITCH)
    return (WRIST[0] + distance * c - up * s, side, WRIST[2] + distance * s + up * c)


ALONG: Vec3 = (0.0, PITCH, 0.0)  # turns x along the gripper's axis


def across(at: Vec3, radius: float, half: float) -> tuple[Form, ...]:
    """Return a joint across the arm with dark lids."""
    x, _, z = at
    lids = (
        dome((x, y, z), (x, y + math.copysign(0.004, y), z), radius * 0.8, BAND)
        for y in (half, -half)
    )
    bar_ = bar((x, -half, z), (x, half, z), radius, SHELL, lip=0.005, touches=False)
    return (bar_, *lids)


def between(start: Vec3, end: Vec3, size: tuple[float, float], share: float = 1.0) -> Form:
    """Return a beam of a width and a height from one joint to another."""
    dx, dz = end[0] - start[0], end[2] - start[2]
    length, pitch = math.hypot(dx, dz), -math.atan2(dz, dx)
    middle = ((start[0] + end[0]) / 2, 0.0, (start[2] + end[2]) / 2)
    return block(
        (length * share, *size), middle, SHELL, turn=(0.0, pitch, 0.0), bevel=0.008, touches=False
    )


def covering(start: Vec3, end: Vec3, radius: float) -> Form:
    """Return what a link touches with."""
    return hidden(bar(start, end, radius, SHELL))


def finger(side: float) -> tuple[Form, ...]:
    """Return a finger, closed: its pad lies in the middle."""
    outline = [(0.098, 0.0), (0.155, 0.0), (0.155, 0.006), (0.125, 0.016, 0.01), (0.098, 0.016)]
    corners = [(u, side * v, *rest) for u, v, *rest in outline]
    if side < 0:
        corners.reverse()
    frame = transform(on_axis(0.091), ALONG)
    forms = (
        plate(corners, 0.020, ORIGIN, SHELL),
        block((0.036, 0.003, 0.018), (0.134, side * 0.0016, 0), BAND, bevel=0.0008,
              touches=False),
        hidden(block((0.050, 0.010, 0.020), (0.130, side * 0.005, 0), BAND)),
    )  # fmt: skip
    return tuple(form.moved(frame) for form in forms)


def pieces() -> list[Piece]:
    """Return all links, base first."""
    return [
        Piece("base_link", 1.02, (-0.00473641, 2.568e-05, 0.04145152), forms=(
            block((0.110, 0.100, 0.012), (-0.010, 0, 0.006), BAND, radius=0.015, touches=False),
            bar((0, 0, 0.010), (0, 0, 0.085), 0.046, SHELL, to=0.042, caps="none", touches=False),
            hidden(bar((0, 0, 0), (0, 0, 0.085), 0.046, SHELL)),
        )),
        Piece("link1", 0.71, (0.00032, -0.00041, -0.00348), forms=(
            bar((0, 0, 0.083), (0, 0, 0.091), 0.041, BAND, caps="none", touches=False),
            bar((0, 0, 0.090), (0, 0, 0.123), 0.044, SHELL, caps="none", touches=False),
            *across(SHOULDER, 0.044, 0.046),
            hidden(bar((0, -0.044, 0.123), (0, 0.044, 0.123), 0.044, SHELL)),
        )),
        Piece("link2", 1.16, (0.21852, -0.00861, 0.00126), forms=(
            between(SHOULDER, ELBOW, (0.058, 0.050)),
            *across(ELBOW, 0.036, 0.042),
            covering(SHOULDER, ELBOW, 0.034),
        )),
        Piece("link3", 0.5, (-0.01999, -0.14808, -0.00053), forms=(
            between(ELBOW, on_axis(-0.055), (0.050, 0.046)),
            bar(on_axis(-0.075), on_axis(-0.036), 0.029, BAND, touches=False),
            covering(ELBOW, on_axis(-0.036), 0.031),
        )),
        Piece("link4", 0.38, (0.00013, -0.00076, -0.00394), forms=(
            bar(on_axis(-0.038), on_axis(0.0), 0.029, SHELL, caps="start", touches=False),
            *across(WRIST, 0.029, 0.033),
            covering(on_axis(-0.038), on_axis(0.028), 0.030),
        )),
        Piece("link5", 0.383, (0.00018, -0.06104, -0.00227), forms=(
            bar(on_axis(0.010), on_axis(0.078), 0.027, SHELL, to=0.029),
            bar(on_axis(0.077), on_axis(0.088), 0.026, BAND, caps="none", touches=False),
        )),
        Piece("link6", 0.007, (-3e-05, 6e-05, 0.004), forms=(
            bar(on_axis(0.087), on_axis(0.097), 0.028, BAND, lip=0.001, touches=False),
        )),
        Piece("gripper_base", 0.45, (-0.000184, 8.05e-05, 0.03214367), forms=(
            block((0.048, 0.062, 0.056), on_axis(0.121), SHELL, turn=ALONG, radius=0.008,
                  touches=False),
            block((0.042, 0.124, 0.040), on_axis(0.163), SHELL, turn=ALONG, radius=0.008,
                  touches=False),
            block((0.006, 0.112, 0.022), on_axis(0.186), BAND, turn=ALONG, touches=False),
            hidden(block((0.088, 0.116, 0.050), on_axis(0.142), SHELL, turn=ALONG)),
        )),
        Piece("link7", 0.025, forms=finger(-1.0), is_pad=True),
        Piece("link8", 0.025, forms=finger(1.0), is_pad=True),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to fingers, with their published limits."""

    def turning(
        number: int, xyz: Vec3, rpy: Vec3, limits: tuple[float, float], speed: float = ARM_DRIVE[1]
    ) -> Joint:
        parent = f"link{number - 1}" if number > 1 else "base_link"
        names = (parent, f"link{number}")
        return revolute(f"joint{number}", names, xyz, rpy, limits, ARM_DRIVE[0], speed)

    jaw: Vec3 = (0.0, 0.0, 0.1358)
    return [
        turning(1, SHOULDER, ORIGIN, (-2.618, 2.618)),
        turning(2, ORIGIN, (QUARTER, -0.1359, -PI), (0.0, 3.14)),
        turning(3, (0.28503, 0, 0), (0, 0, -1.7939), (-2.967, 0.0)),
        turning(4, (-0.021984, -0.25075, 0), (QUARTER, 0, 0), (-1.745, 1.745)),
        turning(5, ORIGIN, (-QUARTER, 0, 0), (-1.22, 1.22)),
        turning(6, (8.8259e-05, -0.091, 0), (QUARTER, 0, 0), (-2.0944, 2.0944), 3.0),
        Joint("joint6_to_gripper_base", "link6", "gripper_base", ORIGIN),
        prismatic("joint7", ("gripper_base", "link7"), jaw, (0, 0, 1), (0.0, TRAVEL), 10, 1,
                  (QUARTER, 0, 0)),
        prismatic("joint8", ("gripper_base", "link8"), jaw, (0, 0, -1), (-TRAVEL, 0.0), 10, 1,
                  (QUARTER, 0, -PI)),
    ]  # fmt: skip


def robot() -> Module:
    """Return the arm with its tcp between the pads, turned so that x points forward at home."""
    arm = module(pieces(), joints())
    return with_tcp(arm, "gripper_base", (0.0, 0.0, 0.1345), (0.0, 0.0, PI))
