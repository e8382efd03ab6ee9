"""What motions and grips do to things, worked out without physics.

What is held follows the tool; if it is a link of an articulated object, it follows the tool along
its joint. What stands in the way of a motion that may touch it is pushed ahead, and what lies on
something that moves goes along. Boxes stand for shapes, so that a push is only roughly foreseen: a
thing of which that is so is a guess.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from taskbuilder.assets.model import Urdf
from taskbuilder.expert.planning.moves import Move
from taskbuilder.expert.script.fingers import tip_boxes
from taskbuilder.expert.script.joints import Joint, joints_above
from taskbuilder.expert.script.situation import Foreseen, Go, Grip, Situation
from taskbuilder.geometry import (
    Box,
    Pose,
    Vec3,
    cross,
    dot,
    from_axes,
    norm,
    scale,
    subtract,
    unit,
)
from taskbuilder.world.world import World

RESTING_M = 0.003
"""What is no higher than this above the top of a thing may lie on it."""


@dataclass
class Foresight:
    """Where things would be by now.

    Attributes:
        world: As it is at the beginning; it is only read.
        start: The situation then, in which nobody holds anything.
        moved: Pose in the world of objects, and of links as ``chest.lid``, that are elsewhere.
        tools: Pose in the world of tools that are elsewhere.
        loads: What robots hold that moves freely.
        handles: Links of articulated objects that robots hold, as ``chest.lid``.
        joints: Positions of joints that are elsewhere, in rad or m.
        guesses: Objects, and robots, whose pose is foreseen only roughly.
    """

    world: World
    start: Situation
    moved: dict[str, Pose] = field(default_factory=dict)
    tools: dict[str, Pose] = field(default_factory=dict)
    loads: dict[str, str | None] = field(default_factory=dict)
    handles: dict[str, str] = field(default_factory=dict)
    joints: dict[str, float] = field(default_factory=dict)
    guesses: set[str] = field(default_factory=set)
    _closed: set[str] = field(default_factory=set)
    _fingers: dict[tuple[str, bool], tuple[Box, ...]] = field(default_factory=dict)

    @property
    def now(self) -> Foreseen:
        """The situation as it would be."""
        return Foreseen(self.start, self.moved, self.tools, self.loads, self.handles, self.joints)

    def owner(self, frame: str) -> str:
        """The object or robot that a frame moves with."""
        sites = self.world.scene.sites
        while frame in sites:
            frame = sites[frame].frame
        return frame.partition(".")[0]

    # --- grips

    def grip(self, grip: Grip) -> None:
        """A gripper opens or closes."""
        robot = grip.robot
        self.handles.pop(robot, None)
        if grip.opening:
            self._closed.discard(robot)
        else:
            self._closed.add(robot)
        if grip.releases:
            dropped = self.loads.get(robot)
            self.loads[robot] = None
            if dropped and dropped not in self.loads.values():
                self.guesses.add(dropped)  # it may fall
            return
        self.loads[robot] = None
        if not grip.load:
            return
        link = grip.link or self._nearest_link(robot, grip.load)
        if link and joints_above(self.world, grip.load, link):
            self.handles[robot] = f"{grip.load}.{link}"
        if grip.load in self.world.movable:
            self.loads[robot] = grip.load

    def _nearest_link(self, robot: str, name: str) -> str:
        """The link of an articulated object that is nearest to a tool; "" for other objects."""
        if not isinstance(self.world.task.assets.get(name), Urdf):
            return ""
        at = self.now.tool(robot).position
        boxes = self.world.objects[name].boxes

        def distance(link: str) -> float:
            x, y, z = self.now.pose(f"{name}.{link}").inverse().apply(at)
            low, high = boxes[link].low, boxes[link].high
            return math.dist(
                (x, y, z),
                (
                    min(max(x, low[0]), high[0]),
                    min(max(y, low[1]), high[1]),
                    min(max(z, low[2]), high[2]),
                ),
            )

        return min(boxes, key=distance)

    # --- motions

    def go(self, go: Go, *, guess: bool) -> None:
        """A motion, as far as it can be foreseen.

        Args:
            go: What moves.
            guess: Whether where it goes is one.
        """
        move = go.choices[0]
        robots = tuple(move.carriers)
        before = {robot: self.now.tool(robot) for robot in robots}
        after = {robot: move.goal @ offset for robot, offset in move.carriers.items()}
        handled = {r: self.handles[r] for r in robots if r in self.handles and not go.brings}
        swung = {handle.partition(".")[0] for handle in handled.values()}
        loads = {load for robot in robots if (load := self.now.load(robot))} - swung
        if go.pushes is not None:
            name, place = go.pushes
            self._carry([name], place @ self.now.pose(name).inverse())
            self.guesses.add(name)
        elif go.joint is not None:
            self._move_joint(*go.joint)
            handled = {}
        else:
            self._push(move, before, after, loads | swung)
        first = robots[0]
        shift = after[first] @ before[first].inverse()
        names = sorted(loads | ({go.brings} if go.brings else set()))
        self._carry(names, shift)
        for name in names if guess else ():
            self.guesses.add(name)
        for robot, handle in handled.items():
            self._turn(handle, before[robot].position, after[robot].position)
        self.tools |= after
        self.guesses = self.guesses.union(robots) if guess else self.guesses.difference(robots)

    def _carry(self, names: Iterable[str], shift: Pose) -> None:
        """Objects move as rigid bodies, with what lies on them."""
        moving = list(dict.fromkeys(names))
        for name in moving:
            moving += [rider for rider in self._riders(name) if rider not in moving]
        links = [frame for frame in self.moved if frame.partition(".")[0] in moving]
        now = self.now
        self.moved |= {frame: shift @ now.pose(frame) for frame in {*moving, *links}}

    def _riders(self, name: str) -> Iterator[str]:
        """The objects that lie on, or in, an object or link, and that nobody holds."""
        under, box = self.now.pose(name), self.world.box(name)
        for other in self.world.movable:
            if other == name.partition(".")[0] or other in self.loads.values():
                continue
            bounds = self.world.box(other).seen_from(under.inverse() @ self.now.pose(other))
            beside = any(abs(bounds.center[i] - box.center[i]) > box.half[i] for i in (0, 1))
            if not beside and box.low[2] <= bounds.low[2] <= box.high[2] + RESTING_M:
                yield other

    # --- joints

    def _turn(self, handle: str, begin: Vec3, end: Vec3) -> None:
        """A held link follows a tool along its joint, as far as that goes."""
        name, _, link = handle.partition(".")
        above, *others = joints_above(self.world, name, link)
        if others:
            self.guesses.add(name)
            return
        joint = Joint(self.world, f"{name}.{above.name}")
        at = self.now.pose(joint.child)
        if joint.slides:
            by = dot(subtract(end, begin), joint.axis(at))
        else:
            by = _angle(subtract(begin, at.position), subtract(end, at.position), joint.axis(at))
        low, high = joint.limits
        self._move_joint(joint.name, min(max(self.now.joint(joint.name) + by, low), high))

    def _move_joint(self, name: str, position: float) -> None:
        """A joint moves, with the links below it and what lies in those that slide."""
        joint, now = Joint(self.world, name), self.now
        shift = joint.shift(now.pose(joint.child), position - now.joint(name))
        below = {frame: shift @ now.pose(frame) for frame in joint.below}
        if joint.slides:
            self._carry(self._riders(joint.child), shift)
        self.moved |= below
        self.joints[name] = position

    # --- pushes

    def _push(
        self, move: Move, before: dict[str, Pose], after: dict[str, Pose], carried: set[str]
    ) -> None:
        """What a motion may touch goes ahead of it, if it stands in the way."""
        for name in dict.fromkeys(touched.partition(".")[0] for touched in move.touching):
            spec = self.world.scene.objects[name]
            if name in carried or (spec.fixed and not self.world.objects[name].joints):
                continue
            for robot, start in before.items():
                motion = subtract(after[robot].position, start.position)
                ahead = self._displacement(name, robot, start, motion)
                if ahead is not None and not spec.fixed:
                    self._carry([name], Pose(ahead))
            self.guesses.add(name)

    def _displacement(self, name: str, robot: str, start: Pose, motion: Vec3) -> Vec3 | None:
        """How a thing is displaced by a tool, level; None if it does not stand in the way."""
        far = norm(motion)
        if far < 1e-6:
            return None
        along = _frame_along(unit(motion)).inverse()
        obstacle = self.world.box(name).seen_from(along @ self.now.pose(name))
        pushes = [0.0]
        for box, pose in self._pushers(robot, start):
            hand = box.seen_from(along @ pose)
            beside = any(
                abs(hand.center[i] - obstacle.center[i]) >= hand.half[i] + obstacle.half[i]
                for i in (1, 2)
            )
            if not beside and hand.low[0] < obstacle.high[0]:
                pushes.append(far - max(obstacle.low[0] - hand.high[0], 0.0))
        ahead = scale(unit(motion), max(pushes))
        return (ahead[0], ahead[1], 0.0) if max(pushes) > 0.0 else None

    def _pushers(self, robot: str, tool: Pose) -> Iterator[tuple[Box, Pose]]:
        """What a robot pushes with, each a box and its pose: its fingers or tool, and its load."""
        key = robot, robot in self._closed
        if key not in self._fingers:
            self._fingers[key] = tuple(tip_boxes(self.world.robots[robot], closed=key[1]))
        for box in self._fingers[key]:
            yield box, tool
        if load := self.now.load(robot):
            yield self.world.box(load), self.now.pose(load)


def _frame_along(direction: Vec3) -> Pose:
    """A frame whose x axis is a direction, and whose z axis is as upright as that allows."""
    up: Vec3 = (0.0, 0.0, 1.0) if abs(direction[2]) < 0.9 else (0.0, 1.0, 0.0)
    side = unit(cross(up, direction))
    return Pose((0.0, 0.0, 0.0), from_axes(direction, side, cross(direction, side)))


def _angle(begin: Vec3, end: Vec3, axis: Vec3) -> float:
    """The angle about an axis from one direction to another, in radians, -pi to pi."""
    flat_begin = subtract(begin, scale(axis, dot(begin, axis)))
    flat_end = subtract(end, scale(axis, dot(end, axis)))
    return math.atan2(dot(cross(flat_begin, flat_end), axis), dot(flat_begin, flat_end))
