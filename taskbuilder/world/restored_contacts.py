"""Contacts of a restored state, which Bullet's snapshots do not always bring back."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from taskbuilder.geometry import Pose, scale
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import ContactPoint, contacts

PRESS_M = 3e-4
"""How deep links are pushed into each other to find their contact again."""


def touches_to_restore(client: Client) -> tuple[ContactPoint, ...]:
    """A contact of each two links that touch, the loosest last."""
    loosest: dict[tuple[int, ...], ContactPoint] = {}
    for c in sorted(contacts(client), key=lambda contact: -contact.distance):
        loosest.setdefault((c.body_a, c.link_a, c.body_b, c.link_b), c)
    return tuple(reversed(loosest.values()))


def part(client: Client, bodies: Iterable[Body]) -> None:
    """Move everything apart, so that nothing touches.

    Bullet restores the contacts of a snapshot, but where it has none it keeps the present ones,
    whose forces would carry over.
    """
    for number, body in enumerate(bodies, start=1):
        body.place(Pose((0.0, 0.0, 1000.0 * number)))
    client.collide()


def press(client: Client, bodies: Iterable[Body], touches: Sequence[ContactPoint]) -> None:
    """Push links that touch into each other for a moment, pair by pair.

    Bullet restores the contacts of two links only if it finds them near each other then, and of
    links of several shapes it looks closer than when it keeps a contact up: a gap of a few
    micrometres, as between a grip and what it holds, is enough to lose it.

    Args:
        client: The world.
        bodies: Those that can be moved.
        touches: A contact of each two links, the loosest last: to press one finger against what is
            held pulls the other off, which only the tighter contacts stand.
    """
    by_id = {body.id: body for body in bodies}
    for touch in touches:
        sign = -1.0 if touch.body_a in by_id else 1.0
        body = by_id[touch.body_a if touch.body_a in by_id else touch.body_b]
        pose = body.pose()
        depth = sign * (max(touch.distance, 0.0) + PRESS_M)
        body.place(pose.moved(scale(touch.normal_on_b, depth)))
        client.collide()
        body.place(pose)
