"""Conditions on contact: held, released, touching, resting on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass

from taskbuilder.description.bodies import one_body, without_hands
from taskbuilder.description.figures import beside, listed
from taskbuilder.description.node import BodyName, Condition, Memory, RobotName, SolidName
from taskbuilder.description.view import WorldView
from taskbuilder.schema.names import SceneNames

_CARRIES = 1e-3  # newtons: anything that rests has more, numerical noise has less


@dataclass(frozen=True)
class Held(Condition):
    """A robot holds a body: fingers press on it from opposite sides, or a suction cup holds it.

    The fingers press on it from outside, or from inside while they are commanded to open. Three
    fingers also hold a body if their forces balance. A body that is attached to a gripper is held,
    too. ``by`` names one robot, or several robots that must all hold the body. If ``by`` is None,
    it is enough that any robot holds the body.
    """

    body: BodyName
    _: KW_ONLY
    by: RobotName | tuple[RobotName, ...] | None = None

    def holds(self, world: WorldView) -> bool:
        if self.by is None:
            return any(world.held(self.body, robot) for robot in world.robot_names)
        robots = (self.by,) if isinstance(self.by, str) else self.by
        return all(world.held(self.body, robot) for robot in robots)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        robots = (self.by,) if isinstance(self.by, str) else self.by or world.robot_names
        told = [robot for robot in robots if world.held(self.body, robot) != wanted]
        if wanted and self.by is None:
            return "no robot holds it"
        said = "does not hold it" if wanted else "holds it"
        return ", ".join(f"{robot} {said}" for robot in told)

    def problems(self, names: SceneNames) -> Iterator[str]:
        if self.by == ():
            yield "by is empty; name a robot, or leave by out for any"
        yield from without_hands(
            names, *((self.by,) if isinstance(self.by, str) else self.by or ())
        )


@dataclass(frozen=True)
class Released(Condition):
    """No finger or tool of any robot touches a body; with ``by``, only the robot ``by`` counts."""

    body: BodyName
    _: KW_ONLY
    by: RobotName | None = None

    def holds(self, world: WorldView) -> bool:
        robots = world.robot_names if self.by is None else (self.by,)
        return not any(world.fingers_touch(self.body, robot) for robot in robots)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        robots = world.robot_names if self.by is None else (self.by,)
        touching = [robot for robot in robots if world.fingers_touch(self.body, robot)]
        return f"touched by {listed(touching)}" if touching else "no finger or tool touches it"


@dataclass(frozen=True)
class EmptyHanded(Condition):
    """A robot holds no object."""

    robot: RobotName

    def holds(self, world: WorldView) -> bool:
        return not any(world.held(name, self.robot) for name in world.object_names)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        held = [name for name in world.object_names if world.held(name, self.robot)]
        return f"it holds {listed(held)}" if held else "it holds nothing"

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from without_hands(names, self.robot)


@dataclass(frozen=True)
class Contact(Condition):
    """Two bodies touch, or a robot touches a body."""

    first: BodyName
    second: BodyName | None = None
    _: KW_ONLY
    robot: RobotName | None = None

    def holds(self, world: WorldView) -> bool:
        return world.touching(self.first, self.second or self.robot or "")

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        return "they do not touch" if wanted else "they touch"

    def problems(self, names: SceneNames) -> Iterator[str]:
        if (self.second is None) == (self.robot is None):
            yield 'touches what? write Contact("a", "b") or Contact("a", robot="left")'


@dataclass(frozen=True)
class On(Condition):
    """``below`` carries at least part of the weight of ``body``."""

    body: BodyName
    below: BodyName

    def holds(self, world: WorldView) -> bool:
        return world.support(self.body, self.below) > _CARRIES

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        if wanted:
            return f"{self.below} carries none of it"
        return f"{self.below} carries {world.support(self.body, self.below):.2g} N of it"


@dataclass(frozen=True)
class ForceAbove(Condition):
    """The contact force between two bodies or robots is above ``newtons``; see `ContactForce`."""

    first: SolidName
    second: SolidName
    _: KW_ONLY
    newtons: float

    def holds(self, world: WorldView) -> bool:
        return world.contact_force(self.first, self.second) > self.newtons

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        force = world.contact_force(self.first, self.second)
        now, bound = beside(force, self.newtons, "N", digits=0)
        return f"{now}, " + (f"more than {bound} is needed" if wanted else f"{bound} is allowed")

    def force_pairs(self) -> Iterator[tuple[str, str]]:
        yield self.first, self.second

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from one_body(self.first, self.second)
        if not self.newtons >= 0:
            yield f"newtons is {self.newtons}; 0 or more"
