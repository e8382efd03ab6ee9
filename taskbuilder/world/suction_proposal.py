"""Suction cups in a URDF: which link is the cup, where its mouth is, and what it may hold."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from taskbuilder.assets.model import Urdf
from taskbuilder.geometry import Pose, Vec3, from_axes
from taskbuilder.world.hands import Points, frames_on, link_points, link_pose, snapped

_OF_A_CUP = re.compile(
    r"suction|vacuum|(?<![a-z])(cups?|epick|airpick|vgc?p?\d+)(?![a-z])", re.IGNORECASE
)
_LIP_M = 0.002  # that the collision shape ends before the tcp: a soft lip gives way
_MOUTH_M = 0.004  # from the end of the cup, where its mouth is
_ALIGNED = 0.87  # within 30° of an axis of what is mounted, that axis is meant
_VACUUM_PA = 5e4


@dataclass(frozen=True)
class Cup:
    """A suction cup as it was found.

    Attributes:
        link: The link that touches what is held.
        tcp: Before the middle of its mouth, z out of it, in the frame of the link.
        force: At which it lets go, in newtons.
        remarks: What is to be checked.
    """

    link: str
    tcp: Pose
    force: float
    remarks: tuple[str, ...]


def names_cup(texts: Iterable[str]) -> bool:
    """Whether one of some names is that of a suction cup or a vacuum gripper."""
    return any(_OF_A_CUP.search(text) for text in texts)


def find_cup(urdf: Urdf, hand: str, force: float | None) -> Cup | None:
    """The suction cup at the end of an arm; None if there is none.

    Args:
        urdf: The robot.
        hand: The link that the arm ends in.
        force: At which it lets go, in newtons; 0 if it is known to be a cup and its force is not;
            None if nothing is known, so that its links have to be named like one.
    """
    links = [link for link in (hand, *frames_on(urdf, hand)) if _solid(urdf, link)]
    named = [link for link in links if names_cup([link])]
    if not links or (force is None and not named):
        return None
    clouds = {link: link_points(urdf, hand, link, {}) for link in links}
    root = np.array(link_pose(urdf, hand, _first(urdf, hand, (named or links)[-1]), {}).position)
    middle = np.mean(
        [points.mean(axis=0) for points in (clouds[n] for n in named or links)], axis=0
    )
    way = middle - root
    if float(np.linalg.norm(way)) < 1e-4:
        way = np.array(link_pose(urdf, hand, links[-1], {}).axis(2))
    z = snapped(way / float(np.linalg.norm(way)), _ALIGNED)
    cup = max(named or links, key=lambda link: float((clouds[link] @ z).max()))
    ends = np.concatenate([clouds[link] for link in links])
    end = float((ends @ z).max())
    mouth = ends[ends @ z > end - _MOUTH_M]
    x, y = _across(z)
    sides = np.stack([mouth @ x, mouth @ y], axis=1)
    low, high = sides.min(axis=0), sides.max(axis=0)
    across, along = ((low + high) / 2.0).tolist()
    point = (end + _LIP_M) * z + across * x + along * y
    pose = Pose(_vec(point), from_axes(_vec(x), _vec(y), _vec(z)))
    remarks = []
    width = float((high - low).min())
    if not force:
        force = float(f"{max(1.0, _VACUUM_PA * math.pi * (width / 2.0) ** 2):.2g}")
        remarks.append(
            f"the force of the cup is that of a vacuum of 50 kPa over its mouth of "
            f"{width * 1000:.0f} mm. What does the data sheet say? Then write it, or import with "
            "--suction NEWTONS"
        )
    return Cup(cup, link_pose(urdf, hand, cup, {}).inverse() @ pose, force, tuple(remarks))


def _solid(urdf: Urdf, link: str) -> bool:
    found = urdf.link(link)
    return bool(found.collisions or found.visuals)


def _first(urdf: Urdf, hand: str, link: str) -> str:
    """What is fixed to a hand itself, of the links that carry a link."""
    while link != hand:
        joint = urdf.joint_above(link)
        if joint is None or joint.parent == hand:
            return link
        link = joint.parent
    return hand


def _across(z: Points) -> tuple[Points, Points]:
    """The axes of a frame whose z axis is known; x is along that of the hand, or nearly so."""
    away = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    y = np.cross(z, away)
    y = y / float(np.linalg.norm(y))
    return np.cross(y, z), y


def _vec(values: Points) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z
