"""Which joints of a tree are an arm, and where several arms begin.

From the root, the joints that move are followed as long as there is one long way to go; these are
the arm. Short branches on the way, such as a head, are none of it. Where only fingers go on, there
is the hand.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.world.hands import (
    Hand,
    branch_points,
    find_hand,
    find_jaw,
    is_finger,
    is_rotor,
    joints_below,
)

FEW = 3
"""Joints that an arm has at least, in all likelihood."""

_FINGERS_M = 0.25  # beyond an arm, branches that are shorter are fingers, however many joints move


def find_arm(
    urdf: Urdf, end: str | None, remarks: list[str]
) -> tuple[tuple[UrdfJoint, ...], str, Hand | None]:
    """The joints of an arm, the link that it ends in, and the gripper there.

    Args:
        urdf: The robot.
        end: A link beyond the arm that is meant, where there are several.
        remarks: Where what could not be decided is noted.
    """
    arm: list[UrdfJoint] = []
    link = urdf.root
    while True:
        on = _branches(urdf, link)
        if not on:
            return tuple(arm), link, None
        if len(on) > 1:
            long = [joint for joint in on if not is_finger(urdf, joint)]
            if long and len(arm) >= FEW and _are_fingers(urdf, on):
                remarks.append(_of_a_hand(urdf, link, on))
                return tuple(arm), link, None
            if not long:
                hand = find_hand(urdf, link, on)
                if hand is not None or len(arm) >= FEW:  # a hand alone has no arm
                    return tuple(arm), link, hand
                long = [max(on, key=lambda joint: len(joints_below(urdf, joint)))]
            chosen = _chosen(urdf, long, end, remarks)
            others = [j.child for j in on if j not in long]
            if others:
                remarks.append(
                    f"{', '.join(others)} on {link} {'is' if len(others) == 1 else 'are'} taken "
                    "for no part of the arm, being short. Or is it a gripper?"
                )
            on = [chosen]
        joint = on[0]
        if joint.moves and len(joints_below(urdf, joint)) == 1 and arm:
            hand = find_jaw(urdf, link, joint)
            if hand is not None:
                return tuple(arm), link, hand
        if joint.moves and joint.mimic is None:
            arm.append(joint)
        link = joint.child


def arms_of_body(urdf: Urdf) -> tuple[UrdfJoint, ...]:
    """The joints that the arms of one body begin with; none unless there are two or more.

    They are the long branches of the link where, on the way outwards, several begin for the last
    time: legs begin nearer to the root than arms.
    """
    link, found = urdf.root, tuple[UrdfJoint, ...]()
    while on := _branches(urdf, link):
        long = [joint for joint in on if not is_finger(urdf, joint)]
        if not long or _are_fingers(urdf, on):
            break
        if len(arms := tuple(j for j in long if len(joints_below(urdf, j)) >= FEW)) > 1:
            found = arms
        link = max(long, key=lambda joint: len(joints_below(urdf, joint))).child
    return found


def links_below(urdf: Urdf, joint: UrdfJoint) -> set[str]:
    """The links from a joint on outwards."""
    links, pending = set(), [joint.child]
    while pending:
        link = pending.pop()
        links.add(link)
        pending += [other.child for other in urdf.joints if other.parent == link]
    return links


def _branches(urdf: Urdf, link: str) -> list[UrdfJoint]:
    """The joints of a link beyond which something moves, without rotors beside others."""
    on = [j for j in urdf.joints if j.parent == link and joints_below(urdf, j)]
    if len(on) > 1:
        on = [joint for joint in on if not is_rotor(urdf, joint)] or on
    return on


def _are_fingers(urdf: Urdf, branches: Sequence[UrdfJoint]) -> bool:
    """Whether branches are as short as fingers."""
    return len(branches) > 1 and all(
        float(np.linalg.norm(points, axis=1).max()) < _FINGERS_M
        for branch in branches
        for points in branch_points(urdf, branch)
    )


def _of_a_hand(urdf: Urdf, link: str, branches: Sequence[UrdfJoint]) -> str:
    count = len({joint.name for branch in branches for joint in joints_below(urdf, branch)})
    return (
        f"the arm ends at {link}: what begins there is a hand of {count} joints, more than a "
        "gripper that opens and closes has. Its joints are fixed, and the robot pushes. Is another "
        "gripper meant? Then import with --gripper FILE --at LINK"
    )


def _chosen(
    urdf: Urdf, long: Sequence[UrdfJoint], end: str | None, remarks: list[str]
) -> UrdfJoint:
    """The branch that is meant of several, the first of those with most joints by default."""
    if len(long) == 1:
        return long[0]
    for joint in long:
        if end is not None and end in links_below(urdf, joint):
            return joint
    most = max(len(joints_below(urdf, joint)) for joint in long)
    chosen = next(joint for joint in long if len(joints_below(urdf, joint)) == most)
    others = ", ".join(joint.child for joint in long if joint is not chosen)
    remarks.append(
        f"several arms begin on {chosen.parent}; this is the one from {chosen.child} on. Or is "
        f"another meant: {others}? Then import with --arm {others.partition(',')[0]}; --all-arms "
        "imports each as a robot"
    )
    return chosen
