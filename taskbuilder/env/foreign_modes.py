"""Arm modes of other packages: what they return is checked, and their errors name the package."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from taskbuilder.env.arm_modes import Arm, ArmMode, Targets
from taskbuilder.extensions import ForeignPart


@dataclass(frozen=True)
class ForeignMode(ArmMode):
    """An arm mode of another package.

    Attributes:
        part: Where it comes from.
        mode: The mode itself.
    """

    part: ForeignPart
    mode: ArmMode

    @classmethod
    def of(cls, part: ForeignPart, mode: type[ArmMode], arm: Arm) -> Self:
        """Make the mode for an arm.

        Raises:
            ExtensionError: It cannot be made, or its names and bounds do not fit each other.
        """
        with part.at_work():
            made = cls(arm, part, mode(arm))
            object.__setattr__(made, "space", mode.space)
            names, bounds = tuple(made.mode.names), tuple(made.mode.bounds)
        if len(names) != len(bounds):
            raise part.error(f"has {len(names)} names for {len(bounds)} pairs of bounds")
        for name, bound in zip(names, bounds, strict=True):
            if len(bound) != 2 or not all(map(math.isfinite, bound)) or bound[0] >= bound[1]:
                raise part.error(f"has the bounds {bound} for {name}; two numbers, low < high")
        return made

    @property
    def longest(self) -> tuple[float, ...]:
        """Maximum motion of each joint per control step, in rad or m."""
        return self.mode.longest

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each number, without that of the robot."""
        return self.mode.names

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bound of each number, in physical units."""
        return self.mode.bounds

    def after(self, joints: Sequence[float], values: Sequence[float], /) -> Sequence[float]:
        """The commanded joint positions after an action."""
        with self.part.at_work():
            return self._counted("after", self.mode.after(joints, values), len(joints), "joints")

    def command(self, values: Sequence[float]) -> Targets:
        """Command the motors by the numbers of an action."""
        with self.part.at_work():
            targets = self.mode.command(values)
            if targets is None:
                return None
            return self._counted("command", targets, len(self.arm.longest), "joints")

    def leading_to(self, joints: Sequence[float], start: Sequence[float], /) -> Sequence[float]:
        """The numbers that command the arm to given joint positions."""
        with self.part.at_work():
            action = self.mode.leading_to(joints, start)
            return self._counted("leading_to", action, len(self.mode.names), "names")

    def _counted(
        self, method: str, values: Sequence[float], count: int, of: str
    ) -> Sequence[float]:
        if len(values) != count:
            wrong = f"returns {len(values)} numbers from `{method}`, for {count} {of}"
            raise self.part.error(wrong)
        return values
