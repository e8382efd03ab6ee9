"""A robot file for a bare URDF: which joints are the arm, which the gripper, and where the tool is.

The arm and its hand are found in the tree of joints; the tool's frame is measured on the fingers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.geometry import Pose, Vec3, from_axes
from taskbuilder.schema.robot import MOST_JOINTS
from taskbuilder.world.arm_branches import find_arm
from taskbuilder.world.grip_force import MotorForce, motor_force
from taskbuilder.world.hands import (
    ALIGNED,
    Hand,
    Points,
    finger_points,
    frames_on,
    link_corners,
    link_pose,
    pads,
    snapped,
)
from taskbuilder.world.home_proposal import ProposedHome, find_home
from taskbuilder.world.suction_proposal import Cup, find_cup

_SWINGS_M = 0.02  # fingertips that come so much further out by half of the way swing on an arc
_PAD_M = 0.015  # from the tip of a finger back to the middle of its pad
_FROM_FIXED_JAW_M = 0.024  # at most: objects up to twice as wide pass between the jaws
_JAW_ALIGNED = 0.87  # a jaw is bent; within 30° of an axis of its link, that axis is meant
_NEAR_M = 0.06  # a frame of the URDF is taken for the tool's if it is so near to the pads
_OF_A_TOOL = re.compile(r"tcp|tool|grasp|ee|tip|flange|hand", re.IGNORECASE)

__all__ = ["Proposal", "link_corners", "link_pose", "propose"]


@dataclass(frozen=True)
class Proposal:
    """What a robot file may say of a URDF.

    Attributes:
        arm: The arm's joints, base to wrist.
        tcp_link: The link that the tool is fixed to.
        tcp: The tool's frame in that of the link.
        home: Joint positions in rad or m.
        gripper: Joint -> open and closed position, in rad or m; empty where none was found.
        fingers: The links of each finger that touch what is held.
        stroke: Opening between the fingers, in metres.
        force: Of each driven joint of the gripper, in N or Nm; 0 without a gripper.
        bounded: Whether the effort of the URDF keeps the force from being what would be right.
        remarks: What its reader is to know or to check.
        cup: The suction cup, in place of a gripper; the tool's frame is that of its mouth.
    """

    arm: tuple[UrdfJoint, ...]
    tcp_link: str
    tcp: Pose
    home: tuple[float, ...]
    gripper: Mapping[str, tuple[float, float]]
    fingers: tuple[tuple[str, ...], ...]
    stroke: float
    force: float
    bounded: bool
    remarks: tuple[str, ...]
    cup: Cup | None = None

    @property
    def too_long(self) -> str:
        """What is wrong with a chain of more joints than an arm may have, such as a snake's."""
        if len(self.arm) <= MOST_JOINTS:
            return ""
        return (
            f"{len(self.arm)} joints move one after the other, and an arm has at most "
            f"{MOST_JOINTS}; make some of them fixed, or import the part of the robot that is an "
            "arm"
        )

    @property
    def touching(self) -> tuple[str, ...]:
        """The links that touch what is held."""
        fingers = dict.fromkeys(link for finger in self.fingers for link in finger)
        return (*fingers, *((self.cup.link,) if self.cup else ()))

    @property
    def open(self) -> dict[str, float]:
        """Joint positions at home with the gripper open."""
        arm = dict(zip((joint.name for joint in self.arm), self.home, strict=True))
        return arm | {name: ends[0] for name, ends in self.gripper.items()}

    def unused(self, urdf: Urdf) -> tuple[UrdfJoint, ...]:
        """The joints of a URDF that move and belong to neither arm nor gripper."""
        used = {joint.name for joint in self.arm} | set(self.gripper)
        return tuple(joint for joint in urdf.moving_joints if joint.name not in used)


def propose(
    urdf: Urdf,
    *,
    end: str | None = None,
    home: Mapping[str, float] | None = None,
    suction: float | None = None,
) -> Proposal | None:
    """Propose a robot file for a URDF; None if it has no arm that can be told apart.

    Args:
        urdf: The robot.
        end: A link beyond the arm that is meant, where there are several.
        home: A posture that its maker names, joint -> position in rad or m.
        suction: Force in newtons of the suction cup that it ends in, 0 for an unknown one; None if
            links have to be named like a cup to be one.
    """
    remarks: list[str] = []
    arm, hand, found = find_arm(urdf, end, remarks)
    if not arm:
        return None
    force, cup = MotorForce(0.0), None
    if found is not None:
        remarks += found.remarks
        force = motor_force(urdf, found)
        remarks += [force.remark] if force.remark else []
        link, tcp = _tool(urdf, found)
        if len(found.fingers) > 2:
            remarks.append(
                f"{len(found.fingers)} fingers were found, and y of the tcp is along the line "
                "between the first two. Do the others oppose them?"
            )
    elif (cup := find_cup(urdf, hand, suction)) is not None:
        remarks += cup.remarks
        link, tcp = cup.link, cup.tcp
    else:
        remarks.append(
            "no gripper was found: no link has two or more fingers that move, or one jaw beside a "
            "fixed one; as it is, the robot pushes"
        )
        link, tcp = _pushing(urdf, hand)
    opened = {name: ends[0] for name, ends in found.ends.items()} if found else {}
    if home is not None:
        start = _named(arm, home)
    else:
        best = find_home(urdf, arm, link, tcp, opened)
        start = best.joints
        remarks += _doubts(best)
    return Proposal(
        arm,
        link,
        tcp,
        start,
        found.ends if found else {},
        tuple(finger.links for finger in found.fingers) if found else (),
        found.stroke if found else 0.0,
        force.force,
        force.bounded,
        tuple(remarks),
        cup,
    )


def _tool(urdf: Urdf, hand: Hand) -> tuple[str, Pose]:
    """The frame between the pads: z out of the hand, y from one finger to the other."""
    if not hand.fingers[-1].joints:
        return hand.link, _jaw_tool(urdf, hand)
    tips = _tips(urdf, hand, 0.0)
    places = np.array([(tip.min(axis=0) + tip.max(axis=0)) / 2.0 for tip in tips])
    middle = places.mean(axis=0)
    closing = places[0] - places[1]
    y = snapped(closing / max(float(np.linalg.norm(closing)), 1e-9))
    out = middle - (middle @ y) * y
    z = snapped(out / max(float(np.linalg.norm(out)), 1e-9))
    z = z - (z @ y) * y
    z = z / max(float(np.linalg.norm(z)), 1e-9)
    reach, half_closed = (
        max(float((tip @ z).max()) for tip in _tips(urdf, hand, share)) for share in (0.0, 0.5)
    )
    if abs(half_closed - reach) > _SWINGS_M:  # what is held is not where the open tips are
        reach = half_closed
    point = middle + (reach - _PAD_M - middle @ z) * z
    pose = _frame(point, y, z)
    for link in frames_on(urdf, hand.link):
        own = link_pose(urdf, hand.link, link, {})
        near = np.linalg.norm(np.array(own.position) - point) < _NEAR_M
        along = np.array(own.axis(2)) @ z > ALIGNED and abs(np.array(own.axis(1)) @ y) > ALIGNED
        if near and along and _OF_A_TOOL.search(link):
            return link, Pose()
    return hand.link, pose


def _tips(urdf: Urdf, hand: Hand, closed: float) -> list[Points]:
    """Points of each finger, with the gripper closed to a share."""
    at = {name: (1.0 - closed) * ends[0] + closed * ends[1] for name, ends in hand.ends.items()}
    return [finger_points(urdf, hand.link, finger, at) for finger in hand.fingers]


def _jaw_tool(urdf: Urdf, hand: Hand) -> Pose:
    """The frame before the pad of a fixed jaw: y across it, z along it."""
    (name, (opened, closed)) = next(iter(hand.ends.items()))
    moving, fixed = pads(urdf, hand, {name: closed})
    joint = hand.fingers[0].joints[-1]
    origin = np.array(link_pose(urdf, hand.link, joint.child, {}).position)
    tip = int(np.argmax(np.linalg.norm(moving - origin, axis=1)))
    turn = np.array(link_pose(urdf, hand.link, joint.child, {}).apply(joint.axis)) - origin
    along = moving[tip] - origin
    if joint.type != "prismatic":  # the tool lies in the plane in which the jaw turns
        along = along - (along @ turn) * turn
    z = snapped(along / max(float(np.linalg.norm(along)), 1e-9), _JAW_ALIGNED)
    wide, _ = pads(urdf, hand, {name: opened})
    across = wide[tip] - moving[tip]
    if joint.type != "prismatic":
        across = across - (across @ turn) * turn
    y = across - (across @ z) * z
    y = snapped(y / max(float(np.linalg.norm(y)), 1e-9), _JAW_ALIGNED)
    z = z - (z @ y) * y
    z = z / max(float(np.linalg.norm(z)), 1e-9)
    end = float(min((moving @ z).max(), (fixed @ z).max()))
    pad = fixed[fixed @ z > end - 2.0 * _PAD_M]
    x = np.cross(y, z)
    side = float(((moving[tip] @ x) + float(np.median(pad @ x))) / 2.0) if len(pad) else 0.0
    face = float((pad @ y).max()) if len(pad) else float(moving[tip] @ y)
    face = min(face, float(moving[tip] @ y))
    before = min(_FROM_FIXED_JAW_M, (float(wide[tip] @ y) - face) / 2.0)
    point = (end - _PAD_M) * z + (face + before) * y + side * x
    return _frame(point, y, z)


def _frame(point: Points, y: Points, z: Points) -> Pose:
    return Pose(_vec(point), from_axes(_vec(np.cross(y, z)), _vec(y), _vec(z)))


def _pushing(urdf: Urdf, hand: str) -> tuple[str, Pose]:
    """The outermost frame on the last link, on a link there that can touch something."""
    frame = [hand, *frames_on(urdf, hand)][-1]
    link, tcp = frame, Pose()
    while not urdf.link(link).collisions:
        joint = urdf.joint_above(link)
        if joint is None or joint.moves:
            return frame, Pose()
        link, tcp = joint.parent, joint.origin @ tcp
    return link, tcp


def _named(arm: Sequence[UrdfJoint], home: Mapping[str, float]) -> tuple[float, ...]:
    """A posture that somebody has named, within the limits."""
    return tuple(
        float(
            np.clip(
                home.get(joint.name, 0.0),
                -np.inf if joint.lower is None else joint.lower,
                np.inf if joint.upper is None else joint.upper,
            )
        )
        for joint in arm
    )


def _doubts(home: ProposedHome) -> list[str]:
    """What is to be known of a posture that is not all that a home should be."""
    remarks = []
    if not home.pointing:
        remarks.append(
            "no home was found in which the tool points down. Does home_deg suit your tasks?"
        )
    if not home.clear:
        remarks.append(
            "in home_deg, links are below the base plane or in each other, and no better was "
            "found. Which joint positions does the maker call home?"
        )
    return remarks


def _vec(values: Points) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z
