"""A world that is whatever a test says it is, and counts how often it is asked."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import ClassVar

from taskbuilder.description import (
    Bonus,
    Condition,
    Description,
    Measure,
    Never,
    Term,
    WorldView,
)
from taskbuilder.geometry import Box, Pose, Vec3


@dataclass
class FakeWorld:
    """Values by name, all of which a test may set; frames are at the origin unless told."""

    time: float = 0.0
    robot_names: tuple[str, ...] = ("left", "right")
    object_names: tuple[str, ...] = ("cube", "tray")
    poses: dict[str, Pose] = field(default_factory=dict)
    velocities: dict[str, tuple[Vec3, Vec3]] = field(default_factory=dict)
    boxes: dict[str, Box] = field(default_factory=dict)
    sites: set[str] = field(default_factory=set)
    holds: set[tuple[str, str]] = field(default_factory=set)
    touches: set[tuple[str, str]] = field(default_factory=set)
    finger_touches: set[tuple[str, str]] = field(default_factory=set)
    supports: dict[tuple[str, str], float] = field(default_factory=dict)
    forces: dict[tuple[str, str], float] = field(default_factory=dict)
    joints: dict[str, float] = field(default_factory=dict)
    openings: dict[str, float] = field(default_factory=dict)
    facts: set[str] = field(default_factory=set)
    numbers: dict[str, float] = field(default_factory=dict)
    asked: Counter[str] = field(default_factory=Counter)

    def put(self, frame: str, *position: float) -> None:
        self.poses[frame] = Pose((position[0], position[1], position[2]))

    def pose(self, frame: str) -> Pose:
        return self.poses.get(frame, Pose())

    def position(self, frame: str) -> Vec3:
        return self.pose(frame).position

    def velocity(self, frame: str) -> tuple[Vec3, Vec3]:
        return self.velocities.get(frame, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))

    def box(self, body: str) -> Box:
        return self.boxes[body]

    def is_solid(self, name: str) -> bool:
        return name not in self.sites

    def held(self, body: str, robot: str) -> bool:
        return (body, robot) in self.holds

    def touching(self, first: str, second: str) -> bool:
        return (first, second) in self.touches

    def support(self, body: str, below: str) -> float:
        return self.supports.get((body, below), 0.0)

    def contact_force(self, first: str, second: str) -> float:
        return self.forces.get((first, second), 0.0)

    def fingers_touch(self, body: str, robot: str) -> bool:
        return (body, robot) in self.finger_touches

    def opening(self, robot: str) -> float:
        return self.openings[robot]

    def joint(self, name: str) -> float:
        return self.joints[name]


@dataclass(frozen=True)
class Fact(Condition):
    """True while the fake world lists it."""

    name: str

    def holds(self, world: WorldView) -> bool:
        assert isinstance(world, FakeWorld)
        world.asked[self.name] += 1
        return self.name in world.facts


@dataclass(frozen=True)
class Number(Measure):
    """The number that the fake world has of this name."""

    name: str
    unit: ClassVar[str] = "m"

    def value(self, world: WorldView) -> float:
        assert isinstance(world, FakeWorld)
        world.asked[self.name] += 1
        return world.numbers[self.name]


A, B, C = Fact("a"), Fact("b"), Fact("c")


def describe(
    success: Condition | None = None, *reward: Term, **attributes: object
) -> type[Description]:
    """A description class of some parts."""
    content = {
        "success": Never() if success is None else success,
        "reward": reward or (Bonus("nothing", Never(), 1.0),),
        **attributes,
    }
    return type("Described", (Description,), content)
