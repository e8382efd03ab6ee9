"""Disturbances: what an episode can have otherwise than the task file says, axis by axis.

A disturbance is an axis and a level, such as ``mass=0.5``. `AXES` says all that is to be known of
an axis; help, messages and pages are made from it. Nothing is loaded here, so that whoever only
names an axis is quick.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from taskbuilder.errors import UsageError
from taskbuilder.wording import suggestion

Disturbances = tuple[tuple[str, float], ...]
"""Pairs of an axis and its level, in the order of `AXES`."""

Reads = Literal["pictures", "colours", "positions", "words"]
"""What a policy must observe to notice a disturbance."""


@dataclass(frozen=True)
class DisturbanceAxis:
    """A disturbance, at any level.

    Attributes:
        help: What differs in an episode; N stands for the level.
        level: The level by default.
        bounds: The least and the greatest level.
        unit: Of the level.
        whole: Whether levels are whole numbers.
        reads: What a policy must observe to notice it; None for what happens to the scene itself.
    """

    help: str
    level: float
    bounds: tuple[float, float]
    unit: str = ""
    whole: bool = False
    reads: Reads | None = None

    @property
    def measure(self) -> str:
        """The unit behind a level, if there is one."""
        return f" {self.unit}" if self.unit else ""

    @property
    def has_levels(self) -> bool:
        """Whether there is more than one level."""
        return self.bounds[0] < self.bounds[1]


_ON = (1.0, 1.0)

AXES: Mapping[
    str, DisturbanceAxis
] = {  # new axes go last, because random generators follow this order
    "layout": DisturbanceAxis(
        "regions in which objects and sites are placed, and ranges of their yaw, are larger by the "
        "share N about the same centre",
        level=0.5,
        bounds=(0.0, 4.0),
    ),
    "start": DisturbanceAxis(
        "every arm starts with its joints up to N degrees from home (sliding joints: up to what N "
        "degrees are on a radius of 0.5 m), farther than 1 cm from anything",
        level=5.0,
        bounds=(0.0, 45.0),
        unit="degrees",
    ),
    "mass": DisturbanceAxis(
        "the mass of every movable object is multiplied by 1/(1+N) to 1+N",
        level=0.5,
        bounds=(0.0, 9.0),
    ),
    "friction": DisturbanceAxis(
        "the friction coefficient of every movable object is multiplied by 1/(1+N) to 1+N",
        level=0.5,
        bounds=(0.0, 9.0),
    ),
    "gains": DisturbanceAxis(
        "the position gain of every arm's motors is multiplied by 1/(1+N) to 1+N",
        level=0.5,
        bounds=(0.0, 1.0),
    ),
    "delay": DisturbanceAxis(
        "every robot carries out its actions 1 to N control steps late",
        level=1.0,
        bounds=(1.0, 50.0),
        whole=True,
    ),
    "light": DisturbanceAxis(
        "direction, colour and brightness of the lamp, as with the look `light`",
        level=1.0,
        bounds=_ON,
        reads="colours",
    ),
    "background": DisturbanceAxis(
        "colours of backdrop, floor and furniture, and their textures, as with the looks "
        "`background`, `furniture` and `textures`",
        level=1.0,
        bounds=_ON,
        reads="colours",
    ),
    "camera": DisturbanceAxis(
        "position, aim and opening angle of every camera, changed by N times what the look "
        "`cameras` changes",
        level=1.0,
        bounds=(0.0, 3.0),
        reads="pictures",
    ),
    "image_noise": DisturbanceAxis(
        "Gaussian noise on every value of every observed colour image, with the standard deviation "
        "N of the full range",
        level=0.05,
        bounds=(0.0, 1.0),
        reads="colours",
    ),
    "state_noise": DisturbanceAxis(
        "Gaussian noise on each coordinate of every observed position, with the standard deviation "
        "N, as with the option `position_noise`",
        level=0.01,
        bounds=(0.0, 1.0),
        unit="metres",
        reads="positions",
    ),
    "instruction": DisturbanceAxis(
        "the instruction is put into other words, with the same meaning",
        level=1.0,
        bounds=_ON,
        reads="words",
    ),
    "distractors": DisturbanceAxis(
        "1 to N objects that are only drawn, never where goals are, as with the look `distractors`",
        level=5.0,
        bounds=(1.0, 30.0),
        whole=True,
        reads="pictures",
    ),
}

ALL = "all"
"""Stands for all axes at their levels by default."""

DisturbancesGiven = str | Iterable[str | tuple[str, float]] | Mapping[str, float | None]
"""Forms in which disturbances are given: see `each_disturbance`."""


def each_disturbance(given: DisturbancesGiven) -> tuple[tuple[str, float], ...]:
    """The axes and levels that are asked for, in order and checked.

    Args:
        given: ``"all"``; a text such as ``"mass"`` or ``"mass=0.5"``, or several; pairs of an axis
            and a level; or a mapping from axes to levels, where None is the level by default.

    Raises:
        UsageError: There is no such axis, or it has no such level.
    """
    if isinstance(given, str):
        given = (given,)
    try:
        pairs = list(given.items()) if isinstance(given, Mapping) else [_pair(e) for e in given]
    except (TypeError, ValueError):
        raise UsageError(
            f'a disturbance is an axis and a level, such as "mass=0.5" or {{"mass": 0.5}}, '
            f"not {given!r}"
        ) from None
    listed: dict[tuple[str, float], None] = {}
    for name, level in pairs:
        for axis in AXES if name == ALL and level is None else (name,):
            listed[axis, level_of(axis, level)] = None
    return tuple(listed)


def disturbances(given: DisturbancesGiven) -> Disturbances:
    """The canonical form of disturbances that an environment has all at once.

    Raises:
        UsageError: There is no such axis or level, or an axis has two levels.
    """
    pairs = each_disturbance(given)
    levels = dict(pairs)
    for name, level in pairs:
        if levels[name] != level:
            raise UsageError(f"{name} has the levels {level:g} and {levels[name]:g}; give it one")
    return tuple((name, levels[name]) for name in AXES if name in levels)


def level_of(name: Any, level: Any = None) -> float:
    """The level of an axis, checked; that by default for None.

    Raises:
        UsageError: There is no such axis, or it has no such level.
    """
    axis = AXES.get(name) if isinstance(name, str) else None
    if axis is None:
        help_ = suggestion(str(name), (*AXES, ALL), what="one of")
        raise UsageError(f'no disturbance "{name}"; {help_}')
    if level is None:
        return axis.level
    number = isinstance(level, int | float) and not isinstance(level, bool)
    low, high = axis.bounds
    if number and low <= level <= high and (not axis.whole or level == int(level)):
        return float(level)
    if not axis.has_levels:
        raise UsageError(f"the disturbance {name} has no levels; leave the level out")
    kind = "a whole number from " if axis.whole else ""
    raise UsageError(
        f"the disturbance {name} has the level {level!r}; {kind}{low:g} to {high:g}{axis.measure}"
    )


def disturbance_text(name: str, level: float) -> str:
    """A disturbance as a command line names it, such as ``mass=0.5``."""
    return f"{name}={level:g}" if AXES[name].has_levels else name


def axes_text() -> str:
    """All axes with their levels by default and what they change, for help."""
    return "; ".join(
        f"{name} (N = {axis.level:g}{axis.measure}): {axis.help}"
        if axis.has_levels
        else f"{name}: {axis.help}"
        for name, axis in AXES.items()
    )


def _pair(given: Any) -> tuple[Any, Any]:
    """An axis and its level, which is None if it is not given."""
    if not isinstance(given, str):
        name, level = given
        return name, level
    name, equals, text = given.partition("=")
    if not equals:
        return name, None
    if name == ALL:
        raise UsageError(f'"{given}": {ALL} takes no level; name an axis')
    try:
        return name, float(text)
    except ValueError:
        level_of(name)  # the axis first
        raise UsageError(f'"{given}": "{text}" is no number') from None
