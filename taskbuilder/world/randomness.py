"""Randomness of an episode: one seed, and a generator of its own for each purpose."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.task import Distribution
from taskbuilder.schema.values import rgb
from taskbuilder.schema.variants import DRIVES
from taskbuilder.sim.body import Body
from taskbuilder.world.robot import Robot
from taskbuilder.world.scene_objects import SceneObject, Site


@dataclass(frozen=True)
class EpisodeRandomness:
    """The generators of an episode. Using more or less of one does not move the others."""

    seed: int

    def placement(self) -> np.random.Generator:
        """For where things are put."""
        return self._generator(0)

    def variation(self) -> np.random.Generator:
        """For which variation it is, where that is drawn."""
        return self._generator(1)

    def noise(self) -> np.random.Generator:
        """For noise on observations."""
        return self._generator(2)

    def quantities(self) -> np.random.Generator:
        """For the values of the quantities that the task file lists under ``randomize``."""
        return self._generator(3)

    def start(self) -> np.random.Generator:
        """For whether and where an episode goes on from a recorded one."""
        return self._generator(4)

    def piles(self) -> np.random.Generator:
        """For how piles come to lie."""
        return self._generator(5)

    def instruction(self) -> np.random.Generator:
        """For which of the task's instructions an episode has."""
        return self._generator(6)

    def looks(self) -> np.random.Generator:
        """For light, colours and textures of furniture, and cameras, where looks vary."""
        return self._generator(7)

    def distractors(self) -> np.random.Generator:
        """For things that are only drawn, where looks vary."""
        return self._generator(8)

    def disturbance(self, axis: int) -> np.random.Generator:
        """For what a disturbance changes, by the number of its axis."""
        return self._generator(9, axis)

    def rewording(self) -> np.random.Generator:
        """For the words of an instruction that is put into other words."""
        return self._generator(10)

    def _generator(self, *purpose: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=purpose))


Members = Mapping[str, tuple[str, ...]]
"""The members of each group; all of them have the value that is drawn for the group."""


def written(scene: SceneSpec, randomize: Iterable[str], groups: Members) -> dict[str, Any]:
    """The quantities that the task can randomise, as its file writes them.

    Args:
        scene: The scene that was built.
        randomize: Names of the quantities, such as ``stick.mass``.
        groups: The members of each group.
    """
    things = {**scene.objects, **scene.sites}
    values = {}
    for key in randomize:
        thing, _, quantity = key.rpartition(".")
        if thing in scene.robots:
            values[key] = DRIVES[quantity]
            continue
        values[key] = getattr(things[groups.get(thing, (thing,))[0]], quantity)
    return values


def drawn(randomize: Mapping[str, Distribution], rng: np.random.Generator) -> dict[str, Any]:
    """A value for each quantity that the task can randomise, by name."""
    return {key: draw(distribution, rng) for key, distribution in randomize.items()}


def draw(distribution: Distribution, rng: np.random.Generator) -> Any:
    """A value from a distribution."""
    if distribution.uniform is not None:
        return float(rng.uniform(*distribution.uniform))
    choices = distribution.choice or ()
    return choices[int(rng.integers(len(choices)))]


def delay_of(robot: str, values: Mapping[str, Any]) -> int:
    """After how many control steps a robot carries out its actions, 0 for at once.

    Args:
        robot: Its name.
        values: The quantities of the episode.
    """
    return int(values.get(f"{robot}.delay", 0))


def longest_delay(robot: str, randomize: Mapping[str, Distribution]) -> int:
    """The longest delay of a robot that the task can draw, in control steps."""
    listed = randomize.get(f"{robot}.delay")
    return int(max(listed.choice or (0,))) if listed else 0


def apply(
    robots: Mapping[str, Robot],
    objects: Mapping[str, SceneObject],
    sites: Mapping[str, Site],
    values: Mapping[str, Any],
    groups: Members,
) -> None:
    """Give quantities of objects, sites and robots, such as ``stick.mass``, their values.

    Delays are not the world's business: whoever commands the robots sees to them.
    """
    for key, value in values.items():
        thing, _, quantity = key.rpartition(".")
        if thing in robots:
            if quantity == "gains":
                robots[thing].arm.scale_gain(value)
            continue
        for one in groups.get(thing, (thing,)):
            marker = sites[one].marker if one in sites else None
            _set(marker or objects[one].body, quantity, value)


def _set(body: Body, quantity: str, value: Any) -> None:
    if quantity == "color":
        body.set_color((*rgb(value), 1.0))
    else:
        setters: Mapping[str, Callable[[float], None]] = {
            "mass": body.set_mass,
            "friction": body.set_friction,
            "rolling_friction": body.set_rolling_friction,
            "restitution": body.set_restitution,
        }
        setters[quantity](value)
