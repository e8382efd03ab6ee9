"""Conditions on joints of objects, and the measure of how far a joint has moved."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass

from taskbuilder.description.figures import beside
from taskbuilder.description.measures import Measure
from taskbuilder.description.node import Condition, JointName, Memory, Parts, Step
from taskbuilder.description.view import WorldView
from taskbuilder.schema.names import SceneNames


@dataclass(frozen=True)
class JointPosition(Condition):
    """The position of a prismatic joint is at least ``above`` and at most ``below``, in metres.

    One of the two bounds may be left out.
    """

    joint: JointName
    _: KW_ONLY
    above: float | None = None
    below: float | None = None

    def holds(self, world: WorldView) -> bool:
        return _between(world.joint(self.joint), self.above, self.below)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        bounds = (None if b is None else 100.0 * b for b in (self.above, self.below))
        return _beyond(100.0 * world.joint(self.joint), *bounds, unit="cm", wanted=wanted)

    @property
    def bounds(self) -> tuple[float | None, float | None]:
        """The smallest and the largest position at which it holds, in metres."""
        return self.above, self.below

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _bounds(self.above, self.below, "above", "below")
        if names.joint_type(self.joint) in ("revolute", "continuous"):
            yield f'"{self.joint}" turns; use JointAngle, in degrees'


@dataclass(frozen=True)
class JointAngle(Condition):
    """The angle of a revolute joint is at least ``above_deg`` and at most ``below_deg``.

    One of the two bounds may be left out.
    """

    joint: JointName
    _: KW_ONLY
    above_deg: float | None = None
    below_deg: float | None = None

    def holds(self, world: WorldView) -> bool:
        return _between(math.degrees(world.joint(self.joint)), self.above_deg, self.below_deg)

    def figure(self, world: WorldView, memory: Memory, *, wanted: bool) -> str:
        angle = math.degrees(world.joint(self.joint))
        return _beyond(angle, self.above_deg, self.below_deg, unit="°", wanted=wanted)

    @property
    def bounds(self) -> tuple[float | None, float | None]:
        """The smallest and the largest angle at which it holds, in rad."""
        low, high = self.above_deg, self.below_deg
        return low and math.radians(low), high and math.radians(high)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from _bounds(self.above_deg, self.below_deg, "above_deg", "below_deg")
        if names.joint_type(self.joint) == "prismatic":
            yield f'"{self.joint}" slides; use JointPosition, in metres'


@dataclass(frozen=True)
class JointTravel(Measure):
    """How far a joint has moved from its initial position to a target, as a fraction from 0 to 1.

    For a revolute joint, the target is an angle in degrees:
    ``JointTravel("chest.lid_hinge", to_deg=70)``. For a prismatic joint, the target is a position
    in metres: ``JointTravel("cabinet.runner", to=0.2)``.
    """

    joint: JointName
    _: KW_ONLY
    to: float | None = None
    to_deg: float | None = None

    def start(self, world: WorldView) -> Memory:
        """The initial position, in metres or rad."""
        return world.joint(self.joint)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        target = math.radians(self.to_deg) if self.to_deg is not None else self.to or 0.0
        if target == memory:
            return 1.0, memory
        done = (world.joint(self.joint) - memory) / (target - memory)
        return max(0.0, min(1.0, done)), memory

    def problems(self, names: SceneNames) -> Iterator[str]:
        kind = names.joint_type(self.joint)
        if (self.to is None) == (self.to_deg is None):
            yield "has no target; give to, in metres, or to_deg, in degrees"
        elif self.to is not None and kind in ("revolute", "continuous"):
            yield f'"{self.joint}" turns; give to_deg, in degrees'
        elif self.to_deg is not None and kind == "prismatic":
            yield f'"{self.joint}" slides; give to, in metres'


def _between(value: float, above: float | None, below: float | None) -> bool:
    return (above is None or value >= above) and (below is None or value <= below)


def _beyond(
    value: float, above: float | None, below: float | None, *, unit: str, wanted: bool
) -> str:
    """A joint's value and its bound, in words."""
    if wanted:
        low = above is not None and value < above
        bound = above if low else below
        now, shown = beside(value, bound or 0.0, unit)
        return f"{now}, at {'least' if low else 'most'} {shown} is needed"
    needed = []
    now = beside(value, above if above is not None else below or 0.0, unit)[0]
    if above is not None:
        needed.append(f"less than {beside(value, above, unit)[1]}")
    if below is not None:
        needed.append(f"more than {beside(value, below, unit)[1]}")
    return f"{now}, {' or '.join(needed)} is needed"


def _bounds(above: float | None, below: float | None, *names: str) -> Iterator[str]:
    if above is None and below is None:
        yield f"has no bound; give {' or '.join(names)}"
    elif above is not None and below is not None and above > below:
        yield f"can never hold: {names[0]} {above} is more than {names[1]} {below}"
