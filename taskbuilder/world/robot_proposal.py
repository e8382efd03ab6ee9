"""A robot file for a bare URDF: which joints are the arm, which the gripper, and where the tool is.

From the root, the joints that move are followed as long as there is one way to go; these are the
arm. Where several ways go on, there is the hand, and its longest ways are the fingers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.geometry import ORIGIN, Pose, Vec3, from_axes, from_rpy_deg
from taskbuilder.kinematics.chain import Chain
from taskbuilder.kinematics.inverse import solve
from taskbuilder.world.shapes import link_box

FORCE_N, TURNING_FORCE = 20.0, 1.0
_SAMPLES = 21
_PAD_M = 0.015  # from the tip of a finger back to the middle of its pad
_NEAR_M = 0.06  # a frame of the URDF is taken for the tool's if it is so near to the pads
_ALIGNED = 0.97  # least cosine between axes that count as the same
_OF_A_TOOL = re.compile(r"tcp|tool|grasp|ee|tip|flange|hand", re.IGNORECASE)
_SEVERAL_ARMS = 3  # joints in each of several branches that are arms, not fingers


@dataclass(frozen=True)
class Proposal:
    """What a robot file may say of a URDF.

    Attributes:
        arm: The arm's joints, base to wrist.
        tcp_link: The link that the tool is fixed to.
        tcp: The tool's frame in that of the link.
        home: Joint positions in rad or m.
        gripper: Joint -> open and closed position, in rad or m; empty where none was found.
        fingers: The last link of each finger.
        stroke: Opening between the fingers, in metres.
        remarks: What its reader is to know or to check.
    """

    arm: tuple[UrdfJoint, ...]
    tcp_link: str
    tcp: Pose
    home: tuple[float, ...]
    gripper: Mapping[str, tuple[float, float]]
    fingers: tuple[str, ...]
    stroke: float
    remarks: tuple[str, ...]

    @property
    def open(self) -> dict[str, float]:
        """Joint positions at home with the gripper open."""
        arm = dict(zip((joint.name for joint in self.arm), self.home, strict=True))
        return arm | {name: ends[0] for name, ends in self.gripper.items()}


def propose(urdf: Urdf) -> Proposal | None:
    """Propose a robot file for a URDF; None if it has no arm that can be told apart."""
    arm, hand, branches = _arm_and_hand(urdf)
    if not arm:
        return None
    if sum(len(_joints_below(urdf, branch)) >= _SEVERAL_ARMS for branch in branches) > 1:
        return None
    gripper, fingers, stroke = _gripper(urdf, hand, branches)
    remarks: list[str] = []
    if fingers:
        link, tcp = _tool(urdf, hand, gripper, fingers)
    else:
        remarks.append(
            "no gripper was found: no link has two or more fingers that move; as it is, the robot "
            "pushes"
        )
        link, tcp = _last_frame(urdf, hand), Pose()
    home, pointing = _home(urdf, arm, link, tcp)
    if not pointing:
        remarks.append("no home was found in which the tool points down; home_deg is near zero")
    return Proposal(arm, link, tcp, home, gripper, fingers, stroke, tuple(remarks))


def _arm_and_hand(urdf: Urdf) -> tuple[tuple[UrdfJoint, ...], str, list[UrdfJoint]]:
    """The arm, the link that it ends in, and the joints there that lead to what moves beyond."""
    arm: list[UrdfJoint] = []
    link = urdf.root
    while True:
        on = [j for j in urdf.joints if j.parent == link and _joints_below(urdf, j)]
        if len(on) != 1:
            return tuple(arm), link, on
        arm += [on[0]] if on[0].moves else []
        link = on[0].child


def _joints_below(urdf: Urdf, joint: UrdfJoint) -> list[UrdfJoint]:
    """The joints that move from a joint on outwards, with itself."""
    below = [joint] if joint.moves else []
    for other in urdf.joints:
        if other.parent == joint.child:
            below += _joints_below(urdf, other)
    return below


def _gripper(
    urdf: Urdf, hand: str, branches: Sequence[UrdfJoint]
) -> tuple[dict[str, tuple[float, float]], tuple[str, ...], float]:
    """Open and closed position of each joint of the hand, the fingers, and their opening."""
    ways = [_joints_below(urdf, branch) for branch in branches]
    if len(ways) < 2:
        return {}, (), 0.0
    longest = max(map(len, ways))
    fingers = tuple(way[-1].child for way in ways if len(way) == longest)
    if len(fingers) < 2:
        return {}, (), 0.0
    middle = np.mean([_middle(urdf, hand, finger, {}) for finger in fingers], axis=0)
    ends: dict[str, tuple[float, float]] = {}
    for way in ways:
        tip = way[-1].child
        apart = [
            float(np.linalg.norm(_middle(urdf, hand, tip, _at(way, share)) - middle))
            for share in (0.0, 1.0)
        ]
        wide = float(apart[1] > apart[0])
        for joint in way:
            ends[joint.name] = (_end(joint, wide), _end(joint, 1.0 - wide))
    gaps = []
    for share in np.linspace(0.0, 1.0, _SAMPLES).tolist():
        joints = {name: a + share * (b - a) for name, (a, b) in ends.items()}
        places = [_middle(urdf, hand, finger, joints) for finger in fingers]
        gaps.append(float(np.linalg.norm(places[0] - places[1])))
    least = int(np.argmin(gaps)) / (_SAMPLES - 1)
    closed = {name: (a, a + least * (b - a)) for name, (a, b) in ends.items()}
    return closed, fingers, max(1e-3, gaps[0] - min(gaps))


def _at(way: Sequence[UrdfJoint], share: float) -> dict[str, float]:
    return {joint.name: _end(joint, share) for joint in way}


def _end(joint: UrdfJoint, share: float) -> float:
    lower = -0.5 if joint.lower is None else joint.lower
    upper = 0.5 if joint.upper is None else joint.upper
    return lower + share * (upper - lower)


def _tool(
    urdf: Urdf, hand: str, gripper: Mapping[str, tuple[float, float]], fingers: Sequence[str]
) -> tuple[str, Pose]:
    """The frame between the pads: z out of the hand, y from one finger to the other."""
    opened = {name: ends[0] for name, ends in gripper.items()}
    places = np.array([_middle(urdf, hand, finger, opened) for finger in fingers])
    middle = places.mean(axis=0)
    closing = places[0] - places[1]
    y = _snapped(closing / max(float(np.linalg.norm(closing)), 1e-9))
    out = middle - (middle @ y) * y
    z = _snapped(out / max(float(np.linalg.norm(out)), 1e-9))
    z = z - (z @ y) * y
    z = z / max(float(np.linalg.norm(z)), 1e-9)
    reach = max(
        float(np.array(corner) @ z)
        for finger in fingers
        for corner in link_corners(urdf, hand, finger, opened)
    )
    point = middle + (reach - _PAD_M - middle @ z) * z
    x = np.cross(y, z)
    pose = Pose(_vec(point), from_axes(_vec(x), _vec(y), _vec(z)))
    for link in _frames_on(urdf, hand):
        own = link_pose(urdf, hand, link, {})
        near = np.linalg.norm(np.array(own.position) - point) < _NEAR_M
        along = np.array(own.axis(2)) @ z > _ALIGNED and abs(np.array(own.axis(1)) @ y) > _ALIGNED
        if near and along and _OF_A_TOOL.search(link):
            return link, Pose()
    return hand, pose


def _last_frame(urdf: Urdf, hand: str) -> str:
    """The outermost frame that is fixed to the last link, or the link."""
    return [hand, *_frames_on(urdf, hand)][-1]


def _frames_on(urdf: Urdf, hand: str) -> Iterator[str]:
    """The links that are fixed to a link."""
    for joint in urdf.joints:
        if joint.parent == hand and not joint.moves:
            yield joint.child
            yield from _frames_on(urdf, joint.child)


def _home(
    urdf: Urdf, arm: Sequence[UrdfJoint], link: str, tcp: Pose
) -> tuple[tuple[float, ...], bool]:
    """Joint positions with the tool pointing down before the base, and whether it does."""
    chain = Chain.of(urdf, [joint.name for joint in arm], link, tcp)
    start = tuple(
        float(np.clip(0.0, low, high)) for low, high in zip(chain.lower, chain.upper, strict=True)
    )
    length = float(np.linalg.norm(chain.frames[:, :3, 3], axis=1).sum())
    rng = np.random.default_rng(0)
    for away, high in ((0.45, 0.25), (0.35, 0.35), (0.55, 0.15), (0.3, 0.1), (0.25, 0.5)):
        for yaw in (0.0, 90.0):
            turn = from_rpy_deg((180.0, 0.0, yaw))
            target = Pose((away * length, 0.0, high * length), turn)
            found = solve(chain, target, start=start, rng=rng)
            if found.ok:
                return found.joints, True
    return start, False


def link_corners(urdf: Urdf, above: str, link: str, joints: Mapping[str, float]) -> list[Vec3]:
    """The corners of a link's bounding box in the frame of a link above it.

    Args:
        urdf: The robot.
        above: The link above, such as the hand or the root.
        link: The link.
        joints: Positions of joints between the two, in m or rad; others are at 0.
    """
    pose = link_pose(urdf, above, link, joints)
    found = urdf.link(link)
    shapes = found.collisions or found.visuals
    if not shapes:
        return [pose.position]
    return [pose.apply(corner) for corner in link_box(shapes, 1.0).corners()]


def _middle(urdf: Urdf, hand: str, link: str, joints: Mapping[str, float]) -> NDArray[np.float64]:
    middle: NDArray[np.float64] = np.mean(link_corners(urdf, hand, link, joints), axis=0)
    return middle


def link_pose(urdf: Urdf, above: str, link: str, joints: Mapping[str, float]) -> Pose:
    """The pose of a link in the frame of one above it, with joints as given and others at 0."""
    pose = Pose()
    while link != above:
        joint = urdf.joint_above(link)
        if joint is None:
            return pose
        pose = joint.origin @ _moved(joint, joints.get(joint.name, 0.0)) @ pose
        link = joint.parent
    return pose


def _moved(joint: UrdfJoint, position: float) -> Pose:
    if not joint.moves:
        return Pose()
    x, y, z = joint.axis
    if joint.type == "prismatic":
        return Pose((x * position, y * position, z * position))
    sine = float(np.sin(position / 2))
    return Pose(ORIGIN, (x * sine, y * sine, z * sine, float(np.cos(position / 2))))


def _snapped(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """A direction, or the axis of the frame that it is nearly along."""
    index = int(np.argmax(np.abs(direction)))
    if abs(direction[index]) < _ALIGNED:
        return direction
    axis = np.zeros(3)
    axis[index] = np.sign(direction[index])
    return axis


def _vec(values: NDArray[np.float64]) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z
