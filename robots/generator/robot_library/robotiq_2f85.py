"""The Robotiq 2F-85: two fingers on linkages, with a stroke of 85 mm.

Frame: z out of the flange, the fingers close along y. Each finger hangs from a knuckle that turns,
and turns back by as much, which keeps its pad parallel; in the gripper a second bar does that. The
bar carries nothing here and is left out. With all joints at zero the gripper is open.
"""

from __future__ import annotations

from robot_modelling.forms import UPRIGHT_Y, Form, bar, block, hidden, plate
from robot_modelling.modules import Module, Piece, module, with_tcp
from robot_modelling.urdf import ORIGIN, Vec3, following, revolute

FOLDER = "../robotiq_2f85/meshes"
MASS = 0.925  # kg, all of it
REACH = 0.8757  # rad; it is closed at 0.8
DRIVE = (10.0, 2.0)  # N m and rad/s
LEADER = "finger_joint"  # the others move with it

KNUCKLE: Vec3 = (0.0, 0.0306011, 0.054904)  # where it turns
FINGER: Vec3 = (0.0, 0.0376, 0.043)  # where the finger hangs, from there
PAD: Vec3 = (0.0, -0.0220203, 0.03242)  # its middle, from there
PAD_SIZE: Vec3 = (0.022, 0.00635, 0.0375)
TCP_HEIGHT = 0.1425  # the middle of the pads when they hold something

KNUCKLE_MASS, FINGER_MASS = 0.031, 0.040  # kg


def palm() -> Piece:
    """Return the coupling and the body."""
    forms = (
        bar((0, 0, 0), (0, 0, 0.0135), 0.0375, "metal", touches=False),
        bar((0, 0, 0.0125), (0, 0, 0.040), 0.036, "dark", to=0.0365, touches=False),
        block((0.060, 0.076, 0.034), (0, 0, 0.053), "dark", radius=0.014, touches=False),
        block((0.036, 0.050, 0.014), (0, 0, 0.075), "dark", radius=0.006, touches=False),
        *(
            bar((-0.031, y, 0.0549), (0.031, y, 0.0549), 0.0085, "metal", touches=False)
            for y in (KNUCKLE[1], -KNUCKLE[1])
        ),
        hidden(block((0.064, 0.078, 0.080), (0, 0, 0.040), "dark")),
    )
    mass = MASS - 2.0 * (KNUCKLE_MASS + FINGER_MASS)
    return Piece("robotiq_base", mass, forms=forms)


def _knuckle(side: float) -> tuple[Form, ...]:
    y, z = side * KNUCKLE[1], KNUCKLE[2]
    # Seen along x: a bar that leaves the palm sideways and rises to the finger.
    outline = [
        (-0.007, -0.008),
        (0.0335, -0.0105, 0.006),
        (0.0465, 0.036),
        (0.0455, 0.0495, 0.006),
        (0.0310, 0.0495, 0.006),
        (0.0225, 0.010, 0.006),
        (-0.007, 0.008),
    ]
    corners = [(side * u, v, *rest) for u, v, *rest in outline]
    if side < 0:
        corners.reverse()
    cheeks = tuple(
        plate(corners, 0.005, (x, y, z), "metal", turn=UPRIGHT_Y) for x in (-0.0135, 0.0135)
    )
    touching = block((0.027, 0.016, 0.056), (0, y + side * 0.0365, z + 0.021), "metal")
    return (*cheeks, hidden(touching))


def _finger(side: float) -> tuple[Form, ...]:
    y = side * (KNUCKLE[1] + FINGER[1])
    z = KNUCKLE[2] + FINGER[2]
    face = y + side * PAD[1]
    middle = z + PAD[2]
    tip = middle + PAD_SIZE[2] / 2.0
    outline = [
        (side * (abs(y) - 0.0235), 0.006),
        (side * (abs(y) - 0.002), -0.007, 0.004),
        (side * (abs(y) + 0.005), 0.003, 0.004),
        (side * (abs(y) - 0.008), tip - z - 0.012, 0.006),
        (side * (abs(y) - 0.0125), tip - z, 0.003),
        (side * (abs(y) - 0.0195), tip - z),
    ]
    if side < 0:
        outline.reverse()
    back = side * (0.0154 - PAD_SIZE[1]) / 2.0
    return (
        plate(outline, 0.020, (0, 0, z), "dark", turn=UPRIGHT_Y),
        block(PAD_SIZE, (0, face, middle), "pad", touches=False, bevel=0.0008),
        hidden(block((PAD_SIZE[0], 0.0154, PAD_SIZE[2]), (0, face + back, middle), "pad")),
    )


def gripper() -> Module:
    """Return the gripper with its tcp."""
    pieces, joints = [palm()], []
    for hand, side, joint in (
        ("left", -1.0, LEADER),
        ("right", 1.0, "right_outer_knuckle_joint"),
    ):
        knuckle, finger = f"{hand}_outer_knuckle", f"{hand}_inner_finger"
        pieces += [
            Piece(knuckle, KNUCKLE_MASS, forms=_knuckle(side)),
            Piece(finger, FINGER_MASS, forms=_finger(side), is_pad=True),
        ]
        at = (0.0, side * KNUCKLE[1], KNUCKLE[2])
        axis = (side, 0.0, 0.0)
        on = (0.0, side * FINGER[1], FINGER[2])
        joints += [
            following(
                revolute(joint, ("robotiq_base", knuckle), at, ORIGIN, (0.0, REACH), *DRIVE, axis),
                LEADER,
            ),
            following(
                revolute(
                    f"{finger}_joint", (knuckle, finger), on, ORIGIN, (-REACH, REACH), *DRIVE, axis
                ),
                LEADER,
                -1.0,
            ),
        ]
    return with_tcp(module(pieces, joints, FOLDER), "robotiq_base", (0.0, 0.0, TCP_HEIGHT))
