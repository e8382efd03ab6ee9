"""What disturbances change in a world: drawn anew in each episode, from generators of their own.

So an episode with a disturbance is otherwise that without it, as far as physics allows: the same
seed gives the same layout, and each axis draws the same whatever other axes there are.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Set
from dataclasses import asdict, dataclass, replace
from typing import Any, Protocol

import numpy as np

from taskbuilder.geometry import Pose, scale
from taskbuilder.schema.disturbances import AXES
from taskbuilder.schema.task import LookPart
from taskbuilder.schema.values import frozen
from taskbuilder.schema.variants import DRIVES
from taskbuilder.sim.body import Body
from taskbuilder.sim.contacts import links_near
from taskbuilder.world.distractors import MOST
from taskbuilder.world.looks import CameraChange, Look
from taskbuilder.world.placement import PlacementPlan
from taskbuilder.world.randomness import EpisodeRandomness
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject

LOOKS: Mapping[str, tuple[LookPart, ...]] = {
    "light": ("light",),
    "background": ("background", "furniture", "textures"),
    "camera": ("cameras",),
    "distractors": ("distractors",),
}
"""Parts of the look that axes draw."""

LEVER_M = 0.5
"""A sliding joint is displaced by as much as a turning one moves a point at this distance."""

CLEAR_M = 0.01
"""An arm that starts elsewhere than at home comes no nearer to anything than this."""

TRIES = 20
"""Starts that are tried for an arm before it starts at home."""


class DisturbedWorld(Protocol):
    """What disturbances need of a `World`."""

    @property
    def robots(self) -> Mapping[str, Robot]:
        """The agents."""

    @property
    def objects(self) -> Mapping[str, SceneObject]:
        """The bodies that are not robots."""

    @property
    def floor(self) -> Body | None:
        """The floor, if there is one."""

    @property
    def plan(self) -> PlacementPlan:
        """What is placed."""

    @property
    def quantities(self) -> Mapping[str, Any]:
        """Values of what is randomised or disturbed."""

    @property
    def look(self) -> Look:
        """How the episode looks."""

    def pose(self, frame: str) -> Pose:
        """The pose of a named frame in the world."""


@dataclass(frozen=True)
class Disturber:
    """Draws what disturbances change in a world.

    Attributes:
        levels: Level of each axis.
    """

    levels: Mapping[str, float]

    def written(self, world: DisturbedWorld) -> dict[str, Any]:
        """The quantities that can be disturbed, as they are without a disturbance."""
        movable = {name: each for name, each in world.objects.items() if not each.spec.fixed}
        values: dict[str, Any] = {}
        if "mass" in self.levels:
            values |= {f"{name}.mass": each.body.mass for name, each in movable.items()}
        if "friction" in self.levels:
            values |= {f"{name}.friction": each.spec.friction for name, each in movable.items()}
        drives = (quantity for quantity in DRIVES if quantity in self.levels)
        return values | {
            f"{n}.{quantity}": DRIVES[quantity] for quantity in drives for n in world.robots
        }

    def quantities(self, plain: Mapping[str, Any], randomness: EpisodeRandomness) -> dict[str, Any]:
        """The quantities of an episode.

        Args:
            plain: Their values without a disturbance.
            randomness: The generators of the episode.
        """
        values = dict(plain)
        for axis in ("mass", "friction", "gains", "delay"):
            if axis not in self.levels:
                continue
            level, rng = self.levels[axis], _generator(axis, randomness)
            for key in plain:
                if not key.endswith(f".{axis}"):
                    continue
                if axis == "delay":
                    values[key] = int(rng.integers(1, int(level) + 1))
                else:
                    values[key] *= float(rng.uniform(1.0 / (1.0 + level), 1.0 + level))
        return values

    def start_arms(
        self, world: DisturbedWorld, randomness: EpisodeRandomness
    ) -> dict[str, list[float]]:
        """Put the arms, which are at home, where they start.

        Returns:
            The displacement of each joint from home by robot, in rad or m.
        """
        if "start" not in self.levels:
            return {}
        most, rng = math.radians(self.levels["start"]), _generator("start", randomness)
        return {name: _start(world, robot, most, rng) for name, robot in world.robots.items()}

    @property
    def look_parts(self) -> Set[LookPart]:
        """The parts of the look that are drawn."""
        return {part for axis in self.levels for part in LOOKS.get(axis, ())}

    @property
    def most_distractors(self) -> int:
        """The largest number of distractors."""
        return int(self.levels.get("distractors", MOST))

    def scaled(self, look: Look) -> Look:
        """A look with what differs in its cameras at the level of their axis."""
        level = self.levels.get("camera", 1.0)
        return replace(
            look, cameras=frozen({name: _scaled(c, level) for name, c in look.cameras.items()})
        )

    def drawn(self, world: DisturbedWorld, starts: Mapping[str, list[float]]) -> dict[str, Any]:
        """What an episode drew, by axis, as JSON can hold it.

        Args:
            world: The world, just reset.
            starts: What `start_arms` returned.
        """
        drawn: dict[str, Any] = {}
        for axis in self.levels:
            if axis == "layout":
                leaders = (party[0] for party in world.plan.parties)
                drawn[axis] = {name: _numbers(world.pose(name)) for name in leaders}
            elif axis == "start":
                drawn[axis] = starts
            elif axis in LOOKS:
                drawn[axis] = _looked(axis, world.look)
            elif axis in ("mass", "friction", "gains", "delay"):
                drawn[axis] = {
                    key.rpartition(".")[0]: value
                    for key, value in world.quantities.items()
                    if key.endswith(f".{axis}")
                }
        plain: dict[str, Any] = json.loads(json.dumps(drawn))
        return plain


def _generator(axis: str, randomness: EpisodeRandomness) -> np.random.Generator:
    return randomness.disturbance(tuple(AXES).index(axis))


def _start(
    world: DisturbedWorld, robot: Robot, most: float, rng: np.random.Generator
) -> list[float]:
    """Put an arm near home where it touches nothing that it does not touch at home."""
    spans = np.where(robot.chain.revolute, most, most * LEVER_M)
    home, at_home = np.array(robot.home), _near(world, robot)
    for _ in range(TRIES):
        start = np.clip(home + rng.uniform(-spans, spans), robot.chain.lower, robot.chain.upper)
        _put(robot, start.tolist())
        if _near(world, robot) <= at_home:
            shift: list[float] = (start - home).tolist()
            return shift
    _put(robot, robot.home)
    return [0.0] * len(home)


def _put(robot: Robot, joints: Any) -> None:
    robot.body.reset_joints(robot.arm.indices, joints)
    robot.move_arm(joints)


def _near(world: DisturbedWorld, robot: Robot) -> Set[tuple[int, int]]:
    """Links of a robot and bodies that are near each other, among those that have their places."""
    others = [world.objects[name].body for name in world.plan.still]
    others += [other.body for other in world.robots.values() if other is not robot]
    others += [world.floor] if world.floor else []
    return {(link, other.id) for other in others for link in links_near(robot.body, other, CLEAR_M)}


def _scaled(change: CameraChange, level: float) -> CameraChange:
    zoom = change.zoom**level
    return CameraChange(scale(change.eye, level), scale(change.aim, level), zoom)


def _numbers(pose: Pose) -> list[float]:
    return [*pose.position, *pose.quaternion]


def _looked(axis: str, look: Look) -> Any:
    """The part of a look that an axis draws."""
    if axis == "light":
        return asdict(look.light)
    if axis == "camera":
        return {name: asdict(change) for name, change in look.cameras.items()}
    if axis == "distractors":
        return [asdict(each) for each in look.distractors]
    return {
        "backdrop": asdict(look.studio),
        "floor": look.floor,
        "floor_texture": asdict(look.floor_texture) if look.floor_texture else None,
        "paints": dict(look.paints),
        "textures": {name: asdict(texture) for name, texture in look.textures.items()},
    }
