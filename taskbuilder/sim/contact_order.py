"""The order in which Bullet solves contacts, which a snapshot holds only in part.

The contacts of two links are kept in manifolds, one for each pair of their shapes. Bullet solves
manifolds in the order of the links' numbers. For links of one shape each that is all: a snapshot
brings back the contacts of each pair, and the order follows. Of two links with several manifolds,
however, it brings back the first manifold only, and the order among them depends on what came near
what, and when, since the client was made. So from a snapshot the physics goes on to the bit as long
as no link of several shapes touches another link at several points.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import groupby
from pathlib import Path

from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import ContactPoint, contacts

_SPLITS = (b"o ", b"g ", b"usemtl ")
"""How a line of an OBJ begins after which faces may belong to another shape."""

Link = tuple[int, int]
"""Bullet's number of a body, and the index of a link."""


class ContactOrder:
    """Tells whether the order of contacts is certain although a snapshot was restored.

    Contacts between links that cannot move do not count: they have no effect.

    Args:
        client: The client.
        bodies: The bodies that can be placed; any other does not move.

    Attributes:
        watched: Whether the physics goes on from a snapshot, so that `look` is to be called after
            each physics step.
        uncertain: Whether the physics may have gone on differently since.
    """

    def __init__(self, client: Client, bodies: Iterable[Body]) -> None:
        self.watched = self.uncertain = False
        self._client = client
        self._read = client.bullet.getContactPoints
        every = [(body, link) for body in bodies for link in body.indices]
        self._moving = frozenset((body.id, link) for body, link in every if _moves(body, link))
        self._links = tuple(
            (body.id, link) for body, link in every if shape_count(client, body, link) > 1
        )

    def contacts(self) -> tuple[ContactPoint, ...]:
        """All contacts, in an order that does not depend on the order in which Bullet has them."""
        found = contacts(self._client)
        return tuple(sorted(c for c in found if self._counts((c[0], c[1]), (c[2], c[3]))))

    def restored(self, contacts_came_back: bool) -> None:
        """The physics goes on from a snapshot.

        Args:
            contacts_came_back: Whether all contacts are as they were when it was taken.
        """
        self.watched = bool(self._links)
        self.uncertain = not contacts_came_back or self.ambiguous

    def begun_anew(self) -> None:
        """The physics goes on from what is the same before every episode."""
        self.watched = self.uncertain = False

    @property
    def ambiguous(self) -> bool:
        """Whether a snapshot of this moment leaves out contacts, or might."""
        return any(True for link in self._links for _ in self._touched_by(link))

    def look(self) -> None:
        """A physics step has passed."""
        for link in self._links:
            if max(Counter(self._touched_by(link)).values(), default=0) > 1:
                self.uncertain = True

    def _touched_by(self, link: Link) -> Iterator[Link]:
        """The other link of each contact of a link."""
        for point in self._read(bodyA=link[0], linkIndexA=link[1]):
            other: Link = (point[2], point[4])
            if self._counts(link, other):
                yield other

    def _counts(self, link: Link, other: Link) -> bool:
        return link in self._moving or other in self._moving


def _moves(body: Body, link: int) -> bool:
    """Whether a link can move: its base is not fixed, or a joint above it is not."""
    above = {joint.child: joint for joint in body.joints.values()}
    while link != BASE:
        if above[link].type != "fixed":
            return True
        link = above[link].parent
    return body.inertia(BASE)[0] > 0.0


def shape_count(client: Client, body: Body, link: int) -> int:
    """Number of shapes with which a link collides, or more where that is not known."""
    shapes = client.bullet.getCollisionShapeData(body.id, link)
    return sum(_pieces(shape[4]) if shape[2] == p.GEOM_MESH else 1 for shape in shapes)


@cache
def _pieces(file: bytes) -> int:
    """Number of shapes that Bullet makes of a mesh file, or more where that is not known."""
    path = Path(file.decode())
    if path.suffix.lower() != ".obj":
        return 1
    try:
        lines = path.read_bytes().splitlines()
    except OSError:
        return 2
    marks = (line[:2] for line in lines if line.startswith((*_SPLITS, b"f ")))
    return max(1, sum(mark == b"f " for mark, _ in groupby(marks)))
