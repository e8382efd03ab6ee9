"""What a ray meets first."""

from __future__ import annotations

from typing import NamedTuple

from taskbuilder.geometry import Vec3
from taskbuilder.sim.client import Client


class RayHit(NamedTuple):
    """Where a ray ends.

    Attributes:
        body: Bullet's number of the body.
        point: In the world, m.
        normal: Of the surface, a unit vector.
    """

    body: int
    point: Vec3
    normal: Vec3


def first_hit(client: Client, start: Vec3, end: Vec3) -> RayHit | None:
    """What collides with a ray first, or None.

    Args:
        client: The world.
        start: In the world, m.
        end: In the world, m.
    """
    ((body, _, _, point, normal),) = client.bullet.rayTest(start, end)
    return None if body < 0 else RayHit(body, point, normal)
