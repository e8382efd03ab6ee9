"""Regions in which things are placed at random, moved and resized by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose, Vec3
from taskbuilder.schema.placing import Place, Placed
from taskbuilder.schema.rewrite import Value
from taskbuilder.schema.source import Path_
from taskbuilder.view.placing import Movable, ValueChange, changes_of, written_path
from taskbuilder.world.world import World

ABOVE_M = 0.003
"""A region on a surface is drawn so far above it, in metres."""

LEAST_M = 1e-6
"""What moves by less is not written."""


class RegionPlacing:
    """Moves the region of one thing, and says what its file would have to say.

    A region has the axes of its frame. Its corner is the one with the largest coordinates; when
    that is moved, the region grows or shrinks on all sides, and its middle stays.

    Args:
        world: The world; it is not changed.
        variation: Number of the variation of its scene.
        thing: Whose region, of the sort ``region``.

    Attributes:
        values: What the file has to say, by where it says it; empty if nothing has moved.
    """

    def __init__(self, world: World, variation: int, thing: Movable) -> None:
        self.thing = thing
        self._world, self._variation = world, variation
        scene = world.scene
        self._group = "objects" if thing.name in scene.objects else "sites"
        things: Mapping[str, Placed] = scene.objects if self._group == "objects" else scene.sites
        place = things[thing.name].place
        if place is None:
            raise ValueError(f"{thing.name} has no region")
        self._place: Place = place
        self._frame = Pose() if place.frame == "world" else world.pose(place.frame)
        self._top = 0.0
        if place.surface is not None:
            box = world.box(place.surface).seen_from(world.pose(place.surface))
            self._top = box.high[2] + ABOVE_M
        self.center, self.size = tuple(place.center), tuple(place.size)
        self.values: Mapping[Path_, Value] = {}

    def move(self, pose: Pose) -> None:
        """Move the middle of the region.

        Args:
            pose: Where to, in the world.
        """
        self.center = self._inside(pose)
        self._note()

    def move_corner(self, pose: Pose) -> None:
        """Move its corner, which changes the size.

        Args:
            pose: Where to, in the world.
        """
        pairs = zip(self._inside(pose), self.center, strict=True)
        self.size = tuple(2.0 * abs(corner - middle) for corner, middle in pairs)
        self._note()

    def put_back(self) -> None:
        """Put it back where it was, in the size that it had."""
        self.center, self.size = tuple(self._place.center), tuple(self._place.size)
        self._note()

    @property
    def is_flat(self) -> bool:
        """Whether it has no height, as on a surface."""
        return len(self.size) == 2

    @property
    def pose(self) -> Pose:
        """The middle of the region, in the world; its axes are those of its frame."""
        return self._at((0.0, 0.0, 0.0))

    @property
    def corner(self) -> Pose:
        """The corner with the largest coordinates, in the world."""
        return self._at((0.5, 0.5, 0.5))

    @property
    def reaches_beyond(self) -> str:
        """The surface over whose edge the region reaches, or ""."""
        surface = self._place.surface
        if surface is None:
            return ""
        box, back = self._world.box(surface), self._world.pose(surface).inverse()
        for x, y in product((-0.5, 0.5), repeat=2):
            at = back.apply(self._at((x, y, 0.0)).position)
            if any(not box.low[n] <= at[n] <= box.high[n] for n in range(2)):
                return surface
        return ""

    def edges(self) -> NDArray[np.float32]:
        """(n, 2, 3) the edges of the region in the world, in metres."""
        heights = (0.0,) if self.is_flat else (-0.5, 0.5)
        corners = list(product((-0.5, 0.5), (-0.5, 0.5), heights))
        pairs = [
            (one, other)
            for one, other in product(corners, corners)
            if one < other and sum(a != b for a, b in zip(one, other, strict=True)) == 1
        ]
        ends = [[self._at(one).position, self._at(other).position] for one, other in pairs]
        return np.array(ends, np.float32).reshape(-1, 2, 3)

    def changes(self) -> tuple[ValueChange, ...]:
        """What in the file is to be written otherwise."""
        return changes_of(self._world, self.values)

    def _at(self, share: Vec3) -> Pose:
        """A point of the region, by its distance from the middle as a share of the size."""
        pairs = zip(self.center, self.size, share, strict=False)
        x, y, z, *_ = (*(middle + side * part for middle, side, part in pairs), 0.0)
        pose = self._frame @ Pose((x, y, z))
        if self._place.surface is None:
            return pose
        return Pose((pose.position[0], pose.position[1], self._top), pose.quaternion)

    def _inside(self, pose: Pose) -> tuple[float, ...]:
        """The coordinates of a point in the frame of the region, as many as the region has."""
        return self._frame.inverse().apply(pose.position)[: len(self._place.center)]

    def _note(self) -> None:
        at: Path_ = ("scene", self._group, self.thing.name, "place")
        pairs = {
            "center": (self.center, self._place.center),
            "size": (self.size, self._place.size),
        }
        self.values = {
            written_path(self._world, self._variation, (*at, key)): now
            for key, (now, before) in pairs.items()
            if math.dist(now, before) > LEAST_M
        }
