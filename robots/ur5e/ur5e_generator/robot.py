"""The robot: its links with their masses and shapes, and the joints between them.

Frames follow the common UR description: every joint turns about the z axis of its link. With all
joints at zero the arm lies stretched out horizontally along +x of ``base_link``; positive
``shoulder_lift_joint`` lowers it. ``base_link`` is at the mounting surface, x forward, z up; the
Denavit-Hartenberg base frame of the published table is ``base_link`` turned by 180 degrees about z.
"""

from __future__ import annotations

import math

from robot_modelling.urdf import Joint, Link, Shape

from ur5e_generator.figures import (
    A2,
    A3,
    D1,
    D4,
    D5,
    D6,
    FINGER_DEPTH,
    FINGER_TRAVEL,
    FOREARM_SIDE,
    MAX_SPEED,
    PAD_HEIGHT,
    PAD_WIDTH,
    PALM_HEIGHT,
    TCP_HEIGHT,
    UPPER_ARM_SIDE,
)
from ur5e_generator.looks import (
    base_parts,
    finger_parts,
    forearm_parts,
    gripper_parts,
    mirrored_parts,
    shoulder_parts,
    upper_arm_parts,
    wrist_3_parts,
    wrist_module,
)


def capsule(radius: float, start: float, end: float) -> str:
    """Return a capsule whose round ends reach from ``start`` to ``end`` along its axis."""
    return f'<capsule radius="{radius:g}" length="{round(end - start - 2 * radius, 6):g}"/>'


def box(x: float, y: float, z: float) -> str:
    """Return a box by its edges."""
    return f'<box size="{x:g} {y:g} {z:g}"/>'


def box_inertia(
    mass: float, x: float, y: float, z: float
) -> tuple[float, float, float, float, float, float]:
    """Return the inertia of an even box about its centre."""
    k = mass / 12
    return (k * (y * y + z * z), 0.0, 0.0, k * (x * x + z * z), 0.0, k * (x * x + y * y))


QUARTER = math.pi / 2
FINGER_BOTTOM = PALM_HEIGHT
FINGER_TOP = TCP_HEIGHT + PAD_HEIGHT / 2
FINGER_MASS = 0.1  # kg; lighter ones take the solver longer to bring to rest
FINGER_CENTER = 0.128


def finger(name: str, side: float) -> Link:
    """Return a finger; ``side`` is +1 for the one at +y and -1 for its mirror image."""
    length = FINGER_TOP - FINGER_BOTTOM
    shape = Shape(
        box(PAD_WIDTH, FINGER_DEPTH, length),
        (0.0, side * FINGER_DEPTH / 2, FINGER_BOTTOM + length / 2),
    )
    return Link(
        name,
        FINGER_MASS,
        box_inertia(FINGER_MASS, 0.026, 0.020, 0.070),
        (0.0, side * 0.011, FINGER_CENTER),
        shapes=(shape,),
        parts=finger_parts() if side > 0 else mirrored_parts(finger_parts()),
        is_pad=True,
    )


def links() -> list[Link]:
    """Return all links, base first. One capsule a housing or tube: few contacts, cheap steps."""
    along_x = (0.0, QUARTER, 0.0)
    along_y = (QUARTER, 0.0, 0.0)
    return [
        Link(
            "base_link",
            4.0,
            (0.00443333156, 0.0, 0.0, 0.00443333156, 0.0, 0.0072),
            shapes=(Shape('<cylinder radius="0.0745" length="0.1"/>', (0.0, 0.0, 0.05)),),
            parts=base_parts(),
        ),
        Link(
            "shoulder_link",
            3.761,
            (0.00700210, 0.00000073, -0.00001053, 0.00648091, 0.00049994, 0.00657286),
            (0.0, -0.00193, -0.02561),
            (QUARTER, 0.0, 0.0),
            (Shape(capsule(0.062, -0.071, 0.081), (0.0, 0.005, 0.0), along_y),),
            shoulder_parts(),
        ),
        Link(
            "upper_arm_link",
            8.058,
            (0.01505885, -0.00005400, 0.00000563, 0.33388086, -0.00000181, 0.33247207),
            (-0.2125, 0.0, 0.11336),
            shapes=(
                Shape(
                    capsule(0.060, 0.0, 0.425 + 0.118),
                    (A2 / 2, 0.0, UPPER_ARM_SIDE - 0.004),
                    along_x,
                ),
            ),
            parts=upper_arm_parts(),
        ),
        Link(
            "forearm_link",
            2.846,
            (0.00399632, -0.00001365, 0.00137272, 0.07879254, -0.00000660, 0.07848510),
            (-0.2422, 0.0, 0.0265),
            shapes=(
                Shape(capsule(0.057, -0.058, 0.072), (0.0, 0.0, FOREARM_SIDE + 0.003)),
                Shape(
                    capsule(0.0425, 0.0, 0.3922 + 0.045),
                    (A3 / 2 - 0.022, 0.0, FOREARM_SIDE),
                    along_x,
                ),
            ),
            parts=forearm_parts(),
        ),
        Link(
            "wrist_1_link",
            1.37,
            (0.00165491, -0.00000282, -0.00000438, 0.00135962, 0.00010157, 0.00126279),
            (0.0, -0.01634, -0.0018),
            (QUARTER, 0.0, 0.0),
            (Shape(capsule(0.042, 0.0, 0.170), (0.0, 0.0, -0.043)),),
            wrist_module(0.0685, "-y"),
        ),
        Link(
            "wrist_2_link",
            1.3,
            (0.00135617, -0.00000274, 0.00000444, 0.00127827, -0.00005048, 0.00096614),
            (0.0, 0.01634, -0.0018),
            (-QUARTER, 0.0, 0.0),
            (Shape(capsule(0.042, 0.0, 0.1520), (0.0, 0.0, -0.034)),),
            wrist_module(0.0500, "+y"),
        ),
        Link(
            "wrist_3_link",
            0.365,
            (0.00018694, 0.00000006, -0.00000017, 0.00018908, -0.00000092, 0.00025756),
            (0.0, 0.0, -0.001159),
            shapes=(Shape(capsule(0.040, -0.155, 0.002), (0.0, 0.0, -0.0765)),),
            parts=wrist_3_parts(),
        ),
        Link(
            "gripper",
            0.75,
            box_inertia(0.75, 0.060, 0.090, 0.095),
            (0.0, 0.0, 0.046),
            shapes=(
                Shape(box(0.060, 0.136, PALM_HEIGHT - 0.010), (0.0, 0.0, PALM_HEIGHT / 2 - 0.005)),
            ),
            parts=gripper_parts(),
        ),
        finger("left_finger", 1.0),
        finger("right_finger", -1.0),
        # A frame without a body. PyBullet gives a link without an inertial a mass of 1 kg, so it
        # says that it weighs next to nothing.
        Link("tcp", 0.001, (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)),
    ]


def turning(
    name: str,
    parent: str,
    child: str,
    xyz: tuple[float, float, float],
    rpy: tuple[float, float, float],
    effort: float,
    reach: float = 2 * math.pi,
) -> Joint:
    """Return a joint of the arm."""
    return Joint(
        name, parent, child, xyz, rpy, "revolute", (0.0, 0.0, 1.0), -reach, reach, effort, MAX_SPEED
    )


def sliding(name: str, child: str, side: float) -> Joint:
    """Return a finger's joint: 0 is closed, and it opens outward along ``side`` times y."""
    return Joint(
        name,
        "gripper",
        child,
        (0.0, 0.0, 0.0),
        kind="prismatic",
        axis=(0.0, side, 0.0),
        lower=0.0,
        upper=FINGER_TRAVEL,
        effort=60.0,
        speed=0.15,
    )


def joints() -> list[Joint]:
    """Return all joints, base to tool."""
    pi = math.pi
    return [
        turning("shoulder_pan_joint", "base_link", "shoulder_link", (0, 0, D1), (0, 0, pi), 150),
        turning(
            "shoulder_lift_joint", "shoulder_link", "upper_arm_link", (0, 0, 0), (pi / 2, 0, 0), 150
        ),
        turning("elbow_joint", "upper_arm_link", "forearm_link", (A2, 0, 0), (0, 0, 0), 150, pi),
        turning("wrist_1_joint", "forearm_link", "wrist_1_link", (A3, 0, D4), (0, 0, 0), 28),
        turning("wrist_2_joint", "wrist_1_link", "wrist_2_link", (0, -D5, 0), (pi / 2, 0, 0), 28),
        turning("wrist_3_joint", "wrist_2_link", "wrist_3_link", (0, D6, 0), (-pi / 2, 0, 0), 28),
        # Turned on the flange so that with wrist 3 at zero and the tool down, the fingers close
        # sideways and the x axis of the tcp points forward.
        Joint("gripper_joint", "wrist_3_link", "gripper", (0, 0, 0), (0, 0, -pi / 2)),
        sliding("left_finger_joint", "left_finger", 1.0),
        sliding("right_finger_joint", "right_finger", -1.0),
        Joint("tcp_joint", "gripper", "tcp", (0, 0, TCP_HEIGHT)),
    ]
