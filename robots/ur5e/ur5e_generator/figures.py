"""The UR5e in figures: published kinematics, the gripper's measures and the colours."""

from __future__ import annotations

import math

# Published: the DH table and the speed limit; masses and inertias stand with the links.
D1, A2, A3, D4, D5, D6 = 0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996  # m
MAX_SPEED = math.pi  # rad/s, 180 degrees a second in every joint

# How far the upper arm and the forearm lie beside the plane of the shoulder, along the joint axes.
# They cancel out in the kinematics (only d4 is left of them) and matter to shapes alone.
UPPER_ARM_SIDE, FOREARM_SIDE = 0.138, 0.007  # m

# The gripper: flange to pad centre, and half of the 85 mm stroke.
TCP_HEIGHT = 0.144  # m
FINGER_TRAVEL = 0.0425  # m
PAD_WIDTH, PAD_HEIGHT = 0.022, 0.044  # m
FINGER_DEPTH = 0.012  # m, thickness of a finger across the pad
PALM_HEIGHT = 0.100  # m

COLORS = {
    "tube": (0.79, 0.80, 0.81),
    "housing": (0.66, 0.675, 0.69),
    "cap": (0.45, 0.64, 0.78),
    "ring": (0.12, 0.125, 0.13),
    "body": (0.185, 0.19, 0.20),
    "metal": (0.46, 0.47, 0.49),
    "pad": (0.80, 0.80, 0.77),
}
