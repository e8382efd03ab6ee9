"""Keeping what is solved together in one order, so that the same state always goes on the same.

Bullet solves contacts and motors island by island: bodies that are near each other make an island.
Islands are numbered by the order in which pairs of bodies came near each other, ever since the
client was made, and the numbers decide the order of the motors within an island. A snapshot does
not hold that order: after an episode rich in contacts, a restored state would go on a little
differently. With all bodies in one island there is one order, that of building.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from taskbuilder.geometry import ORIGIN
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.bullet import p


def unite(bodies: Sequence[Body]) -> None:
    """Put bodies that move into one island, by gears that can exert no force.

    They take about a sixth of the time of a physics step.

    Args:
        bodies: All that move, of one client. Of a body with joints, the link that moves the last
            is taken: the base may be fixed.
    """
    for one, other in pairwise(bodies):
        bullet = one.client.bullet
        constraint = bullet.createConstraint(
            one.id, _moving(one), other.id, _moving(other), p.JOINT_GEAR, *(ORIGIN,) * 3
        )
        bullet.changeConstraint(constraint, maxForce=0.0)


def _moving(body: Body) -> int:
    """A link that moves."""
    return max((j.child for j in body.joints.values() if j.type != "fixed"), default=BASE)
