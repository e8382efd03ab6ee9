"""What touches what, where, and with which force."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskbuilder.sim.contacts import contacts
from taskbuilder.world.world import World

LEAST_N = 0.1
"""Smaller forces are left out, in newtons."""

METRES_PER_NEWTON, LONGEST_M = 0.005, 0.3
"""How long the line of a force is, and at most."""


class Contacts(NamedTuple):
    """The contacts of a world after a control step, as of its last physics step.

    Attributes:
        lines: (n, 2, 3) from each point of contact along its force, in metres.
        forces: The sum of the normal forces of each pair that touches, in newtons, by the dotted
            names of both links; the largest first.
    """

    lines: NDArray[np.float32]
    forces: dict[tuple[str, str], float]


def contacts_of(world: World) -> Contacts:
    """What touches in a world, and with which force."""
    points = [point for point in contacts(world.client) if point.force >= LEAST_N]
    links = [((p.body_a, p.link_a), (p.body_b, p.link_b)) for p in points]
    name = _names(world, [link for pair in links for link in pair])
    forces: dict[tuple[str, str], float] = {}
    for point, (one, other) in zip(points, links, strict=True):
        pair = name[one], name[other]
        forces[pair] = forces.get(pair, 0.0) + point.force
    lines = np.zeros((len(points), 2, 3), np.float32)
    for row, point in enumerate(points):
        length = min(point.force * METRES_PER_NEWTON, LONGEST_M)
        lines[row] = point.position_on_b
        lines[row, 1] += np.float32(length) * np.array(point.normal_on_b, np.float32)
    return Contacts(lines, dict(sorted(forces.items(), key=lambda item: -item[1])))


def _names(world: World, links: list[tuple[int, int]]) -> dict[tuple[int, int], str]:
    """The dotted names of links, which the physics engine knows by numbers."""
    bodies = np.array([body for body, _ in links], np.int32)
    numbers = world.segments.of(bodies, np.array([link for _, link in links], np.int32))
    names = world.segments.names
    named = (names[number] if number else "distractors" for number in numbers.tolist())
    return dict(zip(links, named, strict=True))
