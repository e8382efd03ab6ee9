"""The UFACTORY xArm 7 with the maker's gripper, whose fingers hang from turning knuckles.

Frames are the maker's. With all joints at zero the upper arm stands up, the forearm hangs down
before it, and the flange points down. The second bar of each finger, which carries nothing here, is
left out.
"""

from __future__ import annotations

import math

from robot_modelling.forms import UPRIGHT_Y, Form, bar, block, dome, hidden, plate
from robot_modelling.modules import Module, Piece, module, mounted, with_tcp
from robot_modelling.urdf import ORIGIN, Joint, Vec3, following, revolute

MAKER = "UFACTORY"

PI, QUARTER = math.pi, math.pi / 2
SPEED = 3.14  # rad/s
SHOULDER_Z, ELBOW_Z, WRIST_Z = 0.267, 0.56, 0.2175
ELBOW_X, WRIST_X, FLANGE_X = 0.0525, 0.13, 0.206
FLANGE_Z = WRIST_Z - 0.097

KNUCKLE: Vec3 = (0.0, 0.035, 0.059098)
FINGER: Vec3 = (0.0, 0.035465, 0.042039)  # where the finger hangs, from the knuckle
OPEN_FACE = 0.043  # of the pad, from the middle
GRIPPER_DRIVE = (50.0, 2.0)  # N m and rad/s
LEADER = "drive_joint"  # the others of the gripper move with it
TCP_HEIGHT = 0.160


def across(x: float, z: float, radius: float, half: float) -> tuple[Form, ...]:
    """Return a housing along y with lids on both sides."""
    lids = (
        dome((x, y, z), (x, y + math.copysign(0.008, y), z), radius * 0.93, "silver")
        for y in (half, -half)
    )
    return (bar((x, -half, z), (x, half, z), radius, "white", lip=0.006), *lids)


def upright(x: float, low: float, high: float, radius: float, to: float | None = None) -> Form:
    """Return a vertical tube; its ends lie inside others."""
    return bar((x, 0, low), (x, 0, high), radius, "white", to=to, caps="none", touches=False)


def ring(x: float, z: float, radius: float) -> Form:
    """Return the dark gap between two links."""
    return bar((x, 0, z - 0.003), (x, 0, z + 0.003), radius, "dark", touches=False, caps="none")


def arm_pieces() -> list[Piece]:
    """Return the links of the arm, base first."""
    slope = (WRIST_X - 0.012, 0.0, WRIST_Z + 0.105)
    return [
        Piece("link_base", 0.88556, (-0.021131, -0.0016302, 0.056488),
              (0.0030595, 0.00012259, -0.00062705, 0.0037783, 0.00027023, 0.0020125), (
            bar((0, 0, 0), (0, 0, 0.020), 0.063, "silver", touches=False),
            upright(0, 0.018, 0.175, 0.060, 0.056),
            hidden(bar((0, 0, 0), (0, 0, 0.175), 0.060, "white")),
            block((0.030, 0.060, 0.060), (-0.055, 0, 0.050), "dark", radius=0.006, touches=False),
        )),
        Piece("link1", 2.382, (-0.0002, 0.02905, -0.01233),
              (0.0056905, -1.579e-05, 5.125e-06, 0.0049566, -0.000873378, 0.003316654), (
            ring(0, 0.178, 0.055),
            upright(0, 0.181, SHOULDER_Z, 0.056),
            *across(0, SHOULDER_Z, 0.056, 0.062),
        )),
        Piece("link2", 1.869, (0.00022, -0.12856, 0.01735),
              (0.0095989, 1.541e-06, 5.56e-06, 0.00382472, -0.00317156, 0.007565669), (
            upright(0, SHOULDER_Z, 0.458, 0.054, 0.050),
            hidden(bar((0, 0, SHOULDER_Z), (0, 0, 0.480), 0.052, "white")),
        )),
        Piece("link3", 1.6383, (0.0466, -0.02463, -0.00768),
              (0.00310955, 0.00030837, -0.00058453, 0.00264483, 0.000338893, 0.0026624), (
            ring(0, 0.461, 0.049),
            bar((0, 0, 0.464), (0, 0, ELBOW_Z + 0.046), 0.050, "white", caps="end", touches=False),
            *across(ELBOW_X, ELBOW_Z, 0.050, 0.058),
        )),
        Piece("link4", 1.7269, (0.07047, -0.11575, 0.012),
              (0.005889, 0.00137112, 0.00088143, 0.00359703, -0.001762155, 0.00543244), (
            bar((ELBOW_X, 0, ELBOW_Z), slope, 0.050, "white", to=0.045, caps="none"),
            upright(WRIST_X, WRIST_Z + 0.065, WRIST_Z + 0.130, 0.044, 0.046),
        )),
        Piece("link5", 1.3203, (-0.00032, 0.01604, -0.026),
              (0.00534665, 1.5117e-05, -3.69e-07, 0.0049779, -0.00022132, 0.0013624), (
            ring(WRIST_X, WRIST_Z + 0.062, 0.043),
            upright(WRIST_X, WRIST_Z, WRIST_Z + 0.059, 0.044),
            *across(WRIST_X, WRIST_Z, 0.044, 0.052),
        )),
        Piece("link6", 1.325, (0.06469, 0.03278, 0.02141),
              (0.0014745, -0.000488, 0.0002953, 0.0019037, 0.00014749, 0.0023652), (
            bar((WRIST_X, 0, WRIST_Z), (FLANGE_X, 0, WRIST_Z), 0.040, "white", caps="none",
                touches=False),
            bar((FLANGE_X, 0, WRIST_Z + 0.042), (FLANGE_X, 0, FLANGE_Z + 0.016), 0.040, "white"),
        )),
        Piece("link7", 0.17, (0.0, -0.00677, -0.01098),
              (9.3e-05, 0.0, 0.0, 5.87e-05, -3.6e-06, 0.000132), (
            bar((FLANGE_X, 0, FLANGE_Z + 0.018), (FLANGE_X, 0, FLANGE_Z), 0.038, "silver",
                lip=0.002),
        )),
    ]  # fmt: skip


def arm_joints() -> list[Joint]:
    """Return the joints of the arm with their published limits."""
    full = (-2 * PI, 2 * PI)

    def turning(
        number: int, xyz: Vec3, roll: float, effort: float, limits: tuple[float, float] = full
    ) -> Joint:
        parent = f"link{number - 1}" if number > 1 else "link_base"
        between = (parent, f"link{number}")
        return revolute(f"joint{number}", between, xyz, (roll, 0, 0), limits, effort, SPEED)

    return [
        turning(1, (0, 0, SHOULDER_Z), 0.0, 50),
        turning(2, ORIGIN, -QUARTER, 50, (-2.059, 2.0944)),
        turning(3, (0, -0.293, 0), QUARTER, 30),
        turning(4, (ELBOW_X, 0, 0), QUARTER, 30, (-0.19198, 3.927)),
        turning(5, (0.0775, -0.3425, 0), QUARTER, 30),
        turning(6, ORIGIN, QUARTER, 20, (-1.69297, PI)),
        turning(7, (0.076, 0.097, 0), -QUARTER, 20),
    ]


def knuckle(side: float) -> tuple[Form, ...]:
    """Return the bars from the palm to a finger."""
    y, z = side * KNUCKLE[1], KNUCKLE[2]
    outline = [(-0.008, -0.008, 0.004), (0.010, -0.008, 0.006), (0.0440, 0.034, 0.006),
               (0.0440, 0.050, 0.006), (0.030, 0.050, 0.006), (-0.008, 0.008, 0.006)]  # fmt: skip
    corners = [(side * u, v, *rest) for u, v, *rest in outline]
    if side < 0:
        corners.reverse()
    cheeks = (plate(corners, 0.006, (x, y, z), "silver", turn=UPRIGHT_Y) for x in (-0.015, 0.015))
    return (*cheeks, hidden(block((0.036, 0.022, 0.050), (0, y + side * 0.020, z + 0.022), "dark")))


def finger(side: float) -> tuple[Form, ...]:
    """Return a finger with its pad, open."""
    y, z = KNUCKLE[1] + FINGER[1], KNUCKLE[2] + FINGER[2]
    top = z + 0.066
    outline = [(y - 0.012, z - 0.008, 0.004), (y + 0.008, z - 0.008, 0.006),
               (y + 0.006, z + 0.012, 0.006), (OPEN_FACE + 0.011, top, 0.004),
               (OPEN_FACE + 0.0015, top), (OPEN_FACE + 0.0015, z + 0.022)]  # fmt: skip
    corners = [(side * u, v, *rest) for u, v, *rest in outline]
    if side < 0:
        corners.reverse()
    pad = (0.0, side * (OPEN_FACE + 0.0015), z + 0.0475)
    touching = (0.0, side * (OPEN_FACE + 0.006), z + 0.044)
    return (
        plate(corners, 0.026, ORIGIN, "white", turn=UPRIGHT_Y),
        block((0.022, 0.003, 0.034), pad, "dark", bevel=0.0008, touches=False),
        hidden(block((0.026, 0.012, 0.044), touching, "dark")),
    )


def gripper() -> Module:
    """Return the gripper, open at zero."""
    inertia = (0.00047106, 3.9292e-07, 2.6537e-06, 0.00033072, -1.0975e-05, 0.00025642)
    palm = (
        bar((0, 0, 0), (0, 0, 0.014), 0.038, "silver", lip=0.002, touches=False),
        block((0.066, 0.076, 0.046), (0, 0, 0.037), "white", radius=0.016, touches=False),
        block((0.046, 0.100, 0.020), (0, 0, 0.066), "white", radius=0.010, touches=False),
        hidden(block((0.066, 0.090, 0.074), (0, 0, 0.037), "white")),
    )
    pieces = [Piece("xarm_gripper_base_link", 0.54156, (-0.00065489, -0.0018497, 0.048028),
                    inertia, palm)]  # fmt: skip
    joints = []
    for hand, side in (("left", 1.0), ("right", -1.0)):
        out, tip = f"{hand}_outer_knuckle", f"{hand}_finger"
        pieces += [
            Piece(out, 0.033618, (0.0, side * 0.021559, 0.015181),
                  (1.9111e-05, 0.0, 0.0, 6.6256e-06, side * -7.3008e-06, 1.3185e-05),
                  knuckle(side)),
            Piece(tip, 0.048304, (0.0, side * -0.016413, 0.029258),
                  (1.7493e-05, 0.0, 0.0, 1.7225e-05, side * 4.6433e-06, 5.1466e-06),
                  finger(side), is_pad=True),
        ]  # fmt: skip
        name = LEADER if hand == "left" else "right_outer_knuckle_joint"
        at = (0.0, side * KNUCKLE[1], KNUCKLE[2])
        on = (0.0, side * FINGER[1], FINGER[2])
        turn, back = (side, 0.0, 0.0), (-side, 0.0, 0.0)
        base = "xarm_gripper_base_link"
        joints += [
            revolute(name, (base, out), at, ORIGIN, (0.0, 0.85), *GRIPPER_DRIVE, turn),
            revolute(f"{tip}_joint", (out, tip), on, ORIGIN, (0.0, 0.85), *GRIPPER_DRIVE, back),
        ]
    joints = [following(joint, LEADER) for joint in joints]
    return with_tcp(module(pieces, joints), "xarm_gripper_base_link", (0.0, 0.0, TCP_HEIGHT))


def robot() -> Module:
    """Return the arm with its gripper."""
    return mounted(module(arm_pieces(), arm_joints()), gripper(), "link7")
