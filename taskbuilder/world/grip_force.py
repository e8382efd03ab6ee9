"""The force of a gripper's motors for a force of its fingertips: by their work, which is the same.

Two fingers that press with F on what they hold, while the opening between them closes by dw, do the
work F dw. The motors do the sum of M dq. So a motor's force or torque is M = F dw / sum of dq.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taskbuilder.assets.links import read_pose
from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.schema import number
from taskbuilder.world.hands import Hand, gap, pads
from taskbuilder.world.weights import ENTRIES

FINGERTIP_N = 20.0
"""Force of each finger that is proposed, in newtons: with it, what is grasped is rarely lost."""

LIGHT_KG = 0.015
"""Mass of a finger below which the engine's solver loses much of its force."""

LEAST_INERTIA = 1e-3
"""Principal moments, in kg·m², that links of turning gripper joints have at least.

Published grippers have knuckles of 5e-6, with which the solver does not converge; a geared motor's
rotor, which a URDF leaves out, adds about this much.
"""

_STEPS_PER_S = 120.0  # of physics, as task files have it by default
_SHARES = 0.3, 0.7  # of the way from open to closed, between which the motion is measured
_SANE_N = 4.0  # an effort that gives a finger less is a placeholder


def most_damping(inertia: float) -> float:
    """Damping of a joint, with which what it moves comes to rest, in N s/m or Nm s/rad.

    The engine applies damping once per physics step. From four times as much on, a step more than
    stops what moves; with eight times, it flies.

    Args:
        inertia: Mass in kg of what slides, or moment of inertia in kg·m² of what turns.
    """
    return inertia * _STEPS_PER_S / 4.0


def turned_inertia(urdf: Urdf, joint: UrdfJoint) -> float:
    """Moment of inertia of what a joint of a gripper turns, about its axis, as the engine has it.

    Joints further out are taken to move freely.
    """
    elements = {element.get("name"): element for element in urdf.tree.all("link")}
    about = 0.0
    for name, pose in urdf.fixed_to(joint.child):
        inertial, mass = elements[name].first("inertial"), urdf.link(name).mass
        if inertial is None or not mass:
            continue
        frame = pose @ read_pose(inertial)
        xx, xy, xz, yy, yz, zz = (
            number(inertial.first("inertia"), entry) or 0.0 for entry in ENTRIES
        )
        axis = np.array(frame.inverse().apply(joint.axis)) - np.array(frame.inverse().position)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        beside = np.cross(np.array(joint.axis), np.array(frame.position))
        about += float(axis @ tensor @ axis) + mass * float(beside @ beside)
    return max(LEAST_INERTIA, about)


@dataclass(frozen=True)
class MotorForce:
    """What the motors of a gripper are to exert.

    Attributes:
        force: Of each driven joint, in N or Nm.
        bounded: Whether it is the effort of the URDF, and less than what would be right.
        remark: What is to be known of it, or "".
    """

    force: float
    bounded: bool = False
    remark: str = ""


def motor_force(urdf: Urdf, hand: Hand) -> MotorForce:
    """The force of the motors for `FINGERTIP_N` at each finger.

    It is no more than the effort that the URDF gives the joints, unless this is too little to hold
    anything.
    """
    closing = abs(_opening(urdf, hand, _SHARES[1]) - _opening(urdf, hand, _SHARES[0]))
    driven = {finger.joints[0].name: finger.joints[0] for finger in hand.fingers if finger.joints}
    way = sum(abs(hand.ends[name][0] - hand.ends[name][1]) for name in driven)
    way *= _SHARES[1] - _SHARES[0]
    if not closing or not way:
        return MotorForce(FINGERTIP_N)
    pairs = len(hand.fingers) / 2.0 if len(hand.fingers) > 2 else 1.0
    wanted = FINGERTIP_N * pairs * closing / way
    efforts = [joint.effort for joint in driven.values() if joint.effort]
    most = min(efforts, default=wanted)
    if most >= wanted:
        return MotorForce(_rounded(wanted))
    at_finger = FINGERTIP_N * most / wanted
    if at_finger < _SANE_N:
        remark = (
            f"the URDF allows the joints of the gripper {most:g}, with which a finger presses with "
            f"{at_finger:.2g} N; {_rounded(wanted):g} is proposed. What does the data sheet say?"
        )
        return MotorForce(_rounded(wanted), remark=remark)
    remark = (
        f"force is the effort of the URDF, with which a finger presses with {at_finger:.2g} N; the "
        f"robots of the library press with about {FINGERTIP_N:g} N. What does the data sheet say? "
        f"For {FINGERTIP_N:g} N, write force: {_rounded(wanted):g} in robot.yaml"
    )
    return MotorForce(_rounded(most), bounded=True, remark=remark)


def _opening(urdf: Urdf, hand: Hand, share: float) -> float:
    """What is open between the fingers, at a share of the way from open to closed."""
    joints = {name: a + share * (b - a) for name, (a, b) in hand.ends.items()}
    if hand.fingers[-1].joints:
        return gap(urdf, hand.link, hand.fingers, joints)
    return _jaw_way(urdf, hand, joints)


def _jaw_way(urdf: Urdf, hand: Hand, joints: Mapping[str, float]) -> float:
    """How far the tip of a jaw is from where it is when it is closed."""
    closed = {name: ends[1] for name, ends in hand.ends.items()}
    moving, opened = pads(urdf, hand, closed)[0], pads(urdf, hand, joints)[0]
    widest = pads(urdf, hand, {name: ends[0] for name, ends in hand.ends.items()})[0]
    tip = int(np.argmax(np.linalg.norm(widest - moving, axis=1)))
    return float(np.linalg.norm(opened[tip] - moving[tip]))


def _rounded(force: float) -> float:
    return float(f"{force:.2g}")
