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
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from taskbuilder.sim.body import Body
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client

_GROUPS = (b"o ", b"g ", b"usemtl ")
"""How a line of an OBJ begins that may begin another shape."""


class ContactOrder:
    """Tells whether the order of contacts is certain although a snapshot was restored.

    Args:
        client: The client.
        bodies: The bodies that can be moved.

    Attributes:
        watched: Whether the physics goes on from a snapshot, so that `look` is to be called after
            each physics step.
        uncertain: Whether the physics may have gone on differently since.
    """

    def __init__(self, client: Client, bodies: Iterable[Body]) -> None:
        self.watched = self.uncertain = False
        self._read = client.bullet.getContactPoints
        self._links = tuple(
            (body.id, link)
            for body in bodies
            for link in body.indices
            if shape_count(client, body, link) > 1
        )

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
        return any(self._read(bodyA=body, linkIndexA=link) for body, link in self._links)

    def look(self) -> None:
        """A physics step has passed."""
        for body, link in self._links:
            points = self._read(bodyA=body, linkIndexA=link)
            if len(points) > 1 and max(Counter(point[2:5:2] for point in points).values()) > 1:
                self.uncertain = True


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
    return max(1, sum(line.startswith(_GROUPS) for line in lines))
