"""The SO-101 of TheRobotStudio: five joints, and a jaw that closes against a fixed one.

Link frames and joint zeros are those of the maker's "new calibration", where every joint is in the
middle of its range. ``base_link`` lies under the first joint, on the ground, x forward. With all
joints at zero the upper arm stands up and the forearm points forward. The limits of effort and
speed are those of the servos, STS3215 at 12 V: 30 kg cm and 45 turns a minute.
"""

from __future__ import annotations

import math

from robot_modelling.forms import UPRIGHT_X, Form, bar, block, hidden, plate, transform
from robot_modelling.modules import Module, Piece, module, with_tcp
from robot_modelling.urdf import Joint, Vec3, revolute

MAKER = "TheRobotStudio"

PI, QUARTER = math.pi, math.pi / 2
SERVO = (2.94, 4.7)  # N m and rad/s
PRINT, MOTOR = "yellow", "black"

SHOULDER, ELBOW, WRIST = (0.0304, 0.1166), (0.0584, 0.2292), (0.1933, 0.2344)  # (x, z) at zero
AXIS_Z = 0.2344  # of the forearm and the gripper at zero
FACE_Z = AXIS_Z - 0.0079  # of the fixed jaw
PIVOT = (0.2778, 0.0, 0.2546)  # of the moving jaw
PAD_X, PAD = 0.2544 + 0.094, 0.0105  # where the moving jaw touches, and its radius there
CLOSED = -0.174533
FROM_FACE = 0.018  # how far before the fixed jaw the tcp lies, in m


def beam(start: tuple[float, float], end: tuple[float, float], width: float) -> tuple[Form, ...]:
    """Return two printed cheeks between two joints, in the plane of the arm, with a servo."""
    dx, dz = end[0] - start[0], end[1] - start[1]
    length, pitch = math.hypot(dx, dz), -math.atan2(dz, dx)
    turn = (0.0, pitch, 0.0)
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    toward = (start[0] + 0.76 * dx, start[1] + 0.76 * dz)
    cheeks = tuple(
        block((length + 0.024, 0.006, width), (middle[0], y, middle[1]), PRINT, turn=turn,
              touches=False)
        for y in (-0.0185, 0.0185)
    )  # fmt: skip
    web = block((length * 0.55, 0.034, 0.007), (middle[0], 0, middle[1]), PRINT, turn=turn,
                touches=False)  # fmt: skip
    servo = block((0.045, 0.031, 0.025), (toward[0], 0, toward[1]), MOTOR, turn=turn, touches=False)
    box = block((length + 0.020, 0.043, width), (middle[0], 0, middle[1]), PRINT, turn=turn)
    return (*cheeks, web, servo, hidden(box))


def horn(x: float, z: float) -> Form:
    """Return the horns of a joint across the arm."""
    return bar((x, -0.0235, z), (x, 0.0235, z), 0.0105, "dark", lip=0.001, touches=False)


def base() -> tuple[Form, ...]:
    """Return the foot, which is clamped to a table, and the first servo in its tower."""
    return (
        block((0.105, 0.092, 0.010), (-0.030, 0, 0.005), PRINT, radius=0.012),
        block((0.052, 0.052, 0.046), (-0.002, 0, 0.033), PRINT, radius=0.006),
        block((0.040, 0.060, 0.030), (-0.055, 0, 0.025), PRINT, radius=0.005, touches=False),
        block((0.046, 0.026, 0.032), (-0.004, 0, 0.044), MOTOR, touches=False),
    )


def shoulder() -> tuple[Form, ...]:
    """Return the turret with the servo that lifts the upper arm."""
    x, z = SHOULDER
    outline = [(-0.020, 0.064), (0.046, 0.064), (0.046, z + 0.012, 0.01), (0.014, z + 0.012, 0.01)]
    return (
        bar((0, 0, 0.058), (0, 0, 0.068), 0.025, "dark", lip=0.001, touches=False),
        *(plate(outline, 0.005, (0, y, 0), PRINT, turn=UPRIGHT_X) for y in (-0.0275, 0.0275)),
        block((0.060, 0.054, 0.008), (0.012, 0, 0.069), PRINT, touches=False),
        block((0.026, 0.048, 0.046), (x - 0.004, 0, z - 0.018), MOTOR, touches=False),
        hidden(block((0.062, 0.058, 0.062), (0.013, 0, 0.097), PRINT)),
    )


def wrist() -> tuple[Form, ...]:
    """Return the servo that rolls the gripper, in its bracket."""
    x, z = WRIST
    return (
        horn(x, z),
        block((0.050, 0.025, 0.032), (x + 0.036, 0, z - 0.002), MOTOR, touches=False),
        block((0.046, 0.042, 0.007), (x + 0.026, 0, z + 0.0165), PRINT, touches=False),
        block((0.008, 0.040, 0.038), (x + 0.054, 0, z), PRINT, touches=False),
        hidden(block((0.056, 0.042, 0.040), (x + 0.030, 0, z), MOTOR)),
    )


def fixed_jaw() -> tuple[Form, ...]:
    """Return the gripper's body, its servo and its fixed jaw."""
    outline = [
        (0.262, FACE_Z - 0.014),
        (0.320, FACE_Z - 0.015),
        (0.3605, FACE_Z - 0.006, 0.003),
        (0.3605, FACE_Z),
        (0.290, FACE_Z),
        (0.262, FACE_Z + 0.006),
    ]
    return (
        bar((0.250, 0, AXIS_Z), (0.262, 0, AXIS_Z), 0.021, PRINT, lip=0.002, touches=False),
        block((0.024, 0.030, 0.046), (0.272, 0, AXIS_Z + 0.012), MOTOR, touches=False),
        block((0.006, 0.034, 0.052), (0.2595, 0, AXIS_Z + 0.006), PRINT, touches=False),
        plate(outline, 0.028, (0, 0, 0), PRINT, turn=UPRIGHT_X),
        hidden(block((0.030, 0.036, 0.050), (0.268, 0, AXIS_Z + 0.010), MOTOR)),
        hidden(block((0.0735, 0.028, 0.012), (0.32375, 0, FACE_Z - 0.006), PRINT)),
    )


def moving_jaw() -> tuple[Form, ...]:
    """Return the moving jaw as it is at zero; it lies on the fixed one when it is closed."""
    outline = [
        (0.2700, 0.2480, 0.004),
        (0.3060, FACE_Z + 0.003),
        (0.3380, FACE_Z, 0.02),
        (0.3570, FACE_Z + 0.001, 0.008),
        (0.3570, FACE_Z + 0.010, 0.003),
        (0.3220, FACE_Z + 0.021, 0.008),
        (0.2850, 0.2640, 0.006),
        (0.2700, 0.2630, 0.006),
    ]
    closed = (
        plate(outline, 0.024, (0, 0, 0), PRINT, turn=UPRIGHT_X),
        bar((PIVOT[0], -0.019, PIVOT[2]), (PIVOT[0], 0.019, PIVOT[2]), 0.0105, "dark", lip=0.001,
            touches=False),
        # A round pad touches the upright side of an object flat, however wide the jaw is open.
        hidden(bar((PAD_X, -0.013, FACE_Z + PAD), (PAD_X, 0.013, FACE_Z + PAD), PAD, PRINT)),
        hidden(block((0.060, 0.024, 0.012), (0.304, 0, FACE_Z + 0.020), PRINT,
                     turn=(0.0, 0.28, 0.0))),
    )  # fmt: skip
    about = transform(PIVOT) @ transform(turn=(0.0, CLOSED, 0.0)) @ transform([-p for p in PIVOT])
    return tuple(form.moved(about) for form in closed)


def pieces() -> list[Piece]:
    """Return all links, base first."""
    return [
        Piece("base_link", 0.147, (-0.02512, -0.00005, 0.03348),
              (1.14686e-4, -4.59787e-7, 4.97151e-6, 1.36117e-4, 9.75275e-8, 1.30364e-4), base()),
        Piece("shoulder", 0.100006, (-0.0307604, -1.66727e-5, -0.0252713),
              (8.3759e-5, 7.55525e-8, -1.16342e-6, 8.10403e-5, 1.54663e-7, 2.39783e-5),
              shoulder()),
        Piece("upper_arm", 0.103, (-0.0898471, -0.00838224, 0.0184089),
              (4.08002e-5, -1.97819e-5, -4.03016e-8, 1.47318e-4, 8.97326e-9, 1.42487e-4),
              (horn(*SHOULDER), *beam(SHOULDER, ELBOW, 0.027))),
        Piece("lower_arm", 0.104, (-0.0980701, 0.00324376, 0.0182831),
              (2.87438e-5, 7.41152e-6, 1.26409e-6, 1.59844e-4, -4.90188e-8, 1.4529e-4),
              (horn(*ELBOW), *beam(ELBOW, WRIST, 0.025))),
        Piece("wrist", 0.079, (-1.03312e-4, -0.0386143, 0.0281156),
              (3.68263e-5, 1.7893e-8, -5.28128e-8, 2.5391e-5, 3.6412e-6, 2.1e-5), wrist()),
        Piece("gripper", 0.087, (2.13627e-4, 2.45138e-4, -0.025187),
              (2.75087e-5, -3.35241e-7, -5.7352e-6, 4.33657e-5, -5.17847e-8, 3.45059e-5),
              fixed_jaw(), is_pad=True),
        Piece("moving_jaw", 0.012, (-0.00157495, -0.0300244, 0.0192755),
              (6.61427e-6, -3.19807e-7, -5.90717e-9, 1.89032e-6, -1.09945e-7, 5.28738e-6),
              moving_jaw(), is_pad=True),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to jaw."""

    def servo(name: str, parent: str, child: str, xyz: Vec3, rpy: Vec3, reach: float) -> Joint:
        return revolute(name, (parent, child), xyz, rpy, (-reach, reach), *SERVO)

    jaw = ((0.0202, 0.0188, -0.0234), (QUARTER, 0.0, 0.0), (CLOSED, 1.74533))
    return [
        servo("shoulder_pan", "base_link", "shoulder", (0, 0, 0.0624), (PI, 0, PI), 1.91986),
        servo("shoulder_lift", "shoulder", "upper_arm", (-0.0303992, -0.0182778, -0.0542),
              (-QUARTER, -QUARTER, 0), 1.74533),
        servo("elbow_flex", "upper_arm", "lower_arm", (-0.11257, -0.028, 0), (0, 0, QUARTER), 1.69),
        servo("wrist_flex", "lower_arm", "wrist", (-0.1349, 0.0052, 0), (0, 0, -QUARTER), 1.65806),
        servo("wrist_roll", "wrist", "gripper", (0, -0.0611, 0.0181), (QUARTER, 0, PI), 2.79253),
        revolute("gripper", ("gripper", "moving_jaw"), *jaw, *SERVO),
    ]  # fmt: skip


def robot() -> Module:
    """Return the arm with its tcp before the fixed jaw, near the tips."""
    arm = module(pieces(), joints())
    # The gripper's frame has its z axis back along the arm and its x axis from jaw to jaw.
    return with_tcp(
        arm, "gripper", (-0.0079 + FROM_FACE, 0.0002, 0.2544 - PAD_X), (PI, 0.0, QUARTER)
    )
