"""The ViperX 300 S of Interbotix, the follower of ALOHA: six joints and two fingers that slide.

Frames are the maker's: at zero the upper arm stands up and the forearm points along +x, and all
frames are parallel to ``base_link``. The rotor that drives the fingers is left out; the fingers
slide.
"""

from __future__ import annotations

import math

from robot_modelling.forms import UPRIGHT_X, Form, bar, block, hidden, plate
from robot_modelling.modules import Module, Piece, module, with_tcp
from robot_modelling.urdf import ORIGIN, Joint, Vec3, prismatic, revolute

MAKER = "Interbotix"

PI, QUARTER = math.pi, math.pi / 2
FRAME, MOTOR = "dark", "black"

SHOULDER_Z, ELBOW_X, FOREARM_Z = 0.12705, 0.05955, 0.42705
ROLL_X, WRIST_X, ROTATE_X = 0.25955, 0.35955, 0.429294
BAR_X = ROTATE_X + 0.042825  # of the rail of the fingers
FINGERS_X = BAR_X + 0.025875
TCP_X = FINGERS_X + 0.030
CLOSED, OPENED = 0.021, 0.057  # of each finger, in m
UP = (0.0, 0.0, QUARTER)  # how the maker's inertias are turned


def motor(at: Vec3, turn: Vec3 = ORIGIN) -> Form:
    """Return an actuator, long along its own x axis."""
    return block((0.058, 0.034, 0.034), at, MOTOR, turn=turn, radius=0.003, touches=False)


def base() -> tuple[Form, ...]:
    """Return the foot plate with the waist motor."""
    return (
        block((0.220, 0.150, 0.010), (-0.055, 0, 0.005), FRAME, radius=0.02),
        block((0.078, 0.090, 0.050), (0.0, 0, 0.035), MOTOR, radius=0.01),
        block((0.080, 0.060, 0.030), (-0.110, 0, 0.025), MOTOR, radius=0.006, touches=False),
        bar((0, 0, 0.060), (0, 0, 0.072), 0.045, FRAME, lip=0.002, touches=False),
    )


def shoulder() -> tuple[Form, ...]:
    """Return the turret: two motors back to back, between cheeks."""
    outline = [(-0.034, 0.074), (0.034, 0.074), (0.026, 0.148, 0.014), (-0.026, 0.148, 0.014)]
    return (
        bar((0, 0, 0.071), (0, 0, 0.080), 0.055, "metal", lip=0.002, touches=False),
        *(plate(outline, 0.005, (0, y, 0), FRAME, turn=UPRIGHT_X) for y in (-0.052, 0.052)),
        *(motor((0, y, 0.112), (0.0, QUARTER, 0.0)) for y in (-0.029, 0.029)),
        hidden(block((0.060, 0.110, 0.072), (0, 0, 0.110), FRAME)),
    )


def upper_arm() -> tuple[Form, ...]:
    """Return the bar of the upper arm and the bracket that carries the elbow forward."""
    z = FOREARM_Z
    outline = [
        (-0.022, z - 0.070),
        (0.022, z - 0.070),
        (0.078, z - 0.012, 0.008),
        (0.078, z + 0.018, 0.012),
        (0.030, z + 0.020, 0.012),
        (-0.022, z - 0.012, 0.012),
    ]
    return (
        bar((0, -0.058, SHOULDER_Z), (0, 0.058, SHOULDER_Z), 0.016, "metal", lip=0.002,
            touches=False),
        block((0.044, 0.050, 0.250), (0, 0, 0.262), FRAME, bevel=0.003, touches=False),
        block((0.036, 0.070, 0.050), (0, 0, 0.160), FRAME, bevel=0.003, touches=False),
        *(plate(outline, 0.005, (0, y, 0), FRAME, turn=UPRIGHT_X) for y in (-0.029, 0.029)),
        motor((0.012, 0, z - 0.030), (0.0, -0.75, 0.0)),
        hidden(block((0.046, 0.060, 0.290), (0, 0, 0.282), FRAME)),
        hidden(block((0.080, 0.064, 0.050), (0.036, 0, z - 0.010), FRAME)),
    )  # fmt: skip


def forearm() -> tuple[Form, ...]:
    """Return the forearm up to its roll joint."""
    z = FOREARM_Z
    return (
        bar((ELBOW_X, -0.034, z), (ELBOW_X, 0.034, z), 0.017, "metal", lip=0.002, touches=False),
        block((0.165, 0.044, 0.040), (ELBOW_X + 0.096, 0, z), FRAME, bevel=0.003, touches=False),
        motor((ROLL_X - 0.040, 0, z)),
        bar((ROLL_X - 0.014, 0, z), (ROLL_X, 0, z), 0.024, "metal", lip=0.002, touches=False),
        hidden(block((0.215, 0.048, 0.044), (ELBOW_X + 0.095, 0, z), FRAME)),
    )


def lower_forearm() -> tuple[Form, ...]:
    """Return the two motors of the wrist."""
    z = FOREARM_Z
    return (
        block((0.088, 0.036, 0.038), (ROLL_X + 0.046, 0, z), MOTOR, radius=0.003, touches=False),
        *(block((0.060, 0.004, 0.030), (WRIST_X - 0.020, y, z), FRAME, touches=False)
          for y in (-0.024, 0.024)),
        hidden(block((0.112, 0.050, 0.042), (ROLL_X + 0.058, 0, z), MOTOR)),
    )  # fmt: skip


def wrist() -> tuple[Form, ...]:
    """Return the motor that turns the gripper."""
    z = FOREARM_Z
    return (
        bar((WRIST_X, -0.029, z), (WRIST_X, 0.029, z), 0.014, "metal", lip=0.002, touches=False),
        block((0.050, 0.036, 0.036), (WRIST_X + 0.038, 0, z), MOTOR, radius=0.003),
    )


def gripper() -> tuple[Form, ...]:
    """Return the gripper's motor behind its rail."""
    z = FOREARM_Z
    return (
        bar((ROTATE_X - 0.006, 0, z), (ROTATE_X + 0.006, 0, z), 0.022, "metal", lip=0.002,
            touches=False),
        block((0.038, 0.046, 0.046), (ROTATE_X + 0.022, 0, z), MOTOR, radius=0.004),
    )  # fmt: skip


def rail() -> tuple[Form, ...]:
    """Return the rail on which the fingers slide."""
    z = FOREARM_Z
    return (
        block((0.020, 0.150, 0.034), (BAR_X + 0.004, 0, z), FRAME),
        bar((BAR_X + 0.017, -0.072, z), (BAR_X + 0.017, 0.072, z), 0.004, "metal", lip=0.001,
            touches=False),
    )  # fmt: skip


def finger(side: float) -> tuple[Form, ...]:
    """Return a finger as it is at zero, where its pad lies beyond the middle."""
    z, face = FOREARM_Z, -side * CLOSED
    middle = face + side * 0.006
    start, end = BAR_X + 0.016, TCP_X + 0.018
    outline = [(start, face + side * 0.001), (end, face + side * 0.001),
               (end, face + side * 0.008), (start + 0.012, face + side * 0.024),
               (start, face + side * 0.024)]  # fmt: skip
    if side < 0:
        outline.reverse()
    return (
        plate(outline, 0.022, (0, 0, z), FRAME),
        block((0.040, 0.003, 0.020), (TCP_X - 0.003, face + side * 0.0015, z), "pad",
              bevel=0.0008, touches=False),
        hidden(block((end - start, 0.012, 0.022), ((start + end) / 2, middle, z), FRAME)),
    )  # fmt: skip


def pieces() -> list[Piece]:
    """Return all links, base first."""
    jaw = (2.433e-5, 0.0, 0.0, 1.255e-5, 0.0, 1.417e-5)
    return [
        Piece("base_link", 0.969034, (-0.0534774, -0.000562575, 0.0205961),
              (6.024e-3, 4.7113e-5, 3.851e-6, 1.7e-3, -8.415e-5, 7.162e-3), base(), UP),
        Piece("shoulder_link", 0.798614, (0.000259233, -3.3552e-6, 0.0116129),
              (9.388e-4, -1e-9, -1.91e-8, 1.138e-3, 5.9568e-6, 1.201e-3), shoulder(), UP),
        Piece("upper_arm_link", 0.792592, (0.0206949, 4e-10, 0.226459),
              (8.925e-3, 0.0, 0.0, 8.937e-3, 1.201e-3, 9.357e-4), upper_arm(), UP),
        Piece("upper_forearm_link", 0.322228, (0.105723, 0.0, 0.0),
              (1.524e-4, -1.883e-5, -8.4064e-6, 1.342e-3, 1.2564e-6, 1.441e-3), forearm()),
        Piece("lower_forearm_link", 0.414823, (0.0513477, 0.00680462, 0.0),
              (1.753e-4, -8.528e-5, 0.0, 5.269e-4, 0.0, 5.911e-4), lower_forearm(), (PI, 0, 0)),
        Piece("wrist_link", 0.115395, (0.046743, -7.6652e-6, 0.010565),
              (4.631e-5, 1.95e-8, 2.3e-9, 4.514e-5, 4.2002e-6, 5.27e-5), wrist(), UP),
        Piece("gripper_link", 0.097666, (0.023001, 0.0, 0.011523),
              (3.268e-5, 0.0, 0.0, 2.436e-5, 2.785e-7, 2.119e-5), gripper(), UP),
        Piece("gripper_bar_link", 0.150986, (0.006794, -4.272e-7, -0.000776),
              (7.895e-5, -1.2e-9, 1.341e-7, 3.283e-4, 1.7465e-6, 3.095e-4), rail(), UP),
        Piece("left_finger_link", 0.034796, (0.017344, -0.0060692, 0.0), jaw, finger(1.0), UP,
              is_pad=True),
        Piece("right_finger_link", 0.034796, (0.017344, 0.0060692, 0.0), jaw, finger(-1.0), UP,
              is_pad=True),
    ]  # fmt: skip


def joints() -> list[Joint]:
    """Return all joints, base to fingers."""
    full = (-PI + 1e-5, PI - 1e-5)

    def motors(
        name: str, parent: str, child: str, xyz: Vec3, axis: Vec3, limits: tuple[float, float],
        effort: float,
    ) -> Joint:  # fmt: skip
        between = (f"{parent}_link", f"{child}_link")
        return revolute(name, between, xyz, ORIGIN, limits, effort, PI, axis)

    def degrees(low: float, high: float) -> tuple[float, float]:
        return math.radians(low), math.radians(high)

    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    on = (FINGERS_X - BAR_X, 0.0, 0.0)
    return [
        motors("waist", "base", "shoulder", (0, 0, 0.079), z, full, 10),
        motors("shoulder", "shoulder", "upper_arm", (0, 0, 0.04805), y, degrees(-106, 72), 20),
        motors("elbow", "upper_arm", "upper_forearm", (ELBOW_X, 0, 0.3), y, degrees(-101, 92), 15),
        motors("forearm_roll", "upper_forearm", "lower_forearm", (0.2, 0, 0), x, full, 2),
        motors("wrist_angle", "lower_forearm", "wrist", (0.1, 0, 0), y, degrees(-107, 128), 5),
        motors("wrist_rotate", "wrist", "gripper", (0.069744, 0, 0), x, full, 1),
        Joint("gripper_bar", "gripper_link", "gripper_bar_link", (0.042825, 0.0, 0.0)),
        prismatic("left_finger", ("gripper_bar_link", "left_finger_link"), on, y,
                  (CLOSED, OPENED), 5, 1),
        prismatic("right_finger", ("gripper_bar_link", "right_finger_link"), on, y,
                  (-OPENED, -CLOSED), 5, 1),
    ]  # fmt: skip


def robot() -> Module:
    """Return the arm with its tcp between the tips, whose z axis points out along x."""
    arm = module(pieces(), joints())
    return with_tcp(arm, "gripper_bar_link", (TCP_X - BAR_X, 0.0, 0.0), (PI, -QUARTER, 0.0))
