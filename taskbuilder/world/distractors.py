"""Things that lie about in pictures and that nothing touches.

They stand on the floor and on furniture, beside what the episode is about: clear of the robots'
bases and grippers, and of every line along which one thing may be brought to another.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Box, Pose, from_rpy, subtract
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.rays import first_hit
from taskbuilder.sim.scenery import Distractor
from taskbuilder.sim.shapes import BoxShape, CylinderShape, SphereShape
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site

Array = NDArray[np.float64]

MOST = 5
"""Distractors in an episode; at least one, if there is room."""

TRIES = 20
"""Places that are tried for each."""

HALF_M = (0.015, 0.035)
"""Half the edge of a distractor, or its radius."""

AROUND_M = 0.35
"""How far beyond robots and things they may lie."""

CLEAR_M = 0.06
"""What they keep from things and from the lines between things; twice as much from robots."""

FAR = 0.25
"""How often one may lie anywhere, and not on furniture."""

ABOVE_M = 3.0


class Surroundings(Protocol):
    """What distractors need of a `World`."""

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


def scattered(world: Surroundings, rng: np.random.Generator) -> tuple[Distractor, ...]:
    """Distractors for an episode whose things are placed.

    Args:
        world: The scene.
        rng: Random numbers.
    """
    busy = _Busy(world)
    furniture = [name for name, thing in world.objects.items() if _is_support(thing)]
    supports = {world.objects[name].body.id for name in furniture}
    if world.floor is not None:
        supports.add(world.floor.id)
    low, high = busy.area
    tops = [_footprint(world, name) for name in furniture]
    tops = [(np.maximum(a, low), np.minimum(b, high)) for a, b in tops]
    tops = [(a, b) for a, b in tops if (a < b).all()] or [busy.area]
    made: list[Distractor] = []
    for _ in range(int(rng.integers(1, MOST + 1))):
        area = busy.area if rng.random() < FAR else tops[int(rng.integers(len(tops)))]
        made += _one(world.client, supports, busy, area, rng)
    return tuple(made)


class _Busy:
    """Where the episode happens, seen from above."""

    def __init__(self, world: Surroundings) -> None:
        things = [name for name, thing in world.objects.items() if not _is_support(thing)]
        ends = [(world.pose(name).position, _radius(world, name)) for name in things]
        ends += [(world.pose(name).position, 0.0) for name in world.sites]
        feet = [robot.body.pose().position for robot in world.robots.values()]
        feet += [world.pose(f"{name}.tcp").position for name in world.robots]
        self._lines = [
            (np.array(a[:2]), np.array(b[:2]), max(r, s) + CLEAR_M)
            for (a, r), (b, s) in combinations_with_replacement(ends, 2)
        ]
        self._lines += [(np.array(at[:2]), np.array(at[:2]), 2.0 * CLEAR_M) for at in feet]
        places = np.array([at[:2] for at in [*(at for at, _ in ends), *feet]])
        self.area = (places.min(axis=0) - AROUND_M, places.max(axis=0) + AROUND_M)

    def has(self, place: Array, half: float) -> bool:
        """Whether something of this size would be in the way."""
        return any(_distance(place, a, b) < kept + half for a, b, kept in self._lines)

    def take(self, place: Array, half: float) -> None:
        """Keep a place free from now on."""
        self._lines.append((place, place, half + 0.01))


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
    for _ in range(TRIES):
        place = rng.uniform(*area)
        if busy.has(place, half):
            continue
        height = _support_height(client, supports, place, half)
        if height is None:
            continue
        busy.take(place, half)
        shape = _shape(kind, half, high)
        up = half if isinstance(shape, SphereShape) else high
        position = (float(place[0]), float(place[1]), height + up)
        pose = Pose(position, from_rpy(0.0, 0.0, yaw))
        yield Distractor(shape, pose, colorsys.hsv_to_rgb(hue, saturation, value))
        return


def _shape(kind: int, half: float, high: float) -> BoxShape | CylinderShape | SphereShape:
    if kind == 0:
        return BoxShape((2.0 * half, 1.4 * half, 2.0 * high))
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


def _is_support(thing: SceneObject) -> bool:
    """Whether something may stand on it: it does not move, in whole or in part."""
    return bool(thing.spec.fixed) and not thing.joints


def _footprint(world: Surroundings, name: str) -> tuple[Array, Array]:
    """Least and greatest x and y of an object in the world."""
    box = world.box(name).seen_from(world.pose(name))
    return np.array(box.low[:2]), np.array(box.high[:2])


def _radius(world: Surroundings, name: str) -> float:
    box = world.box(name)
    return math.hypot(*subtract(box.high, box.low)[:2]) / 2.0


def _distance(place: Array, a: Array, b: Array) -> float:
    """From a point to the line between two points, all (2,)."""
    along = b - a
    length = float(along @ along)
    share = min(1.0, max(0.0, float((place - a) @ along) / length)) if length else 0.0
    return float(np.linalg.norm(place - a - share * along))
