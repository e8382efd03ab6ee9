"""What touches what in a world, and who holds it, read once a control step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import ORIGIN, Vec3, add, scale
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import ContactPoint, contacts
from taskbuilder.wording import suggestion
from taskbuilder.world.end_effector import Push
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject


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
            pushes = partial(self._pushes, body, robot)
            known = self._robots[robot].gripper.holds(*self.body(body), pushes)
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
        return sum(c.normal_on_b[2] * c.force for c in self.between(body, below))

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
        """All contacts of a body, by the other body: mostly none, and one call finds them all."""
        found: dict[int, tuple[ContactPoint, ...]] = {}
        for contact in contacts(self._client, body):
            found[contact.body_b] = (*found.get(contact.body_b, ()), contact)
        return found

    def _pushes(self, body: str, robot: str) -> list[Push]:
        """What each tip of a robot does to an object or part; none if none touches."""
        touches = self.between(robot, body)
        pushes = []
        for tip in self._robots[robot].gripper.tips if touches else ():
            own = [contact for contact in touches if contact.link_a in tip]
            force = _total([scale(contact.normal_on_b, -contact.force) for contact in own])
            middle = _total([scale(contact.position_on_b, 1.0 / len(own)) for contact in own])
            pushes.append(Push(force, middle))
        return pushes

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


def _total(vectors: Sequence[Vec3]) -> Vec3:
    total = ORIGIN
    for vector in vectors:
        total = add(total, vector)
    return total
