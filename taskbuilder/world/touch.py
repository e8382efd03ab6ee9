"""What touches what in a world, and who holds it, read once a control step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from taskbuilder.errors import UnknownNameError
from taskbuilder.geometry import ORIGIN, Vec3, add, dot, norm, scale, subtract
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.contacts import ContactPoint, contacts
from taskbuilder.wording import suggestion
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject

GRASP_FORCE_N = 0.5
"""What each finger must press with to hold something: well above the noise of a touch."""

_OPPOSING = -0.7  # cosine of the angle between the forces of two fingers; -1 is straight against


@dataclass(frozen=True, slots=True)
class _Push:
    """Force of a finger on a body (N), and where it acts, in the world."""

    force: Vec3
    at: Vec3


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
        """Whether fingers of a robot press on an object or part from opposite sides."""
        known = self._held.get((body, robot))
        if known is None:
            strong = [p for p in self._pushes(body, robot) if norm(p.force) > GRASP_FORCE_N]
            known = any(_opposed(*pair) for pair in combinations(strong, 2))
            self._held[body, robot] = known
        return known

    def grip_forces(self, body: str, robot: str) -> tuple[float, ...]:
        """Force in newtons with which each finger of a robot presses on an object or part."""
        return tuple(norm(push.force) for push in self._pushes(body, robot))

    def fingers_touch(self, body: str, robot: str) -> bool:
        """Whether any finger of a robot touches an object or part."""
        touches = self.between(robot, body)
        fingers = {link for finger in self._robots[robot].fingers for link in finger}
        return any(contact.link_a in fingers for contact in touches)

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

    def _pushes(self, body: str, robot: str) -> list[_Push]:
        """What each finger of a robot does to an object or part; none if none touches."""
        touches = self.between(robot, body)
        pushes = []
        for finger in self._robots[robot].fingers if touches else ():
            own = [contact for contact in touches if contact.link_a in finger]
            force = _total([scale(contact.normal_on_b, -contact.force) for contact in own])
            middle = _total([scale(contact.position_on_b, 1.0 / len(own)) for contact in own])
            pushes.append(_Push(force, middle))
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


def _opposed(one: _Push, other: _Push) -> bool:
    """Whether two fingers press against, and towards, each other: with their inner sides."""
    across = subtract(other.at, one.at)
    against = dot(one.force, other.force) < _OPPOSING * norm(one.force) * norm(other.force)
    return against and dot(one.force, across) > 0.0


def _total(vectors: Sequence[Vec3]) -> Vec3:
    total = ORIGIN
    for vector in vectors:
        total = add(total, vector)
    return total
