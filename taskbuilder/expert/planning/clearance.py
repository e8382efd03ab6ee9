"""Minimum distances between bodies during a motion."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from taskbuilder.expert.planning.collision_world import AttachedObject, CollisionWorld
from taskbuilder.expert.planning.errors import PlanningError
from taskbuilder.geometry import Pose, norm, subtract
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import ClosestPoint, gaps

CLEARANCE_M = 0.009
"""Minimum distance between bodies that need not touch, in metres."""

SLACK_M = 0.001
"""Tolerance on distances at the ends of a motion, in metres."""

DEEPEST_M = 0.003
"""Maximum penetration at the end of a motion, in metres: poses of held and resting objects are
not known more precisely."""

GRACE_M = 0.08
"""Within this distance (m) from an end of the motion, about a finger's length, pairs may be as
close as at that end. Farther on, they must separate by a tenth of the way."""

PARTING = 0.1

PairKey = tuple[int, str, str]
"""Number of the pair, and the link of each body; "" for an object, whose links count as one."""


@dataclass(frozen=True)
class Posture:
    """A configuration of the moving arms.

    Attributes:
        joints: Joint positions of each arm, rad or m.
        tools: Pose of each arm's tool, in the world.
    """

    joints: Mapping[str, tuple[float, ...]]
    tools: Mapping[str, Pose]


@dataclass(frozen=True)
class ClearanceViolation:
    """Two bodies that are closer to each other than allowed.

    Attributes:
        a: The moving body, such as ``left's wrist_2_link`` or ``the stick``.
        b: The other body.
        robot: The robot that moves it.
        distance: Distance in metres; negative for a penetration.
        advice: What to write in the task file if this is intended, or "".
    """

    a: str
    b: str
    robot: str
    distance: float
    advice: str = ""

    def __str__(self) -> str:
        size = abs(self.distance) * 1000.0
        if self.distance < 0.0:
            return f"{self.a} would be {size:.0f} mm inside {self.b}{self.advice}"
        needed = CLEARANCE_M * 1000.0
        least = f"less than the required {needed:.0f} mm{self.advice}"
        return f"{self.a} would be {int(size)} mm from {self.b}, {least}"


@dataclass(frozen=True)
class _Solid:
    """A body of the scene.

    Attributes:
        driver: The robot that moves it, or "" for what stays where it is.
        limbs: Whether each of its links counts for itself, as those of robots do.
    """

    name: str
    body: Body
    driver: str
    limbs: bool

    def called(self, link: str) -> str:
        if self.limbs:
            return f"{self.name}'s {link}"
        named = len(self.body.links) > 1 and link in self.body.links
        return f"the {link} of the {self.name}" if named else f"the {self.name}"


class Clearance:
    """Checks distances between moving bodies and everything else.

    Bodies normally keep `CLEARANCE_M` apart. A pair that is closer at the start or at the end of a
    motion may stay as close; if at one end only, while the tool is within `GRACE_M` of that end.

    Args:
        collision_world: The copy of the world.
        moving: The robots that move.
        riders: Objects that their tools carry.
        held: The object that each robot holds, moving or not.
        touching: The objects that each robot may touch.
    """

    def __init__(
        self,
        collision_world: CollisionWorld,
        moving: Collection[str],
        riders: Sequence[AttachedObject],
        held: Mapping[str, str],
        touching: Mapping[str, Collection[str]],
    ) -> None:
        self._collision_world = collision_world
        self._riders = [rider for rider in riders if rider.robot in moving]
        drivers = {name: name for name in moving}
        drivers |= {rider.name: rider.robot for rider in self._riders}
        self._pairs = list(_pairs(_solids(collision_world, drivers), held, touching))
        self._ends: tuple[Posture, Posture] | None = None
        self._allowed: tuple[dict[PairKey, float], dict[PairKey, float]] = ({}, {})

    def between(self, start: Posture, goal: Posture) -> None:
        """Measure the ends of a motion, to find the allowed distances on the way.

        Raises:
            PlanningError: Bodies would penetrate each other at the end.
        """
        self._ends = (start, goal)
        at_start, at_goal = self._nearest(start), self._nearest(goal)
        self._allowed = (_distances(at_start), _distances(at_goal))
        deepest = min(at_goal, key=lambda key: at_goal[key].distance, default=None)
        if deepest is not None:
            gap = at_goal[deepest]
            if gap.distance < min(-DEEPEST_M, self._allowed[0].get(deepest, 0.0) - SLACK_M):
                near = self._near(deepest[0], gap)
                raise PlanningError(near.robot, "in collision", f"at the end of the motion, {near}")

    def trouble(self, posture: Posture) -> ClearanceViolation | None:
        """Bodies that are too close to each other on the way."""
        self._place(posture)
        for number, (one, other) in enumerate(self._pairs):
            for gap in gaps(one.body, other.body, CLEARANCE_M):
                key = _key(number, one, other, gap)
                if gap.distance < CLEARANCE_M - 1e-9 and gap.distance < self._least(key, posture):
                    return self._near(number, gap)
        return None

    def _least(self, key: PairKey, posture: Posture) -> float:
        """The allowed distance of a pair in a posture."""
        at_start, at_goal = (ends.get(key) for ends in self._allowed)
        if at_start is not None and at_goal is not None:
            return min(at_start, at_goal) - SLACK_M
        if self._ends is None or (at_start is None and at_goal is None):
            return CLEARANCE_M
        at, end = (at_start, self._ends[0]) if at_goal is None else (at_goal, self._ends[1])
        away = max(
            norm(subtract(posture.tools[name].position, end.tools[name].position))
            for name in self._drivers(key)
        )
        return min(CLEARANCE_M, (at or 0.0) - SLACK_M + PARTING * max(0.0, away - GRACE_M))

    def _nearest(self, posture: Posture) -> dict[PairKey, ClosestPoint]:
        """Where each close pair is nearest in a posture.

        Pairs a little farther apart than `CLEARANCE_M` belong to them, so that these have the same
        `SLACK_M` as pairs a little nearer.
        """
        self._place(posture)
        closest: dict[PairKey, ClosestPoint] = {}
        for number, (one, other) in enumerate(self._pairs):
            for gap in gaps(one.body, other.body, CLEARANCE_M + SLACK_M):
                key = _key(number, one, other, gap)
                closest[key] = min(gap, closest.get(key, gap), key=lambda gap: gap.distance)
        return closest

    def _place(self, posture: Posture) -> None:
        for name, joints in posture.joints.items():
            self._collision_world.pose_arm(name, joints)
        for rider in self._riders:
            body = self._collision_world.world.objects[rider.name].body
            body.place(posture.tools[rider.robot] @ rider.pose)

    def _near(self, number: int, gap: ClosestPoint) -> ClearanceViolation:
        one, other = self._pairs[number]
        advice = self._advice(other, gap.distance, self._room(one, gap))
        names = one.called(gap.link_a), other.called(gap.link_b)
        return ClearanceViolation(*names, one.driver, gap.distance, advice)

    def _room(self, one: _Solid, gap: ClosestPoint) -> str:
        """What is between the fingers of a gripper one of which would be in something."""
        robot = self._collision_world.world.robots.get(one.name)
        if robot is None or not robot.model.stroke or gap.link_a not in robot.tip_links:
            return ""
        if robot.opening() < 0.5:
            return ""
        return f"; between its open fingers are {robot.model.stroke * 1000:.0f} mm"

    def _advice(self, other: _Solid, distance: float, room: str) -> str:
        obj = self._collision_world.world.objects.get(other.name)
        if obj is None or other.limbs or other.driver:
            return ""
        if distance >= 0.0:
            return f"; if the two may touch, write touching: [{other.name}]"
        return "" if obj.spec.fixed else f"{room}; to push it, write touching: [{other.name}]"

    def _drivers(self, key: PairKey) -> Iterator[str]:
        return (solid.driver for solid in self._pairs[key[0]] if solid.driver)


def _distances(nearest: Mapping[PairKey, ClosestPoint]) -> dict[PairKey, float]:
    return {key: gap.distance for key, gap in nearest.items()}


def _solids(collision_world: CollisionWorld, drivers: Mapping[str, str]) -> Iterator[_Solid]:
    world = collision_world.world
    for name, robot in world.robots.items():
        yield _Solid(name, robot.body, drivers.get(name, ""), True)
    for name, obj in world.objects.items():
        yield _Solid(name, obj.body, drivers.get(name, ""), False)
    if world.floor is not None:
        yield _Solid("floor", world.floor, "", False)


def _pairs(
    solids: Iterator[_Solid],
    held: Mapping[str, str],
    touching: Mapping[str, Collection[str]],
) -> Iterator[tuple[_Solid, _Solid]]:
    """The pairs to check, with the moving body first."""
    for pair in combinations(solids, 2):
        one, other = sorted(pair, key=lambda solid: not solid.driver)
        names = {one.name, other.name}
        grasp = any(names == {robot, name} for robot, name in held.items())
        together = one.driver == other.driver and not (one.limbs or other.limbs)
        wanted = other.name in touching.get(one.driver, ())
        if one.driver and not (grasp or together or wanted):
            yield one, other


def _key(number: int, one: _Solid, other: _Solid, gap: ClosestPoint) -> PairKey:
    return (number, gap.link_a if one.limbs else "", gap.link_b if other.limbs else "")
