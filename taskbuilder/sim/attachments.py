"""Links held to other bodies by constraints that can be made and undone, as a suction cup holds.

A gripper that attaches what it closes around holds by the same constraints.

Bullet solves constraints in the order in which they were made, and a snapshot holds none of them.
So all attachments of a client are made anew whenever one changes, in the order of their holders: a
restored state then goes on as it did, bit for bit.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from taskbuilder.geometry import ORIGIN, Pose, Vec3, dot
from taskbuilder.sim.body import Body, inertial_frame
from taskbuilder.sim.bullet import p
from taskbuilder.sim.client import Client

PROBE_M = 0.003
"""Radius of the ball that feels for a surface."""

FACING = -0.75
"""Cosine of the angle between a direction and the normal of the surface that it meets, at most."""

YIELDING = 2.0
"""A constraint exerts up to this multiple of the force at which its owner undoes it."""

UNLIMITED_N = 1e4
"""Force that a constraint exerts at most if no force undoes it; arms exert far less."""


@dataclass(frozen=True, slots=True)
class Attachment:
    """What a link holds.

    Attributes:
        body: Bullet's number of the held body.
        link: Index of its held link.
        at: Where the holder's frame is in the centre-of-mass frame of that link.
    """

    body: int
    link: int
    at: Pose


Graspable = tuple[Body, Collection[int] | None]
"""A body, and those of its links that can be held; None for all of them."""


class Surface(NamedTuple):
    """A surface near a point.

    Attributes:
        body: The body that it is of.
        link: Index of its link.
        gap: Distance in metres; negative if the point is inside.
    """

    body: Body
    link: int
    gap: float


class Holder:
    """A link that can hold others.

    Args:
        body: Its body.
        link: Its index.
        frame: The frame in which it holds, in the link's frame; it feels along z.
        force: Force in newtons at which its owner undoes the constraint; None for no such force.

    Attributes:
        attachment: What it holds, or None.
    """

    def __init__(self, body: Body, link: int, frame: Pose, force: float | None) -> None:
        self.attachment: Attachment | None = None
        self._client, self._body, self._link, self._frame = body.client, body, link, frame
        self._in_com = inertial_frame(body.client, body.id, link).inverse() @ frame
        self._most = UNLIMITED_N if force is None else YIELDING * force
        self._constraint: int | None = None
        self._ball: int = body.client.bullet.createCollisionShape(p.GEOM_SPHERE, radius=PROBE_M)
        body.client.holders.append(self)

    @property
    def pose(self) -> Pose:
        """Its frame in the world."""
        return self._body.link_pose(self._link) @ self._frame

    def hold(self, attachment: Attachment | None) -> None:
        """Hold something, or nothing."""
        if attachment != self.attachment:
            undo(self._client)
            self.attachment = attachment
            redo(self._client)

    def attach(self, surface: Surface) -> Attachment:
        """What it holds when it takes a surface as it stands."""
        body, link = surface.body, surface.link
        com = body.link_pose(link) @ inertial_frame(self._client, body.id, link)
        return Attachment(body.id, link, com.inverse() @ self.pose)

    def force(self) -> Vec3:
        """Force in newtons that what it holds exerted on it in the last physics step."""
        if self._constraint is None:
            return ORIGIN
        x, y, z, *_ = self._client.bullet.getConstraintState(self._constraint)
        return (x, y, z)

    def surface(self, bodies: Sequence[Body], within: float) -> Surface | None:
        """The nearest surface in front of it, within a distance in metres."""
        return self.surface_at(self.pose, bodies, within)

    def surface_at(self, pose: Pose, bodies: Sequence[Body], within: float) -> Surface | None:
        """The nearest surface that it would find in front of it at a pose in the world."""
        nearest: Surface | None = None
        centre = pose.apply((0.0, 0.0, -PROBE_M))
        for body in bodies:
            for point in self._feel(centre, pose, body, within):
                faces = dot(point[7], pose.axis(2)) < FACING
                if faces and point[8] <= within and (nearest is None or point[8] < nearest.gap):
                    nearest = Surface(body, point[4], point[8])
        return nearest

    def around(self, things: Iterable[Graspable], within: float) -> Surface | None:
        """The surface nearest to the origin of its frame on any side, within a distance in metres.

        Of equally near surfaces, the first. Of surfaces that it is inside, the deepest.
        """
        nearest: Surface | None = None
        for body, links in things:
            for point in self._feel(self.pose.position, self.pose, body, within):
                gap = point[8] + PROBE_M
                fits = gap <= within and (links is None or point[4] in links)
                if fits and (nearest is None or gap < nearest.gap):
                    nearest = Surface(body, point[4], gap)
        return nearest

    def _feel(self, centre: Vec3, pose: Pose, body: Body, within: float) -> Iterator[Any]:
        """Where a body is near the ball, as Bullet says it."""
        yield from self._client.bullet.getClosestPoints(
            bodyA=-1,
            bodyB=body.id,
            distance=within,
            collisionShapeA=self._ball,
            collisionShapePositionA=centre,
            collisionShapeOrientationA=pose.quaternion,
        )

    def make(self) -> None:
        """Make the constraint of its attachment, if it has one; for this module."""
        held = self.attachment
        if held is None:
            return
        bullet = self._client.bullet
        self._constraint = bullet.createConstraint(
            self._body.id,
            self._link,
            held.body,
            held.link,
            p.JOINT_FIXED,
            ORIGIN,
            self._in_com.position,
            held.at.position,
            self._in_com.quaternion,
            held.at.quaternion,
        )
        bullet.changeConstraint(self._constraint, maxForce=self._most)

    def unmake(self) -> None:
        """Remove its constraint, if it has one; for this module."""
        if self._constraint is not None:
            self._client.bullet.removeConstraint(self._constraint)
            self._constraint = None


def undo(client: Client) -> None:
    """Remove the constraints of all holders of a client, the last first."""
    for holder in reversed(client.holders):
        holder.unmake()


def redo(client: Client) -> None:
    """Make the constraints of all holders of a client again."""
    for holder in client.holders:
        holder.make()
