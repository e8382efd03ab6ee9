"""Measures: numbers read from the world, for progress, potentials and reward terms.

They add and multiply with each other and with plain numbers: ``0.5 * (3 + Height("cube"))``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from typing import Any, SupportsFloat

from taskbuilder.description.axes import SignedAxis, axis_problems, tilt_deg
from taskbuilder.description.bodies import one_body, without_hands
from taskbuilder.description.custom import Call
from taskbuilder.description.node import (
    Argument,
    Condition,
    FrameName,
    Memory,
    Node,
    Parts,
    RobotName,
    SolidName,
    Step,
    ValueOfNodeError,
)
from taskbuilder.description.view import WorldView
from taskbuilder.geometry import total
from taskbuilder.schema.names import SceneNames


class Measure(Node):
    """An expression that is a number at each control step.

    Define your own measures with the decorator `measure`, or as subclasses that are frozen
    dataclasses with a method ``value``.
    """

    def value(self, world: WorldView) -> float:
        """The number now."""
        raise NotImplementedError

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        value = self.value(world)
        return (value if type(value) is float and value == value else self.number_of(value)), memory

    def number_of(self, value: Any) -> float:
        """A value as a float.

        Raises:
            ValueOfNodeError: It is no number.
        """
        if isinstance(value, SupportsFloat):
            with suppress(TypeError, ValueError):  # as of an array of several
                number = float(value)
                if not math.isnan(number):
                    return number
        raise ValueOfNodeError(self, value, "a measure gives a number")

    def __add__(self, other: Measure | float) -> Measure:
        return Sum((self, as_measure(other)))

    def __radd__(self, other: float) -> Measure:
        return Sum((as_measure(other), self))

    def __sub__(self, other: Measure | float) -> Measure:
        return Sum((self, Product((Constant(-1.0), as_measure(other)))))

    def __rsub__(self, other: float) -> Measure:
        return Sum((as_measure(other), Product((Constant(-1.0), self))))

    def __mul__(self, other: Measure | float) -> Measure:
        return Product((self, as_measure(other)))

    def __rmul__(self, other: float) -> Measure:
        return Product((as_measure(other), self))


def as_measure(value: Measure | float) -> Measure:
    """A measure as it is, a number as a measure that never changes."""
    return value if isinstance(value, Measure) else Constant(float(value))


@dataclass(frozen=True)
class Constant(Measure):
    """A number."""

    number: float

    def value(self, world: WorldView) -> float:
        return self.number


@dataclass(frozen=True)
class Sum(Measure):
    """The sum of measures; written ``a + b``."""

    of: tuple[Measure, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The summands."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return total(parts), memory


@dataclass(frozen=True)
class Product(Measure):
    """The product of measures; written ``a * b``."""

    of: tuple[Measure, ...]

    @property
    def parts(self) -> tuple[Node, ...]:
        """The factors."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return math.prod(parts), memory


@dataclass(frozen=True)
class Gap(Measure):
    """The distance between two frames, in metres."""

    first: FrameName
    second: FrameName

    def value(self, world: WorldView) -> float:
        return math.dist(world.position(self.first), world.position(self.second))


@dataclass(frozen=True)
class Closeness(Measure):
    """1 - tanh(d / scale) for the distance d between two frames: 1 at d = 0, near 0 for large d."""

    first: FrameName
    second: FrameName
    _: KW_ONLY
    scale: float = 0.2

    def value(self, world: WorldView) -> float:
        gap = math.dist(world.position(self.first), world.position(self.second))
        return 1.0 - math.tanh(gap / self.scale)

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.scale > 0:
            yield f"scale is {self.scale}; metres, more than 0"


@dataclass(frozen=True)
class Height(Measure):
    """The height of a frame above the world's origin, or above another frame, in metres."""

    frame: FrameName
    reference: FrameName | None = None

    def value(self, world: WorldView) -> float:
        base = world.position(self.reference)[2] if self.reference else 0.0
        return world.position(self.frame)[2] - base


@dataclass(frozen=True)
class Tilt(Measure):
    """The angle between an axis of a frame and the vertical, in degrees; 0 is upright."""

    frame: FrameName
    _: KW_ONLY
    axis: SignedAxis = "z"

    def value(self, world: WorldView) -> float:
        return tilt_deg(world.pose(self.frame), self.axis)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from axis_problems(self.axis)


@dataclass(frozen=True)
class Speed(Measure):
    """How fast a frame moves, in m/s."""

    frame: FrameName

    def value(self, world: WorldView) -> float:
        linear, _ = world.velocity(self.frame)
        return math.hypot(*linear)


@dataclass(frozen=True)
class GripperOpening(Measure):
    """How far a robot's gripper is open, from 0 (closed) to 1 (fully open)."""

    robot: RobotName

    def value(self, world: WorldView) -> float:
        return world.opening(self.robot)

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from without_hands(names, self.robot)


@dataclass(frozen=True)
class ContactForce(Measure):
    """The contact force between two bodies or robots, in newtons; 0 if they do not touch.

    ``first`` and ``second`` each name a robot, an object, or a part or a link of an object. The sum
    of the normal forces between the two is averaged over 1/60 s. The value is the peak of this
    average over the physics steps of the control step.
    """

    first: SolidName
    second: SolidName

    def value(self, world: WorldView) -> float:
        return world.contact_force(self.first, self.second)

    def force_pairs(self) -> Iterator[tuple[str, str]]:
        yield self.first, self.second

    def problems(self, names: SceneNames) -> Iterator[str]:
        yield from one_body(self.first, self.second)


@dataclass(frozen=True)
class Duration(Measure):
    """How long a condition has held without a break, in seconds; 0 while it does not hold."""

    of: Condition

    @property
    def parts(self) -> tuple[Node, ...]:
        """The one condition."""
        return (self.of,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        """The memory is the time since which the condition holds."""
        if not parts[0]:
            return 0.0, None
        since = world.time if memory is None else memory
        return world.time - since, since


@dataclass(frozen=True)
class Fraction(Measure):
    """A measure divided by ``of``, clipped to the range from 0 to 1."""

    measure: Measure
    _: KW_ONLY
    of: float

    @property
    def parts(self) -> tuple[Node, ...]:
        """The measure."""
        return (self.measure,)

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return min(max(parts[0] / self.of, 0.0), 1.0), memory

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.of > 0:
            yield f"of is {self.of}; more than 0"


@dataclass(frozen=True, init=False)
class Minimum(Measure):
    """The smallest of several measures: ``Minimum(Height("tray.left"), Height("tray.right"))``."""

    gathers = True

    of: tuple[Measure, ...]

    def __init__(self, *of: Measure | float) -> None:
        object.__setattr__(self, "of", tuple(as_measure(value) for value in of))

    @property
    def parts(self) -> tuple[Node, ...]:
        """The measures, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return min(parts), memory

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.of:
            yield "it is the least of nothing; give it measures"


@dataclass(frozen=True, init=False)
class Mean(Measure):
    """The mean of the given measures; for a measure of a group, the mean over the members."""

    gathers = True

    of: tuple[Measure, ...]

    def __init__(self, *of: Measure | float) -> None:
        object.__setattr__(self, "of", tuple(as_measure(value) for value in of))

    @property
    def parts(self) -> tuple[Node, ...]:
        """The measures, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return math.fsum(parts) / len(parts), memory

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.of:
            yield "it is the mean of nothing; give it measures"


@dataclass(frozen=True, init=False)
class Count(Measure):
    """The number of given conditions that hold; each member of a group is counted separately."""

    gathers = True

    of: tuple[Condition, ...]

    def __init__(self, *of: Condition) -> None:
        object.__setattr__(self, "of", of)

    @property
    def parts(self) -> tuple[Node, ...]:
        """The conditions, in order."""
        return self.of

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        return float(total(parts)), memory

    def problems(self, names: SceneNames) -> Iterator[str]:
        if not self.of:
            yield "it counts nothing; give it conditions"


@dataclass(frozen=True, init=False)
class Ladder(Measure):
    """The value of the last rung whose condition holds, or ``ground`` if no condition holds.

    A rung is a pair of a condition and its value, which is a measure or a number::

        progress = Ladder(
            Closeness("left.tcp", "cube"),  # the ground: before anything holds
            (Held("cube", by="left"), 1 + Closeness("cube", "tray")),
            (Inside("cube", "tray"), 3),
        )
    """

    ground: Measure
    rungs: tuple[tuple[Condition, Measure], ...]

    def __init__(self, ground: Measure | float, *rungs: tuple[Condition, Measure | float]) -> None:
        object.__setattr__(self, "ground", as_measure(ground))
        climbed = tuple((condition, as_measure(value)) for condition, value in rungs)
        object.__setattr__(self, "rungs", climbed)

    @property
    def parts(self) -> tuple[Node, ...]:
        """The ground, then condition and measure of each rung."""
        return (self.ground, *(node for rung in self.rungs for node in rung))

    def update(self, world: WorldView, parts: Parts, memory: Memory) -> Step:
        standing = parts[0]
        for condition, value in zip(parts[1::2], parts[2::2], strict=True):
            standing = value if condition else standing
        return standing, memory


@dataclass(frozen=True)
class CustomMeasure(Measure):
    """A measure that `measure` made from a function."""

    call: Call[float]

    def value(self, world: WorldView) -> float:
        return self.call(world)

    def arguments(self) -> Iterator[Argument]:
        return self.call.annotated()

    def __repr__(self) -> str:
        return repr(self.call)


def measure(function: Callable[..., float]) -> Callable[..., Measure]:
    """Turn a function of the world that returns a number into a measure; see `condition`."""

    def make(*args: Any, **kwargs: Any) -> Measure:
        return CustomMeasure(Call.bind(function, args, kwargs))

    make.__name__, make.__doc__ = function.__name__, function.__doc__
    return make
