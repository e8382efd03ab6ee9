"""The links' looks, each in its own link frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from robot_modelling.solids import (
    ROUND_STEPS,
    Mesh,
    loft,
    milled,
    mirrored,
    placed,
    rectangle,
    rounded,
    turned,
)
from robot_modelling.urdf import Part

from ur5e_generator.figures import (
    A2,
    A3,
    FOREARM_SIDE,
    PAD_HEIGHT,
    PAD_WIDTH,
    TCP_HEIGHT,
    UPPER_ARM_SIDE,
)


def end_cap(radius: float, height: float, *, segments: int = 24) -> Mesh:
    """Return the blue lid that closes a joint housing: a flat dome on a rounded rim."""
    return turned(
        [
            (radius, 0.0),
            (radius, height * 0.96, height * 0.75),
            (0.0, height * 1.10),
        ],
        segments=segments,
    )


def seal(radius: float, bottom: float, top: float, *, segments: int = 24) -> Mesh:
    """Return the dark ring between two links."""
    return turned([(radius, bottom), (radius, top)], segments=segments)


def joint_module(
    radius: float, back: float, front: float, *, cap: float, segments: int = 24
) -> list[Part]:
    """Return a joint housing along z: a turned shell from back to front with its lid at the back.

    Args:
        radius: Of the shell.
        back: z of the lid's seat, negative.
        front: z of the face that carries the next link.
        cap: Height of the lid.
        segments: Flat sides of the circle.
    """
    lip = radius * 0.93
    shell = turned(
        [
            (lip, back - 0.001),
            (radius, back + 0.005),
            (radius, front - 0.007, 0.004),
            (lip, front),
        ],
        segments=segments,
        caps="end",
    )
    lid = placed(end_cap(radius * 0.955, cap, segments=segments), "-z", (0.0, 0.0, back + 0.0005))
    return [("housing", shell), ("cap", lid)]


def moved(parts: Iterable[Part], axis: str, at: tuple[float, float, float]) -> list[Part]:
    """Place every part of a list."""
    return [(color, placed(mesh, axis, at)) for color, mesh in parts]


def base_parts() -> list[Part]:
    """Return the foot on its flange and the turned base above it."""
    foot = turned([(0.0745, 0.0), (0.0745, 0.010, 0.002), (0.0655, 0.014)], caps="end")
    body = turned([(0.066, 0.0135), (0.0625, 0.030, 0.02), (0.0600, 0.0915)])
    connector = placed(
        milled(
            rectangle((-0.019, 0.019), (-0.014, 0.014), 0.004), 0.05, 0.071, bevel=0.003, caps="end"
        ),
        "-x",
        (0.0, 0.0, 0.036),
    )
    return [
        ("ring", foot),
        ("housing", body),
        ("ring", seal(0.0585, 0.091, 0.0995)),
        ("ring", connector),
    ]


def shoulder_parts() -> list[Part]:
    """Return the shoulder: a neck up from the base and the housing of the lift joint across it."""
    neck = turned([(0.056, -0.0640), (0.0605, -0.0590), (0.0605, 0.0)], caps="start")
    across = moved(joint_module(0.0610, -0.062, 0.066, cap=0.019), "-y", (0.0, 0.0, 0.0))
    ring = placed(seal(0.0575, 0.064, 0.0715), "-y")
    return [("housing", neck), *across, ("ring", ring)]


def upper_arm_parts() -> list[Part]:
    """Return the upper arm: a tube between the shoulder's and the elbow's housings."""
    side = UPPER_ARM_SIDE
    near = moved(joint_module(0.0605, -0.055, 0.067, cap=0.018), "-z", (0.0, 0.0, side))
    far = moved(joint_module(0.0575, -0.052, 0.063, cap=0.017), "-z", (A2, 0.0, side))
    tube = turned(
        [
            (0.0555, 0.03),
            (0.0555, 0.078, 0.006),
            (0.0510, 0.088),
            (0.0510, -A2 - 0.088),
            (0.0550, -A2 - 0.078, 0.006),
            (0.0550, -A2 - 0.03),
        ]
    )
    ring = placed(seal(0.0545, 0.061, 0.068), "-z", (A2, 0.0, side))
    return [*near, *far, ("tube", placed(tube, "-x", (0.0, 0.0, side))), ("ring", ring)]


def forearm_parts() -> list[Part]:
    """Return the forearm: elbow shell, a tube that tapers, and the housing of wrist 1."""
    side = FOREARM_SIDE
    elbow = moved(joint_module(0.0570, -0.048, 0.0635, cap=0.017), "+z", (0.0, 0.0, side))
    tube = turned(
        [
            (0.0500, 0.03),
            (0.0500, 0.074, 0.01),
            (0.0395, 0.118, 0.03),
            (0.0375, -A3 - 0.066),
            (0.0395, -A3 - 0.058, 0.004),
            (0.0395, -A3 - 0.02),
        ]
    )
    wrist = moved(
        joint_module(0.0425, -0.040, 0.054, cap=0.014, segments=20), "+z", (A3, 0.0, side)
    )
    ring = placed(seal(0.0395, 0.052, 0.059, segments=20), "+z", (A3, 0.0, side))
    return [*elbow, ("tube", placed(tube, "-x", (0.0, 0.0, side))), *wrist, ("ring", ring)]


def wrist_module(neck_length: float, output: str) -> list[Part]:
    """Return a wrist: a neck down to the link before it, and a housing across along ``output``."""
    neck = turned(
        [(0.0390, -neck_length), (0.0415, 0.004 - neck_length), (0.0415, 0.0)],
        segments=20,
        caps="start",
    )
    housing = joint_module(0.0420, -0.041, 0.0445, cap=0.014, segments=20)
    ring = seal(0.0390, 0.0425, 0.0505, segments=20)
    return [
        ("housing", neck),
        *moved(housing, output, (0.0, 0.0, 0.0)),
        ("ring", placed(ring, output)),
    ]


def wrist_3_parts() -> list[Part]:
    """Return the tool flange, whose face is the origin of the link."""
    flange = turned(
        [
            (0.0385, -0.0500),
            (0.0395, -0.0470),
            (0.0395, -0.0110, 0.003),
            (0.0315, -0.0060),
            (0.0315, 0.0),
        ],
        segments=20,
        caps="both",
    )
    return [("tube", flange)]


def gripper_parts() -> list[Part]:
    """Return the gripper's palm: a coupling, a body that widens, and the rail of the fingers."""
    coupling = turned(
        [(0.0375, 0.0), (0.0375, 0.0125, 0.0015), (0.0345, 0.0135)], segments=20, caps="start"
    )
    # The body grows from a disc over the flange into a bar as wide as the fingers' way.
    sections = [
        (0.0130, 0.0335, 0.0345, 0.032),
        (0.0330, 0.0325, 0.0365, 0.026),
        (0.0430, 0.0315, 0.0410, 0.018),
        (0.0620, 0.0280, 0.0600, 0.012),
        (0.0700, 0.0260, 0.0670, 0.010),
        (0.0850, 0.0240, 0.0700, 0.008),
        (0.0890, 0.0215, 0.0680, 0.007),
    ]
    rings = [
        np.column_stack(
            [
                rounded(rectangle((-x, x), (-y, y), radius), closed=True),
                np.full(4 * (ROUND_STEPS + 1), z),
            ]
        )
        for z, x, y, radius in sections
    ]
    body = loft(np.array(rings), cap_start=False, cap_end=True)
    rail = milled(
        rectangle((-0.013, 0.013), (-0.0665, 0.0665)), 0.0885, 0.0945, bevel=0.001, caps="end"
    )
    # A round cover on either broad side, where such grippers carry their linkage.
    cover = turned([(0.0135, 0.0), (0.0135, 0.0060, 0.0012), (0.0, 0.0065)], segments=16)
    covers = [placed(cover, axis, (x, 0.0, 0.040)) for axis, x in (("+x", 0.0275), ("-x", -0.0275))]
    return [
        ("metal", coupling),
        ("body", body),
        ("metal", rail),
        *(("metal", cover) for cover in covers),
    ]


def finger_parts() -> list[Part]:
    """Return the left finger, closed: pad face in the plane y = 0, its body on the side of +y."""
    low, high = TCP_HEIGHT - PAD_HEIGHT / 2, TCP_HEIGHT + PAD_HEIGHT / 2
    carriage = milled(
        rectangle((-0.0175, 0.0175), (0.0010, 0.0330), 0.004), 0.0925, 0.1080, bevel=0.0015
    )
    # Seen along x the finger is a blade that narrows from its carriage to the tip.
    blade = placed(
        milled(
            [
                (0.0035, 0.1060),
                (0.0300, 0.1060),
                (0.0140, low + 0.006, 0.02),
                (0.0105, high, 0.004),
                (0.0035, high, 0.001),
            ],
            -PAD_WIDTH / 2 + 0.0005,
            PAD_WIDTH / 2 - 0.0005,
            bevel=0.0012,
        ),
        "+x",
    )
    pad = placed(
        milled(
            rectangle((-PAD_WIDTH / 2, PAD_WIDTH / 2), (low, high), 0.002),
            0.0,
            0.0040,
            bevel=0.0006,
        ),
        "-y",
        (0.0, 0.0040, 0.0),
    )
    pin = turned([(0.0045, 0.0), (0.0045, 0.0020)], segments=12, caps="end")
    pins = [
        placed(pin, axis, (side * 0.0170, y, 0.10025))
        for axis, side in (("+x", 1.0), ("-x", -1.0))
        for y in (0.0090, 0.0250)
    ]
    return [
        ("body", carriage),
        ("body", blade),
        *(("metal", pin) for pin in pins),
        ("pad", pad),
    ]


def mirrored_parts(parts: Iterable[Part]) -> list[Part]:
    """Mirror every part of a list in y."""
    return [(color, mirrored(mesh)) for color, mesh in parts]
