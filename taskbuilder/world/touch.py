"""What touches what in a world, and who holds it, read once a control step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from operator import attrgetter

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import ORIGIN, Vec3, add, scale, total
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import ContactPoint, contacts, nearest_normal
from taskbuilder.wording import suggestion
from taskbuilder.world.end_effector import Push
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject

_LINKS = attrgetter("body_b", "link_a", "link_b")
_SKIN_M = 2e-3  # of two that touch, the gap that Bullet may leave


class Touch:
    """Contacts between named bodies, parts and robots.

    The contacts of a body are read when first asked for, and kept until `refresh`.
    """

    def __init__(
        self, client: Client, robots: Mapping[str, Robot], objects: Mapping[str, SceneObject]
    ) -> None:
        self._client = client
        self._robots = robots
        self._objects = objects
        self._contacts: dict[int, Mapping[int, tuple[ContactPoint, ...]]] = {}
        self._held: dict[tuple[str, str], bool] = {}
        self._bodies: dict[str, tuple[Body, int | None]] = {}  # names stay what they are

    def refresh(self) -> None:
        """Forget what was read."""
        self._contacts.clear()
        self._held.clear()

    def held(self, body: str, robot: str) -> bool:
        """Whether a robot holds an object or part with its gripper."""
        known = self._held.get((body, robot))
        if known is None:
            holds = partial(self._robots[robot].gripper.holds, *self.body(body))
            known = holds(partial(self._pushes, body, robot)) or holds(
                partial(self._pushes_now, body, robot)
            )
            self._held[body, robot] = known
        return known

    def grip_forces(self, body: str, robot: str) -> tuple[float, ...]:
        """Force in newtons of each finger, or of the tool, of a robot on an object or part."""
        pushes = partial(self._pushes, body, robot)
        return self._robots[robot].gripper.forces(*self.body(body), pushes)

    def fingers_touch(self, body: str, robot: str) -> bool:
        """Whether any finger of a robot, or its tool, touches an object or part."""
        touches = self.between(robot, body)
        tips = {link for tip in self._robots[robot].gripper.tips for link in tip}
        return any(contact.link_a in tips for contact in touches) or self.held(body, robot)

    def support(self, body: str, below: str) -> float:
        """Upward force in newtons with which one object or part carries another."""
        return total(c.normal_on_b[2] * c.force for c in self.between(body, below))

    def between(self, first: str, second: str) -> tuple[ContactPoint, ...]:
        """Contacts of two named things, with the first as body a.

        Raises:
            UnknownNameError: There is no such object, part or robot.
        """
        one, one_link = self.body(first)
        other, other_link = self.body(second)
        of_one = self._contacts.get(one.id)
        if of_one is None:
            of_one = self._contacts[one.id] = self._read(one)
        found = of_one.get(other.id, ())
        if not found or (one_link is None and other_link is None):
            return found
        return tuple(
            contact
            for contact in found
            if one_link in (None, contact.link_a) and other_link in (None, contact.link_b)
        )

    def _read(self, body: Body) -> Mapping[int, tuple[ContactPoint, ...]]:
        """All contacts of a body, by the other body: mostly none, and one call finds them all.

        In the order of links, for sums depend on their order, and Bullet lists pairs of links in
        the order in which they came near each other.
        """
        found: dict[int, tuple[ContactPoint, ...]] = {}
        for contact in sorted(contacts(self._client, body), key=_LINKS):
            found[contact.body_b] = (*found.get(contact.body_b, ()), contact)
        return found

    def _pushes(self, body: str, robot: str) -> list[Push]:
        """What each tip of a robot does to an object or part; none if none touches."""
        touches = self.between(robot, body)
        pushes = []
        for tip in self._robots[robot].gripper.tips if touches else ():
            own = [contact for contact in touches if contact.link_a in tip]
            force = _total([scale(contact.normal_on_b, -contact.force) for contact in own])
            pushes.append(Push(force, _middle(own)))
        return pushes

    def _pushes_now(self, body: str, robot: str) -> list[Push]:
        """The same along the surface's normals of this moment; none unless two tips touch.

        A look at distances costs more than a contact that is known, so this is the second look: at
        what turned together with its gripper, whose contacts have the normals that they began with.
        """
        touches = self.between(robot, body)
        gripper, (other, part) = self._robots[robot].gripper, self.body(body)
        by_tip = [[c for c in touches if c.link_a in tip] for tip in gripper.tips]
        by_tip = [own for own in by_tip if own]
        return [self._push_now(robot, own, other, part) for own in by_tip if len(by_tip) > 1]

    def _push_now(
        self, robot: str, touches: Sequence[ContactPoint], other: Body, part: int | None
    ) -> Push:
        """The push of a tip that has these contacts with a body, or with a part of it."""
        tip = max(touches, key=lambda contact: contact.force).link_a
        body = self._robots[robot].body
        normal = nearest_normal(body, other, _SKIN_M, link_a=tip, link_b=part) or ORIGIN
        force = total(contact.force for contact in touches)
        return Push(scale(normal, -force), _middle(touches))

    def body(self, name: str) -> tuple[Body, int | None]:
        """The body of a name and, for a part or link, its index.

        Raises:
            UnknownNameError: There is no such object, part or robot.
        """
        known = self._bodies.get(name)
        if known is None:
            known = self._bodies[name] = self._find(name)
        return known

    def _find(self, name: str) -> tuple[Body, int | None]:
        owner, _, part = name.partition(".")
        if owner in self._robots and not part:
            return self._robots[owner].body, None
        if owner in self._objects:
            body = self._objects[owner].body
            if not part:
                return body, None
            if part in body.links:
                return body, body.links[part]
        known = (*self._objects, *self._robots)
        help_ = suggestion(owner, known, what="it has")
        raise UnknownNameError(f'the world has no body "{name}"; {help_}')


def _middle(touches: Sequence[ContactPoint]) -> Vec3:
    """The middle of some contacts; the origin where there are none."""
    return _total([scale(contact.position_on_b, 1.0 / len(touches)) for contact in touches])


def _total(vectors: Sequence[Vec3]) -> Vec3:
    total = ORIGIN
    for vector in vectors:
        total = add(total, vector)
    return total
