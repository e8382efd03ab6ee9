"""Contacts and distances between bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from taskbuilder.geometry import Pose, Vec3, dot
from taskbuilder.sim.body import BASE, Body
from taskbuilder.sim.client import Client

NEAR_M = 0.01
"""Gap up to which shapes are compared that have a contact, which may have opened a little."""

FAR_M = 1000.0
"""Where nothing is, above all else."""

TURNED = math.cos(math.radians(30.0))
"""Cosine of the angle from which on the normal of a contact is out of date."""


class ContactPoint(NamedTuple):
    """A point where two links touch.

    Attributes:
        body_a: Bullet's number of one body.
        link_a: Index of its link.
        body_b: Bullet's number of the other.
        link_b: Index of its link.
        position_on_b: Where on b, in the world (m).
        normal_on_b: Unit vector from b towards a, in the world.
        force: Along the normal, in newtons, averaged over the last physics step.
        distance: Gap in metres; negative when one is inside the other.
    """

    body_a: int
    link_a: int
    body_b: int
    link_b: int
    position_on_b: Vec3
    normal_on_b: Vec3
    force: float
    distance: float


def contacts(
    client: Client,
    body_a: Body | None = None,
    body_b: Body | None = None,
    *,
    link_a: int | None = None,
    link_b: int | None = None,
) -> tuple[ContactPoint, ...]:
    """Contacts as of the last physics step or `Client.collide`.

    Args:
        client: The world.
        body_a: Only contacts of this body, which is then ``body_a`` in all of them.
        body_b: Only contacts with this body.
        link_a: Only contacts of this link of ``body_a``.
        link_b: Only contacts with this link of ``body_b``.
    """
    found = client.bullet.getContactPoints(**_filter(body_a, body_b, link_a, link_b))
    return tuple(
        ContactPoint(a, link_of_a, b, link_of_b, position, normal, force, distance)
        for _, a, b, link_of_a, link_of_b, _, position, normal, distance, force, *_ in found
    )


def part(client: Client, bodies: Iterable[Body]) -> None:
    """Move everything apart, so that nothing touches.

    Bullet restores the contacts of a snapshot, but where it has none it keeps the present ones,
    whose forces would carry over.
    """
    for number, body in enumerate(bodies, start=1):
        body.place(Pose((0.0, 0.0, FAR_M * number)))
    client.collide()


def forget_turned(body: Body) -> None:
    """Have Bullet find contacts anew whose normals no longer point where they should.

    Bullet keeps the normal of a contact, in the world, for as long as the contact lasts. If both
    bodies turn together, as a gripper and what it holds, only one of the points between two shapes
    is found anew in each physics step. The others keep a normal that lags behind. Opening fingers
    would then pull, by contacts that seem to slide, what they should let go of.
    """
    bullet, turned = body.client.bullet, set()
    for contact in contacts(body.client, body):
        if contact.body_b not in turned:
            links = (contact.link_a, contact.link_b)
            nearest = bullet.getClosestPoints(body.id, contact.body_b, NEAR_M, *links)
            cosines = (dot(point[7], contact.normal_on_b) for point in nearest)
            if max(cosines, default=1.0) < TURNED:
                turned.add(contact.body_b)
    for other in sorted(turned):
        if bullet.getDynamicsInfo(other, BASE)[0] > 0.0:  # what is fixed does not turn
            _forget_contacts(body.client, other)


def _forget_contacts(client: Client, body_id: int) -> None:
    """Take a body away and put it back; Bullet forgets contacts only of what is far away."""
    bullet = client.bullet
    (x, y, z), turn = bullet.getBasePositionAndOrientation(body_id)
    velocity = bullet.getBaseVelocity(body_id)
    bullet.resetBasePositionAndOrientation(body_id, (x, y, z + FAR_M), turn)
    client.collide()
    bullet.resetBasePositionAndOrientation(body_id, (x, y, z), turn)
    bullet.resetBaseVelocity(body_id, *velocity)


def normal_force_reader(
    body_a: Body, body_b: Body, *, link_a: int | None = None, link_b: int | None = None
) -> Callable[[], float]:
    """Reads the sum of the normal forces (N) between two bodies, or links, in the last step.

    Cheap enough for every physics step: nothing is made of the contacts. The sum does not depend on
    the order in which Bullet lists them.
    """
    bullet, wanted = body_a.client.bullet, _filter(body_a, body_b, link_a, link_b)

    def read() -> float:
        points = bullet.getContactPoints(**wanted)
        return math.fsum([point[9] for point in points]) if points else 0.0

    return read


def _filter(
    body_a: Body | None, body_b: Body | None, link_a: int | None, link_b: int | None
) -> dict[str, int]:
    """What Bullet is told for contacts of these only."""
    wanted = {}
    if body_a is not None:
        wanted["bodyA"] = body_a.id
    if body_b is not None:
        wanted["bodyB"] = body_b.id
    if link_a is not None:
        wanted["linkIndexA"] = link_a
    if link_b is not None:
        wanted["linkIndexB"] = link_b
    return wanted


def closest_distance(body_a: Body, body_b: Body, within: float) -> float | None:
    """Smallest distance between two bodies (m), negative inside; None beyond ``within``.

    Needs no physics step or `Client.collide` before it.
    """
    points = body_a.client.bullet.getClosestPoints(body_a.id, body_b.id, within)
    return min((float(point[8]) for point in points), default=None)


def links_touch(body: Body, links: Sequence[int], other_id: int, within: float) -> bool:
    """Whether some links of a body come as near to another body as a distance in metres.

    Needs no physics step or `Client.collide` before it.
    """
    closest = body.client.bullet.getClosestPoints
    return any(closest(body.id, other_id, within, link) for link in links)


def links_near(body: Body, other: Body, within: float) -> frozenset[int]:
    """The links of a body that come as near to another body as a distance in metres.

    Needs no physics step or `Client.collide` before it.
    """
    points = body.client.bullet.getClosestPoints(body.id, other.id, within)
    return frozenset(point[3] for point in points)


def nearest_normal(
    body_a: Body, body_b: Body, within: float, *, link_a: int, link_b: int | None = None
) -> Vec3 | None:
    """Unit vector from b towards a where a link of a is nearest to b; None beyond ``within`` (m).

    Unlike `ContactPoint.normal_on_b` it is of this moment: Bullet leaves the normals of a contact
    as they were when it began, even if both bodies have turned together since.
    """
    wanted = _filter(None, None, link_a, link_b)
    points = body_a.client.bullet.getClosestPoints(body_a.id, body_b.id, within, **wanted)
    if not points:
        return None
    normal: Vec3 = min(points, key=lambda point: float(point[8]))[7]
    return normal


class ClosestPoint(NamedTuple):
    """Two links that are near each other.

    Attributes:
        link_a: Name of the link of one body.
        link_b: Name of the link of the other.
        distance: In metres; negative when one is inside the other.
        up: Height (z) of the unit vector from b towards a: 1 where a is straight above.
    """

    link_a: str
    link_b: str
    distance: float
    up: float


def gaps(body_a: Body, body_b: Body, within: float) -> list[ClosestPoint]:
    """Wherever two bodies are nearer than a distance (m); a pair of links may come repeatedly.

    Needs no physics step or `Client.collide` before it.
    """
    points = body_a.client.bullet.getClosestPoints(body_a.id, body_b.id, within)
    return [
        ClosestPoint(body_a.link_name(point[3]), body_b.link_name(point[4]), point[8], point[7][2])
        for point in points
    ]


def pressing_links(body_a: Body, body_b: Body) -> list[tuple[str, str]]:
    """The links of two bodies that touch, by name, where they press most first."""
    found = sorted(contacts(body_a.client, body_a, body_b), key=lambda contact: -contact.force)
    pairs = ((body_a.link_name(one.link_a), body_b.link_name(one.link_b)) for one in found)
    return [*dict.fromkeys(pairs)]


def copy_joints(body: Body, original: Body) -> None:
    """Put the joints of a body where those of its original are; see `pose_joints`."""
    moving = tuple(joint.index for joint in body.joints.values() if joint.type != "fixed")
    if moving:
        pose_joints(body, moving, original.joint_states(moving)[0])


def pose_joints(body: Body, indices: Sequence[int], positions: Sequence[float]) -> None:
    """Put joints at positions for a look at distances: `Body.reset_joints` at a fifth of the time.

    Contacts are stale until `Client.collide` or the next step.
    """
    body.client.bullet.resetJointStatesMultiDof(
        body.id, indices, [(position,) for position in positions]
    )
