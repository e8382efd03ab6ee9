"""Hands in a URDF: which branches are fingers, how they move, and what opens between them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskbuilder.assets.mesh import read_mesh
from taskbuilder.assets.model import Urdf, UrdfJoint, UrdfShape
from taskbuilder.geometry import ORIGIN, Pose, Vec3
from taskbuilder.world.shapes import link_box

Points = NDArray[np.float64]

SAMPLES = 41
_FINGER_M = 0.4  # longer branches are arms
_FINGER_JOINTS, _FINGER_DEPTH = 8, 5
_STILL_M = 2e-3  # branches whose tips move less are no fingers
_TIP_M = 0.02  # the end of a finger whose inner side is its pad
_TOUCH_M = 3e-4
_OF_A_JAW = re.compile(r"grip|jaw|finger|claw|pinc|clamp", re.IGNORECASE)
_BESIDE = 0.4  # a fixed jaw reaches at least so far along the moving one
_WIDEST_RAD = 1.2  # a jaw is opened no further than this
_UNLIMITED_RAD = 0.5


@dataclass(frozen=True)
class Finger:
    """One finger of a hand.

    Attributes:
        links: The links of its tip that touch what is held; the outermost first.
        joints: The joints that move it, the nearest to the palm first; none for a fixed jaw.
    """

    links: tuple[str, ...]
    joints: tuple[UrdfJoint, ...]


@dataclass(frozen=True)
class Hand:
    """A gripper as it was found.

    Attributes:
        link: The palm.
        fingers: Its fingers.
        ends: Joint -> open and closed position, in rad or m.
        stroke: What is open between the fingers when the gripper is open, in metres.
        remarks: What could not be decided.
    """

    link: str
    fingers: tuple[Finger, ...]
    ends: Mapping[str, tuple[float, float]]
    stroke: float
    remarks: tuple[str, ...] = ()


def joints_below(urdf: Urdf, joint: UrdfJoint) -> list[UrdfJoint]:
    """The joints that move from a joint on outwards, with itself."""
    below = [joint] if joint.moves else []
    for other in urdf.joints:
        if other.parent == joint.child:
            below += joints_below(urdf, other)
    return below


def is_finger(urdf: Urdf, branch: UrdfJoint) -> bool:
    """Whether a branch is short enough for a finger."""
    chain = longest_chain(urdf, branch)
    if len(joints_below(urdf, branch)) > _FINGER_JOINTS or len(chain) > _FINGER_DEPTH:
        return False
    reach = max(
        (float(np.linalg.norm(points, axis=1).max()) for points in branch_points(urdf, branch)),
        default=0.0,
    )
    return reach < _FINGER_M


def is_rotor(urdf: Urdf, branch: UrdfJoint) -> bool:
    """Whether a branch is one small part that turns without end, such as a motor's horn."""
    below = joints_below(urdf, branch)
    return len(below) == 1 and below[0].type == "continuous" and is_finger(urdf, branch)


def longest_chain(urdf: Urdf, branch: UrdfJoint) -> list[UrdfJoint]:
    """The moving joints along the longest way outwards from a joint."""
    chains = [longest_chain(urdf, j) for j in urdf.joints if j.parent == branch.child]
    return [branch] * branch.moves + max(chains, key=len, default=[])


def find_hand(urdf: Urdf, link: str, branches: Sequence[UrdfJoint]) -> Hand | None:
    """The gripper on a link that several branches begin on; None if these are no fingers."""
    chains = {branch.name: longest_chain(urdf, branch) for branch in branches}
    moving = [b for b in branches if _tip_motion(urdf, link, chains[b.name]) > _STILL_M]
    limited = [b for b in moving if all(j.type != "continuous" for j in chains[b.name])]
    moving = limited if len(limited) >= 2 else moving
    if len(moving) == 1 and chains[moving[0].name] == [moving[0]]:
        return find_jaw(urdf, link, moving[0], sure=True)
    if not moving:
        return None
    longest = max(len(chains[branch.name]) for branch in moving)
    fingers = tuple(
        Finger(_tip_links(urdf, chains[branch.name][-1].child), tuple(chains[branch.name]))
        for branch in moving
        if len(chains[branch.name]) == longest
    )
    if len(fingers) < 2:
        return None
    joints = [joint for branch in moving for joint in joints_below(urdf, branch)]
    drivers = _drivers(joints)
    ends = _opened(urdf, link, fingers, drivers)
    gaps = []
    for share in np.linspace(0.0, 1.0, SAMPLES).tolist():
        positions = _followed(joints, {n: a + share * (b - a) for n, (a, b) in ends.items()})
        gaps.append(gap(urdf, link, fingers, positions))
    least = next((n for n, width in enumerate(gaps) if width <= _TOUCH_M), int(np.argmin(gaps)))
    share = least / (SAMPLES - 1)
    opened = _followed(joints, {name: a for name, (a, _) in ends.items()})
    closed = _followed(joints, {n: a + share * (b - a) for n, (a, b) in ends.items()})
    both = {joint.name: (opened[joint.name], closed[joint.name]) for joint in joints}
    remarks = []
    if gaps[least] > 2e-3:
        remarks.append(
            f"the fingers stay {gaps[least] * 1000:.0f} mm apart when they are closed; is there a "
            "pad that the URDF leaves out? thinner objects cannot be held"
        )
    return Hand(link, fingers, both, max(1e-3, gaps[0]), tuple(remarks))


def find_jaw(urdf: Urdf, link: str, joint: UrdfJoint, *, sure: bool = False) -> Hand | None:
    """A gripper of one jaw that moves against a fixed one; None if it is none.

    Args:
        urdf: The robot.
        link: The link that carries the jaw.
        joint: The only joint there.
        sure: Whether it is known to be no joint of the arm.
    """
    named = bool(_OF_A_JAW.search(joint.name) or _OF_A_JAW.search(joint.child))
    fixed = group_points(urdf, link, link, {})
    jaw = Finger(_tip_links(urdf, joint.child), (joint,))
    if joint.type == "continuous" or not len(fixed) or not (named or sure):
        return None
    origin = np.array(link_pose(urdf, link, joint.child, {}).position)
    lower, upper = _end(joint, 0.0), _end(joint, 1.0)
    shares = np.linspace(0.0, 1.0, SAMPLES).tolist()
    places = [
        group_points(urdf, link, joint.child, {joint.name: lower + share * (upper - lower)})
        for share in shares
    ]
    if not len(places[0]):
        return None
    tip = int(np.argmax(np.linalg.norm(places[0] - origin, axis=1)))
    away = [float(np.linalg.norm(fixed - place[tip], axis=1).min()) for place in places]
    closed = int(np.argmin(away))
    along = places[closed][tip] - origin
    length = float(np.linalg.norm(along))
    if length < 1e-3 or float(((fixed - origin) @ (along / length)).max()) < _BESIDE * length:
        return None  # nothing beside it that it could close against
    wide = 0.0 if closed > SAMPLES // 2 else 1.0
    at_closed = lower + shares[closed] * (upper - lower)
    at_open = lower + wide * (upper - lower)
    remarks = []
    if joint.type != "prismatic" and abs(at_open - at_closed) > _WIDEST_RAD:
        whole = np.degrees(abs(at_open - at_closed))
        at_open = at_closed + np.sign(at_open - at_closed) * _WIDEST_RAD
        remarks.append(
            f"the jaw could open by {whole:.0f}°; it is opened by {np.degrees(_WIDEST_RAD):.0f}°, "
            "beyond which it holds nothing. Is that right for your objects?"
        )
    opened = group_points(urdf, link, joint.child, {joint.name: at_open})
    stroke = float(np.linalg.norm(fixed - opened[tip], axis=1).min())
    remarks.append(
        f"{link} is taken for the fixed jaw, because only {joint.child} moves there. Or is "
        f"{joint.name} the last joint of the arm? Then append it to arm, and leave gripper out"
    )
    fingers = (jaw, Finger(_tip_links(urdf, link, fixed=True), ()))
    ends = {joint.name: (float(at_open), float(at_closed))}
    return Hand(link, fingers, ends, max(1e-3, stroke), tuple(remarks))


def pads(urdf: Urdf, hand: Hand, joints: Mapping[str, float]) -> tuple[Points, Points]:
    """The points of the two jaws of a one-jaw gripper: the moving one's, and the fixed one's."""
    moving = group_points(urdf, hand.link, hand.fingers[0].joints[-1].child, joints)
    return moving, group_points(urdf, hand.link, hand.link, {})


def gap(urdf: Urdf, hand: str, fingers: Sequence[Finger], joints: Mapping[str, float]) -> float:
    """What is open between the first two fingers, or twice the way of several to their middle.

    Args:
        urdf: The robot.
        hand: The palm.
        fingers: Two or more.
        joints: Positions of all joints of the hand, in rad or m.
    """
    tips = [finger_points(urdf, hand, finger, joints) for finger in fingers]
    middles = [tip.mean(axis=0) for tip in tips]
    if len(tips) > 2:
        middle = np.mean(middles, axis=0)
        return 2.0 * float(np.mean([np.linalg.norm(tip - middle, axis=1).min() for tip in tips]))
    across = middles[0] - middles[1]
    length = float(np.linalg.norm(across))
    if length < 1e-6:
        return 0.0
    y = snapped(across / length)
    out = np.mean(middles, axis=0)
    z = out - (out @ y) * y
    z /= max(float(np.linalg.norm(z)), 1e-9)
    inner = []
    for tip in tips:
        heights = tip @ z
        inner.append(tip[heights > heights.max() - _TIP_M] @ y)
    return float(inner[0].min() - inner[1].max())


def finger_points(urdf: Urdf, hand: str, finger: Finger, joints: Mapping[str, float]) -> Points:
    """The points of a finger's tip in the frame of the palm."""
    found = [link_points(urdf, hand, link, joints) for link in finger.links]
    found = [points for points in found if len(points)]
    if found:
        return np.concatenate(found)
    return np.array([link_pose(urdf, hand, finger.links[0], joints).position])


def group_points(urdf: Urdf, above: str, link: str, joints: Mapping[str, float]) -> Points:
    """The points of a link and all that is fixed to it outwards, in the frame of one above."""
    found = [link_points(urdf, above, one, joints) for one in (link, *frames_on(urdf, link))]
    return np.concatenate(found) if found else np.zeros((0, 3))


def link_points(urdf: Urdf, above: str, link: str, joints: Mapping[str, float]) -> Points:
    """The corners of a link's shapes, meshes by their points, in the frame of a link above."""
    pose = link_pose(urdf, above, link, joints)
    found = urdf.link(link)
    clouds = [_shape_points(shape) for shape in (found.collisions or found.visuals)]
    if not clouds:
        return np.zeros((0, 3))
    points = np.concatenate(clouds)
    axes = np.array([pose.axis(index) for index in range(3)])
    return np.asarray(points @ axes + np.array(pose.position), np.float64)


def _shape_points(shape: UrdfShape) -> Points:
    if shape.kind == "mesh" and shape.mesh is not None:
        points = mesh_points(shape.mesh) * np.array(shape.size)
    else:
        plain = UrdfShape(shape.kind, shape.size, Pose(), shape.mesh)
        points = np.array(list(link_box((plain,), 1.0).corners()))
    axes = np.array([shape.pose.axis(index) for index in range(3)])
    return np.asarray(points @ axes + np.array(shape.pose.position), np.float64)


@lru_cache(maxsize=64)
def mesh_points(path: Path) -> Points:
    """Points of a mesh as its file has them, each once, and at most 2,000 or so."""
    points = np.asarray(read_mesh(path).points, np.float64).reshape(-1, 3)
    unique = np.unique(np.round(points, 5), axis=0)
    return unique[:: max(1, len(unique) // 2000)]


def _tip_links(urdf: Urdf, link: str, *, fixed: bool = False) -> tuple[str, ...]:
    """A link with what is fixed to it outwards, as far as it can touch."""
    links = (link, *frames_on(urdf, link))
    touching = tuple(one for one in links if urdf.link(one).collisions)
    if fixed and touching:
        return touching
    return touching or (link,)


def frames_on(urdf: Urdf, hand: str) -> Iterator[str]:
    """The links that are fixed to a link, outwards."""
    for joint in urdf.joints:
        if joint.parent == hand and not joint.moves:
            yield joint.child
            yield from frames_on(urdf, joint.child)


def branch_points(urdf: Urdf, branch: UrdfJoint) -> Iterator[Points]:
    """The points of everything beyond a joint, in its frame, as it is at 0."""
    pending = [branch.child]
    while pending:
        link = pending.pop()
        points = link_points(urdf, branch.child, link, {})
        if len(points):
            yield points
        pending += [joint.child for joint in urdf.joints if joint.parent == link]


def _tip_motion(urdf: Urdf, hand: str, chain: Sequence[UrdfJoint]) -> float:
    """How far the tip at the end of a chain gets, in metres."""
    tip = Finger(_tip_links(urdf, chain[-1].child), tuple(chain))
    places = [
        finger_points(urdf, hand, tip, {joint.name: _end(joint, share) for joint in chain})
        for share in (0.0, 0.37, 1.0)
    ]
    return max(
        float(np.linalg.norm(places[a].mean(axis=0) - places[b].mean(axis=0)))
        for a, b in ((0, 1), (0, 2), (1, 2))
    )


def _drivers(joints: Sequence[UrdfJoint]) -> list[UrdfJoint]:
    """The joints that others mimic or that mimic none of these."""
    names = {joint.name for joint in joints}
    return [j for j in joints if j.mimic is None or j.mimic.joint not in names]


def _followed(joints: Sequence[UrdfJoint], driven: Mapping[str, float]) -> dict[str, float]:
    """The positions of all joints for those of the drivers."""
    positions = dict(driven)
    for _ in joints:  # followers may follow followers
        for joint in joints:
            if joint.mimic is not None and joint.mimic.joint in positions:
                value = joint.mimic.multiplier * positions[joint.mimic.joint] + joint.mimic.offset
                low = -np.inf if joint.lower is None else joint.lower
                high = np.inf if joint.upper is None else joint.upper
                positions[joint.name] = float(np.clip(value, low, high))
    return {joint.name: positions.get(joint.name, 0.0) for joint in joints}


def _opened(
    urdf: Urdf, hand: str, fingers: Sequence[Finger], drivers: Sequence[UrdfJoint]
) -> dict[str, tuple[float, float]]:
    """The open and the closed end of each driver: where the tips are further apart, and nearer."""
    joints = [j for finger in fingers for j in finger.joints]
    middle = {joint.name: _end(joint, 0.5) for joint in drivers}
    ends: dict[str, tuple[float, float]] = {}
    for driver in drivers:
        spreads = []
        for share in (0.0, 1.0):
            positions = _followed(joints, {**middle, driver.name: _end(driver, share)})
            tips = [finger_points(urdf, hand, f, positions).mean(axis=0) for f in fingers]
            center = np.mean(tips, axis=0)
            spreads.append(sum(float(np.linalg.norm(tip - center)) for tip in tips))
        wide = float(spreads[1] > spreads[0])
        ends[driver.name] = (_end(driver, wide), _end(driver, 1.0 - wide))
    return ends


def _end(joint: UrdfJoint, share: float) -> float:
    lower = -_UNLIMITED_RAD if joint.lower is None else joint.lower
    upper = _UNLIMITED_RAD if joint.upper is None else joint.upper
    return lower + share * (upper - lower)


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


ALIGNED = 0.97
"""Least cosine between axes that count as the same."""


def snapped(direction: Points, aligned: float = ALIGNED) -> Points:
    """A direction, or the axis of the frame that it is nearly along.

    Args:
        direction: Of length 1.
        aligned: Cosine of the angle to the axis from which on it is the axis.
    """
    index = int(np.argmax(np.abs(direction)))
    if abs(direction[index]) < aligned:
        return direction
    axis = np.zeros(3)
    axis[index] = np.sign(direction[index])
    return axis
