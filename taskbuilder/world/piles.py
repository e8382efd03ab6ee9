"""Piles: groups whose members fall from a loose stack and come to rest.

That takes a hundred times as long as a reset, so a few piles of each world are settled, each when
it is first drawn, and put down as they are from then on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from taskbuilder.geometry import Pose, Vec3, norm, normalized
from taskbuilder.schema.groups import outline
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.scene import SceneSpec

PILES = 8
"""How many piles a world settles."""

SETTLING_S = 3.0
"""Seconds after which a pile is taken as it is."""

CALM_S = 0.5
"""For how long all members must be still: one that topples is still for a moment, too."""

STILL_M_S = 0.005
STILL_RAD_S = math.radians(5.0)


class PileWorld(Protocol):
    """What piles need of a `World`."""

    @property
    def task(self) -> TaskFile:
        """The task file."""

    def step(self) -> None:
        """Run one control step."""

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world."""

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        """Linear (m/s) and angular (rad/s) velocity of a named frame."""


class Piles:
    """Where the members of a scene's piles come to rest, in the frames of their arrangements."""

    def __init__(self, task: TaskFile, scene: SceneSpec) -> None:
        self._task, self._scene = task, scene
        self._groups = {
            group: members
            for group, members in task.names.groups.items()
            if (arrange := scene.objects[members[0]].arrange) and arrange.pile is not None
        }
        self._settled: dict[int, Mapping[str, Pose]] = {}

    def __bool__(self) -> bool:
        return bool(self._groups)

    def __contains__(self, group: str) -> bool:
        return group in self._groups

    def settled(self, number: int) -> Mapping[str, Pose] | None:
        """The poses of all members at rest, or None if that pile has not been settled yet."""
        return self._settled.get(number)

    def loose(self, rng: np.random.Generator) -> dict[str, Pose]:
        """Poses of all members in their cells, each turned at random and a little aside."""
        poses = {}
        for members in self._groups.values():
            spec = self._scene.objects[members[0]]
            room = outline(spec, self._task.assets.get(members[0]))
            slack = spec.arrange.slack(room) if spec.arrange and room else (0.0, 0.0)
            for member in members:
                x, y, z = self._scene.objects[member].pose.position
                aside = rng.uniform(-1.0, 1.0, 2).tolist()
                turn = normalized(tuple(rng.normal(size=4).tolist()))
                at = (x + aside[0] * slack[0], y + aside[1] * slack[1], z)
                poses[member] = Pose(at, turn)
        return poses

    def settle(self, number: int, world: PileWorld) -> None:
        """Let the members, which have been put in their cells, fall and come to rest."""
        control_hz = self._task.spec.timing.control_hz
        members = [one for ones in self._groups.values() for one in ones]
        calm = 0
        for _ in range(math.ceil(SETTLING_S * control_hz)):
            world.step()
            calm = calm + 1 if all(_still(world, one) for one in members) else 0
            if calm >= CALM_S * control_hz:
                break
        self._settled[number] = {
            one: world.pose(group).inverse() @ world.pose(one)
            for group, ones in self._groups.items()
            for one in ones
        }


def _still(world: PileWorld, name: str) -> bool:
    linear, angular = world.velocity(name)
    return norm(linear) < STILL_M_S and norm(angular) < STILL_RAD_S
