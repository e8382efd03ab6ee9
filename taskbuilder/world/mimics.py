"""Joints of objects that mimic others: double doors, scissors, the two jaws of a vice.

PyBullet reads no ``<mimic>`` and leaves such joints independent. So each is geared to the one that
it mimics, as the joints of grippers are. The gear is a constraint with a large force, not a
command: it transmits force in both directions, and snapshots need to remember nothing of it.
"""

from __future__ import annotations

from collections.abc import Mapping

from taskbuilder.assets.model import Urdf, UrdfMimic
from taskbuilder.sim.body import Body
from taskbuilder.sim.motors import couple

FORCE = 1e4
"""What a gear transmits at most, N or N m: some ten times what an arm can exert."""


def mimics_of(urdf: Urdf, size: float) -> dict[str, UrdfMimic]:
    """What each joint that mimics another one follows, in the units of the scene.

    Args:
        urdf: The object.
        size: The factor on all of its lengths.
    """
    scales = {j.name: size if j.type == "prismatic" else 1.0 for j in urdf.moving_joints}
    return {
        joint.name: UrdfMimic(
            joint.mimic.joint,
            joint.mimic.multiplier * scales[joint.name] / scales[joint.mimic.joint],
            joint.mimic.offset * scales[joint.name],
        )
        for joint in urdf.moving_joints
        if joint.mimic is not None
    }


def starting(positions: Mapping[str, float], mimics: Mapping[str, UrdfMimic]) -> dict[str, float]:
    """Positions of joints (rad or m), with those that mimic others where these have them."""

    def position(name: str) -> float:
        mimic = mimics.get(name)
        if mimic is None:
            return positions[name]
        return mimic.multiplier * position(mimic.joint) + mimic.offset

    return {name: position(name) for name in positions}


def couple_joints(body: Body, mimics: Mapping[str, UrdfMimic]) -> None:
    """Gear every joint that mimics another one to it."""
    for name, mimic in mimics.items():
        couple(
            body.client,
            body,
            body.joints[mimic.joint].index,
            body.joints[name].index,
            ratio=mimic.multiplier,
            offset=mimic.offset,
            max_force=FORCE,
        )
