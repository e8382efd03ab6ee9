"""Things that lie about in pictures and that nothing touches.

They stand on the floor and on furniture, beside what the episode is about: clear of the robots'
bases and grippers, of everything that the task names, and of every line along which one thing may
be brought to another. None of them can thus be taken for a sign that the task is done. The surface
that robots stand on is furniture even if the task names it.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import ORIGIN, Box, Pose, Vec3, from_rpy, subtract
from taskbuilder.schema.load import TaskFile
from taskbuilder.shapes import BoxShape, CylinderShape, SphereShape
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.rays import first_hit
from taskbuilder.sim.scenery import Distractor
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site

Array = NDArray[np.float64]

MOST = 5
"""Distractors in an episode unless another number is given; fewer, or none, if there is no room."""

TRIES = 20
"""Places that are tried for each."""

HALF_M = (0.015, 0.035)
"""Half the edge of a distractor, or its radius."""

BOX_SHAPE = 0.7
"""The shorter edge of a box, seen from above, as a share of the longer."""

AROUND_M = 0.35
"""How far beyond robots and things they may lie."""

CLEAR_M = 0.06
"""What they keep from things and from the lines between things; twice as much from robots."""

BASE_M = 0.05
"""A robot stands on an object if its base is no further than this from the top of it, in height
and to the side."""

FAR = 0.25
"""How often one may lie anywhere, and not on furniture."""

ABOVE_M = 3.0
UPRIGHT = 0.9999
"""Least cosine of the tilt of what stands upright."""


class Surroundings(Protocol):
    """What distractors need of a `World`."""

    @property
    def task(self) -> TaskFile:
        """The task file, which knows what the task names."""

    @property
    def client(self) -> Client:
        """The physics."""

    @property
    def robots(self) -> Mapping[str, Robot]:
        """The agents."""

    @property
    def objects(self) -> Mapping[str, SceneObject]:
        """The bodies that are not robots."""

    @property
    def sites(self) -> Mapping[str, Site]:
        """The named frames without a body."""

    @property
    def floor(self) -> Body | None:
        """The floor, if there is one."""

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world."""

    def box(self, body: str) -> Box:
        """Bounding box of an object, a part or a site's marker, in its own frame."""


def scattered(
    world: Surroundings, rng: np.random.Generator, most: int = MOST
) -> tuple[Distractor, ...]:
    """Distractors for an episode whose things are placed.

    Args:
        world: The scene.
        rng: Random numbers.
        most: The largest number of distractors.
    """
    furniture = _furniture(world)
    busy = _Busy(world, furniture)
    supports = {world.objects[name].body.id for name in furniture}
    if world.floor is not None:
        supports.add(world.floor.id)
    low, high = busy.area
    tops = [_extent(world, name) for name in furniture]
    tops = [(np.maximum(a, low), np.minimum(b, high)) for a, b in tops]
    tops = [(a, b) for a, b in tops if (a < b).all()] or [busy.area]
    made: list[Distractor] = []
    for _ in range(int(rng.integers(1, most + 1))):
        area = busy.area if rng.random() < FAR else tops[int(rng.integers(len(tops)))]
        made += _one(world.client, supports, busy, area, rng)
    return tuple(made)


class _Busy:
    """Where the episode happens, seen from above.

    Args:
        world: The scene.
        furniture: The objects that distractors may stand on.
    """

    def __init__(self, world: Surroundings, furniture: list[str]) -> None:
        handled = [name for name, thing in world.objects.items() if not _is_still(thing)]
        goals = [name for name in world.objects if name not in (*handled, *furniture)]
        goals += world.sites
        ends = [(world.pose(name).position, _radius(world, name)) for name in handled]
        ends += [(world.pose(name).position, 0.0) for name in goals]
        feet = [robot.body.pose().position for robot in world.robots.values()]
        feet += [world.pose(f"{name}.tcp").position for name in world.robots]
        self._lines = [
            (np.array(a[:2]), np.array(b[:2]), max(r, s) + CLEAR_M)
            for (a, r), (b, s) in combinations_with_replacement(ends, 2)
        ]
        self._lines += [(np.array(at[:2]), np.array(at[:2]), 2.0 * CLEAR_M) for at in feet]
        self._outlines = [
            (_Outline.of(world, name), world.task.named.get(name, 0.0) + CLEAR_M)
            for name in (*handled, *goals)
        ]
        places = np.array([at[:2] for at in [*(at for at, _ in ends), *feet]])
        self.area = (places.min(axis=0) - AROUND_M, places.max(axis=0) + AROUND_M)

    def has(self, place: Array, reach: float) -> bool:
        """Whether something that reaches so far to all sides would be in the way."""
        return any(_distance(place, a, b) < kept + reach for a, b, kept in self._lines) or any(
            outline.distance(place) < kept + reach for outline, kept in self._outlines
        )

    def take(self, place: Array, reach: float) -> None:
        """Keep a place free from now on."""
        self._lines.append((place, place, reach + 0.01))


def _one(
    client: Client,
    supports: set[int],
    busy: _Busy,
    area: tuple[Array, Array],
    rng: np.random.Generator,
) -> Iterator[Distractor]:
    """A distractor at a free place, if one is found."""
    kind = int(rng.integers(3))
    half, high = rng.uniform(*HALF_M, 2).tolist()
    yaw, hue, saturation, value = rng.uniform((0, 0, 0.3, 0.3), (math.pi, 1, 0.9, 0.95)).tolist()
    shape = _shape(kind, half, high)
    reach = half * math.hypot(1.0, BOX_SHAPE) if isinstance(shape, BoxShape) else half
    for _ in range(TRIES):
        place = rng.uniform(*area)
        if busy.has(place, reach):
            continue
        height = _support_height(client, supports, place, half)
        if height is None:
            continue
        busy.take(place, reach)
        up = half if isinstance(shape, SphereShape) else high
        position = (float(place[0]), float(place[1]), height + up)
        pose = Pose(position, from_rpy(0.0, 0.0, yaw))
        yield Distractor(shape, pose, colorsys.hsv_to_rgb(hue, saturation, value))
        return


def _shape(kind: int, half: float, high: float) -> BoxShape | CylinderShape | SphereShape:
    if kind == 0:
        return BoxShape((2.0 * half, 2.0 * BOX_SHAPE * half, 2.0 * high))
    return CylinderShape(half, 2.0 * high) if kind == 1 else SphereShape(half)


def _support_height(client: Client, supports: set[int], place: Array, half: float) -> float | None:
    """The height of the flat surface below a place and all around it, or None."""
    heights = []
    for across, along in ((0, 0), (half, half), (half, -half), (-half, half), (-half, -half)):
        x, y = float(place[0] + across), float(place[1] + along)
        hit = first_hit(client, (x, y, ABOVE_M), (x, y, -1.0))
        if hit is None or hit.body not in supports or hit.normal[2] < 0.99:
            return None
        heights.append(hit.point[2])
    return heights[0] if max(heights) - min(heights) < 1e-3 else None


def _furniture(world: Surroundings) -> list[str]:
    """The objects that distractors may stand on.

    They do not move, in whole or in part, and the task does not name them, unless robots stand on
    them: a table is named because everything is on it.
    """
    feet = [robot.body.pose().position for robot in world.robots.values()]
    return [
        name
        for name, thing in world.objects.items()
        if _is_still(thing)
        and (name not in world.task.named or any(_carries(world, name, foot) for foot in feet))
    ]


def _is_still(thing: SceneObject) -> bool:
    return bool(thing.spec.fixed) and not thing.joints


def _carries(world: Surroundings, name: str, foot: Vec3) -> bool:
    """Whether a robot whose base is there stands on an object."""
    top = world.box(name).seen_from(world.pose(name)).high[2]
    above = _Outline.of(world, name).distance(np.array(foot[:2])) <= BASE_M
    return above and abs(foot[2] - top) <= BASE_M


def _extent(world: Surroundings, name: str) -> tuple[Array, Array]:
    """Least and greatest x and y of an object in the world."""
    box = world.box(name).seen_from(world.pose(name))
    return np.array(box.low[:2]), np.array(box.high[:2])


class _Outline(NamedTuple):
    """A thing seen from above: the rectangle of a box in a frame that stands upright."""

    frame: Pose
    box: Box

    @classmethod
    def of(cls, world: Surroundings, name: str) -> _Outline:
        """The outline of an object or of a site's marker; a site without one is a point."""
        pose, site = world.pose(name), world.sites.get(name)
        if site is not None and site.box is None:
            return cls(pose, Box(ORIGIN, ORIGIN))
        if abs(pose.axis(2)[2]) > UPRIGHT:
            return cls(pose, world.box(name))
        return cls(Pose(), world.box(name).seen_from(pose))

    def distance(self, place: Array) -> float:
        """How far outside of it a place is, m."""
        x, y = place.tolist()
        seen = subtract(self.frame.inverse().apply((x, y, self.frame.position[2])), self.box.center)
        return math.hypot(*(max(0.0, abs(seen[i]) - self.box.half[i]) for i in (0, 1)))


def _radius(world: Surroundings, name: str) -> float:
    box = world.box(name)
    return math.hypot(*subtract(box.high, box.low)[:2]) / 2.0


def _distance(place: Array, a: Array, b: Array) -> float:
    """From a point to the line between two points, all (2,)."""
    along = b - a
    length = float(along @ along)
    share = min(1.0, max(0.0, float((place - a) @ along) / length)) if length else 0.0
    return float(np.linalg.norm(place - a - share * along))
